"""The XML front end of ROS 2's launch."""
