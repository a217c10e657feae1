"""``tf2_ros.transform_listener``. What fills a buffer."""

from teleopctl.tf.listener import TransformListener

__all__ = ["TransformListener"]
