"""``launch_pytest.actions``."""

from launch_testing.actions import ReadyToTest

__all__ = ["ReadyToTest"]
