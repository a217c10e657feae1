"""``tf2_ros.transform_broadcaster``. Transforms that change."""

from teleopctl.tf.broadcaster import TransformBroadcaster

__all__ = ["TransformBroadcaster"]
