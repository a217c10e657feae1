"""``ros2param``. Functions of the command line about parameters."""
