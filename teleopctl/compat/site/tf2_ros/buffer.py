"""``tf2_ros.buffer``. Transforms of the last seconds."""

from teleopctl.tf.buffer import Buffer

__all__ = ["Buffer"]
