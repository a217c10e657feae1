"""``launch_testing_ros.test_runner``: it runs tests as that of ``launch_testing`` does."""

from launch_testing.test_runner import LaunchTestRunner

__all__ = ["LaunchTestRunner"]
