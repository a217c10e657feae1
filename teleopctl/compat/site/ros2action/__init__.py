"""``ros2action``. Functions of the command line about actions."""
