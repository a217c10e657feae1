"""``ros2node``. Functions of the command line about nodes."""
