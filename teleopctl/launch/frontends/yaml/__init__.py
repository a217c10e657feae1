"""The YAML front end of ROS 2's launch."""
