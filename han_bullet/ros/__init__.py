"""ROS 1 from the core's side: messages without ROS, the link to the bridge's process, bags, and live robots."""
