"""Floor 4: ros2_control in Python."""
