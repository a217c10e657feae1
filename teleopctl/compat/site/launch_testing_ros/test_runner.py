"""``launch_testing_ros.test_runner``: the test runner of ``launch_testing``."""

from launch_testing.test_runner import LaunchTestRunner

__all__ = ["LaunchTestRunner"]
