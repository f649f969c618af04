"""From a path to velocities of an omnidirectional base."""
