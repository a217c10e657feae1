"""``PointCloud2``: clouds of points."""

from __future__ import annotations

from teleopctl.viewer.displays.sensors.cloud import Cloud, read_cloud, read_old_cloud
from teleopctl.viewer.displays.sensors.points import Job, PointsDisplay


class PointCloud2(PointsDisplay):
    """The points of a depth camera or a three-dimensional scanner."""

    rviz_class = "PointCloud2"
    message_type = "sensor_msgs/msg/PointCloud2"

    def read(self, job: Job) -> Cloud:
        """Read the points of a message."""
        return read_cloud(job.message, job.most)


class PointCloud(PointsDisplay):
    """The points of a program that still publishes the type that ``PointCloud2`` has replaced."""

    rviz_class = "PointCloud"
    message_type = "sensor_msgs/msg/PointCloud"

    def read(self, job: Job) -> Cloud:
        """Read the points of a message."""
        return read_old_cloud(job.message, job.most)
