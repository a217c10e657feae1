"""``launch_testing``, ``launch_testing_ros`` and ``launch_pytest``."""
