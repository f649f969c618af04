"""The ROS 1 node, a process of its own under the system's python3; of this package the core imports `wire` alone."""
