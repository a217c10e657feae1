"""``ros2pkg``. Functions of the command line about packages."""
