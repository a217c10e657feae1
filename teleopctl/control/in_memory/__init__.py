"""Control stack and nodes in memory, for tests of controllers without a ROS graph."""
