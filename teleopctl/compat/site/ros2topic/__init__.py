"""``ros2topic``. Functions of the command line about topics."""
