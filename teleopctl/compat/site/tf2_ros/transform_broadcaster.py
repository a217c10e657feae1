"""``tf2_ros.transform_broadcaster``. Transforms that change."""

from teleopctl.tf import TransformBroadcaster

__all__ = ["TransformBroadcaster"]
