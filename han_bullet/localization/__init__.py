"""Where the robot is: odometry and laser against the map."""
