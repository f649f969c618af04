"""Whether the robot's sensors work, from what they send alone."""
