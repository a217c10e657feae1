"""``tf2_ros.buffer``. Transforms of the last seconds."""

from teleopctl.tf import Buffer

__all__ = ["Buffer"]
