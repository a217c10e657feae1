"""``tf2_ros.static_transform_broadcaster``. Transforms that do not change."""

from teleopctl.tf.broadcaster import StaticTransformBroadcaster

__all__ = ["StaticTransformBroadcaster"]
