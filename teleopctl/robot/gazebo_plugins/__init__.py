"""Plug-ins of Gazebo that move a robot, as controllers of ros2_control that do the same."""
