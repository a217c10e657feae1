"""Gazebo plug-ins that move a robot, converted to equivalent ros2_control controllers."""
