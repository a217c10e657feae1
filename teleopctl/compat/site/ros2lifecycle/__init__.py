"""``ros2lifecycle``. Functions of the command line about lifecycle nodes."""
