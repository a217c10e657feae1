"""``tf2_ros.static_transform_broadcaster``. Transforms that do not change."""

from teleopctl.tf import StaticTransformBroadcaster

__all__ = ["StaticTransformBroadcaster"]
