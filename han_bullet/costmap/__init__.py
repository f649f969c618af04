"""What the floor costs the robot: a grid, and layers that raise its costs."""
