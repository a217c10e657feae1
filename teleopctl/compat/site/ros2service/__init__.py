"""``ros2service``. Functions of the command line about services."""
