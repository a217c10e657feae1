"""``ros2cli``. Nodes of command-line tools; the tools themselves are ``teleopctl``'s verbs."""
