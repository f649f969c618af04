"""Where the robot is: odometry, a laser scanner and the map of the building."""
