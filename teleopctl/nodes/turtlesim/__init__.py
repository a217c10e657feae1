"""Executables of ROS 2's package ``turtlesim``, the robot of its first tutorial."""
