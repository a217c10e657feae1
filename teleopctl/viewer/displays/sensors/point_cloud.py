"""``PointCloud2``: clouds of points."""

from __future__ import annotations

from teleopctl.viewer.displays.sensors.cloud import Cloud, read_cloud, read_old_cloud
from teleopctl.viewer.displays.sensors.points import Job, PointsDisplay


class PointCloud2(PointsDisplay):
    """Display of a ``PointCloud2``."""

    rviz_class = "PointCloud2"
    message_type = "sensor_msgs/msg/PointCloud2"

    def read(self, job: Job) -> Cloud:
        """Return the points of a message."""
        return read_cloud(job.message, job.most)


class PointCloud(PointsDisplay):
    """Display of the deprecated ``PointCloud`` type."""

    rviz_class = "PointCloud"
    message_type = "sensor_msgs/msg/PointCloud"

    def read(self, job: Job) -> Cloud:
        """Return the points of a message."""
        return read_old_cloud(job.message, job.most)
