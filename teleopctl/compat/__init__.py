"""Beside the floors: the import names of ROS 2 Python packages."""
