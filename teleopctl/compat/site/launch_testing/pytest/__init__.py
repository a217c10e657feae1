"""``launch_testing.pytest``."""
