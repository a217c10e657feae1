"""``LaserScan``: what a scanner has hit around it."""

from __future__ import annotations

from typing import Any

from teleopctl.viewer.displays.sensors.cloud import Cloud, has_moved, read_scan
from teleopctl.viewer.displays.sensors.points import Job, PointsDisplay

# Any stands for messages throughout: their classes are made at run time, from definitions.

# A scanner turns several times a second; what claims to take longer has a wrong number in it.
_LONGEST_S = 1.0


class LaserScan(PointsDisplay):
    """Display of a laser scan, each point from the scanner's pose at its time."""

    rviz_class = "LaserScan"
    message_type = "sensor_msgs/msg/LaserScan"

    def duration_ns(self, message: Any) -> int:
        """Return the time from the first to the last ray of a scan, in nanoseconds."""
        duration = float(message.time_increment) * (len(message.ranges) - 1)
        return round(duration * 1e9) if 0.0 < duration <= _LONGEST_S else 0

    def read(self, job: Job) -> Cloud:
        """Return the points of a scan."""
        sweep = job.sweep
        return read_scan(job.message, sweep if sweep is not None and has_moved(sweep) else None)
