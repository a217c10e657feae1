"""Displays of points: ``PointCloud2``, ``PointCloud`` and ``LaserScan``, and their base.

A message is drawn at the pose of its frame at its stamp, and kept until that pose is known. Of
newer messages only the last is kept. Messages are converted to points in another thread.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from teleopctl.node import QoSProfile, Time
from teleopctl.tf import Transform, TransformException, stamp_of
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.sensors.cloud import (
    Cloud,
    CloudError,
    Floats,
    has_moved,
    read_cloud,
    read_legacy_cloud,
    read_scan,
)
from teleopctl.viewer.displays.sensors.colors import COLOR_PROPERTIES, Coloring, Colors
from teleopctl.viewer.displays.sensors.points_node import BOXES, STYLES, PointsNode
from teleopctl.viewer.displays.stamped import no_transform_text, pose_at_stamp

if TYPE_CHECKING:
    from teleopctl.tf import Quaternion

# Any: messages, whose classes are created from definitions at run time.

# A higher rate is hardly visible, and costs bandwidth, and CPU time of page and browser.
_CLOUDS_PER_S = 10.0
# A transform that is later than this is no longer expected.
_LONGEST_WAIT_S = 1.0
# Largest number of clouds and points kept with a decay time.
_MOST_CLOUDS = 60
_MOST_POINTS_KEPT = 1_000_000
_MOST_BOXES = 20_000

POINT_PROPERTIES = (
    Property("Style", "Flat Squares", choices=STYLES),
    Property("Size (m)", 0.01, low=0.0001, high=100.0),
    Property("Size (Pixels)", 3, low=1, high=100, hint="Of Points"),
    Property("Alpha", 1.0, low=0.0, high=1.0, hint="Between 0 and 1 for boxes only"),
    Property("Decay Time", 0.0, low=0.0, high=3600.0, hint="Seconds; 0 is the latest only"),
    Property(
        "Point Budget",
        150_000,
        low=100,
        high=2_000_000,
        hint="Largest number of points per message",
    ),
    *COLOR_PROPERTIES,
)


@dataclass(frozen=True, slots=True)
class PointJob:
    """Input of a conversion in another thread: a message of points, its pose and properties.

    Attributes:
        message: Message to convert.
        fixed: Name of the fixed frame.
        pose: Pose of the message's frame in the fixed frame, at the message's stamp.
        motion: Motion of the sensor during the measurement; None for a sensor at rest.
        coloring: Colour properties of the display.
        max_points: Largest number of points.
    """

    message: Any
    fixed: str
    pose: Transform
    motion: Transform | None
    coloring: Coloring
    max_points: int


@dataclass(frozen=True, slots=True)
class ColoredPoints:
    """Points with colours, converted from a message and ready to be drawn.

    Attributes:
        center: Centre of the points in the message's frame.
        points: Coordinates relative to the centre, (n, 3).
        colors: Colours, (n, 3), or one for all, (3,).
        total: Number of points in the message.
        transformer: Name of the colour transformer that was used.
        spacing: See `Cloud`.
    """

    center: tuple[float, float, float]
    points: Floats
    colors: Colors
    total: int
    transformer: str
    spacing: float = 0.0


@dataclass(slots=True)
class _Drawn:
    """A message's points in the scene, and the time at which they are removed."""

    node: PointsNode
    job: PointJob
    drawable: ColoredPoints
    until: float


class PointsDisplay(Display):
    """Base of displays that draw messages as points, such as clouds and scans."""

    properties: ClassVar[tuple[Property, ...]] = POINT_PROPERTIES

    def _prepare(self) -> None:
        # Any: the message that waits for its transform, and the newest one after it
        self._waiting: Any = None
        self._newest: Any = None
        self._since = 0.0
        self._due = 0.0
        self._turn = 0
        self._busy = False
        self._ready: tuple[PointJob, ColoredPoints] | None = None
        self._drawn_ones: deque[_Drawn] = deque()
        self._count = 0
        self._fares = (OK, "")

    def read(self, job: PointJob) -> Cloud:
        """Return the points of the job's message; called in another thread.

        Override.

        Raises:
            CloudError: The message is not valid.
        """
        raise NotImplementedError

    def point_size_m(self, colored_points: ColoredPoints) -> float:  # noqa: ARG002 -- for overrides
        """Return the size of the drawn points in metres: the property ``Size (m)``."""
        return self.values.number("Size (m)")

    def duration_ns(self, message: Any) -> int:  # noqa: ARG002 -- for overrides
        """Return the duration of a message's measurement in nanoseconds; 0 unless overridden."""
        return 0

    def qos(self) -> QoSProfile:
        """Return the QoS of `Display.qos` with a depth of 1: only the newest message is drawn."""
        qos = super().qos()
        qos.depth = 1
        return qos

    def stopped(self) -> None:
        """Remove the points from the scene, and drop waiting messages."""
        self._turn += 1
        self._waiting = self._newest = self._ready = None
        while self._drawn_ones:
            self._drawn_ones.popleft().node.remove()
        self._fares = (OK, "")

    def changed(self, name: str) -> None:  # noqa: ARG002 -- every property changes all points
        """Draw the last message again with the changed property."""
        newest = self._newest_message()
        self.stopped()
        self._newest, self._due = newest, 0.0

    def _newest_message(self) -> Any:
        """Return the waiting message, else the one drawn last, or None."""
        last = self._drawn_ones[-1].job.message if self._drawn_ones else self._waiting
        return self._newest if self._newest is not None else last

    def received(self, message: Any) -> None:
        """Store a message, to be converted and drawn by a later `tick`."""
        self.set_status(*self._fares)
        self._newest = message

    def tick(self) -> None:
        """Draw converted points, convert the next message, and remove expired points."""
        self._draw_ready()
        self._update_fixed_frame()
        now = time.monotonic()
        while len(self._drawn_ones) > 1 and self._is_over(now):
            self._drawn_ones.popleft().node.remove()
        if self._busy or now < self._due:
            return
        if self._waiting is None:
            self._waiting, self._newest, self._since = self._newest, None, now
        if self._waiting is not None:
            self._begin(self._waiting, now)
        self.set_status(*self._fares)

    def _is_over(self, now: float) -> bool:
        drawn = self._drawn_ones
        return (
            drawn[0].until <= now
            or len(drawn) > _MOST_CLOUDS
            or sum(len(one.drawable.points) for one in drawn) > _MOST_POINTS_KEPT
        )

    # --- conversion of messages -----------------------------------------------------------------

    def _begin(self, message: Any, now: float) -> None:
        header, frames = message.header, self.stage.frames
        try:
            pose = pose_at_stamp(frames, header)
            motion = self._motion(pose, message)
        except TransformException as error:
            self._fares = (WARN, no_transform_text(header, frames.fixed, error))
            if self._newest is not None and now - self._since > _LONGEST_WAIT_S:
                self._waiting = None
            return
        self._waiting, self._busy = None, True
        # Relative to the last due time, unless that is long ago, so that the rate is kept.
        self._due = max(self._due + 1.0 / _CLOUDS_PER_S, now)
        boxes = self.values.text("Style") == BOXES
        budget = int(self.values.number("Point Budget"))
        job = PointJob(
            message,
            frames.fixed,
            pose,
            motion,
            Coloring.from_properties(self.values),
            min(budget, _MOST_BOXES) if boxes else budget,
        )
        turn = self._turn
        self.stage.run_in_background(
            lambda: self._convert(job), lambda done: self._done(turn, job, done)
        )

    def _motion(self, pose: Transform, message: Any) -> Transform | None:
        duration, header = self.duration_ns(message), message.header
        begin = stamp_of(header.stamp)
        if not duration or begin <= 0:
            return None
        end = self.stage.frames.pose_in_fixed_frame(
            header.frame_id, Time(nanoseconds=begin + duration)
        )
        return None if end == pose else pose.inverse() @ end

    def _convert(self, job: PointJob) -> ColoredPoints:
        cloud = self.read(job)
        if not len(cloud.points):
            nothing = np.empty((0, 3), np.uint8)
            return ColoredPoints((0.0, 0.0, 0.0), cloud.points, nothing, cloud.total, "")
        colors, transformer = job.coloring.colors(cloud, job.pose)
        # Coordinates relative to the centre need fewer digits.
        center = (cloud.points.min(axis=0) + cloud.points.max(axis=0)) / 2.0
        x, y, z = (float(part) for part in center)
        return ColoredPoints(
            (x, y, z), cloud.points - center, colors, cloud.total, transformer, cloud.spacing
        )

    def _done(self, turn: int, job: PointJob, done: Any) -> None:
        self._busy = False
        if turn != self._turn or not self.is_drawn:
            return
        if isinstance(done, CloudError):
            self._fares = (ERROR, done.message)
        elif isinstance(done, BaseException):
            self._fares = (ERROR, f"{type(done).__name__}: {done}")
        else:
            self._ready = (job, done)
            return
        self.set_status(*self._fares)

    # --- drawing --------------------------------------------------------------------------------

    def _draw_ready(self) -> None:
        if self._ready is None:
            return
        job, drawable = self._ready
        self._ready = None
        decay = self.values.number("Decay Time")
        if decay <= 0.0 and self._drawn_ones:
            drawn = self._drawn_ones[-1]
            drawn.job, drawn.drawable = job, drawable
        else:
            self._count += 1
            node = PointsNode(self.stage.scene, f"{self.root}/{self._count}")
            drawn = _Drawn(node, job, drawable, time.monotonic() + decay)
            self._drawn_ones.append(drawn)
        values = self.values
        drawn.node.draw(
            drawable.points,
            drawable.colors,
            values.text("Style"),
            self.point_size_m(drawable),
            int(values.number("Size (Pixels)")),
            values.number("Alpha"),
        )
        self._place(drawn, job.pose)
        self._fares = self.status_of(drawable)
        self.set_status(*self._fares)

    def status_of(self, colored_points: ColoredPoints) -> tuple[str, str]:
        """Return level and text of the status: number of points, any replaced transformer."""
        shown, total = len(colored_points.points), colored_points.total
        count = f"{shown:,} points" if shown == total else f"{shown:,} of {total:,} points"
        chosen, used = self.values.given.get("Color Transformer"), colored_points.transformer
        if shown and chosen and chosen != used:
            return OK, f"{count}; coloured by {used}, since {chosen} needs other channels"
        return OK, count

    def _place(self, drawn: _Drawn, pose: Transform) -> None:
        place = pose @ Transform(drawn.drawable.center)
        x, y, z, w = place.rotation
        rotation: Quaternion = (w, x, y, z)
        drawn.node.set_pose(place.translation, rotation)

    def _update_fixed_frame(self) -> None:
        """Move the drawn points after a change of the fixed frame."""
        fixed = self.stage.frames.fixed
        for drawn in self._drawn_ones:
            job = drawn.job
            if job.fixed == fixed:
                continue
            pose = self._pose_or_none(job.message.header)
            drawn.node.show(shown=pose is not None)
            if pose is not None:
                drawn.job = replace(job, fixed=fixed, pose=pose)
                self._place(drawn, pose)

    def _pose_or_none(self, header: Any) -> Transform | None:
        try:
            return pose_at_stamp(self.stage.frames, header)
        except TransformException:
            return None


class PointCloud2(PointsDisplay):
    """RViz's ``PointCloud2`` display: points of the newest message, or within the decay time."""

    rviz_class = "PointCloud2"
    message_type = "sensor_msgs/msg/PointCloud2"

    def read(self, job: PointJob) -> Cloud:
        """Return the points of a PointCloud2 message; called in another thread."""
        return read_cloud(job.message, job.max_points)


class PointCloud(PointsDisplay):
    """RViz's ``PointCloud`` display: points of the deprecated message type ``PointCloud``."""

    rviz_class = "PointCloud"
    message_type = "sensor_msgs/msg/PointCloud"

    def read(self, job: PointJob) -> Cloud:
        """Return the points of a deprecated PointCloud message; called in another thread."""
        return read_legacy_cloud(job.message, job.max_points)


# Scanners turn several times a second; a longer duration is invalid.
_LONGEST_S = 1.0


class LaserScan(PointsDisplay):
    """RViz's ``LaserScan`` display: points of a scan, corrected by the scanner's motion."""

    rviz_class = "LaserScan"
    message_type = "sensor_msgs/msg/LaserScan"

    def duration_ns(self, message: Any) -> int:
        """Return the time from a scan's first to last ray in nanoseconds; 0 if not up to 1 s."""
        duration = float(message.time_increment) * (len(message.ranges) - 1)
        return round(duration * 1e9) if 0.0 < duration <= _LONGEST_S else 0

    def read(self, job: PointJob) -> Cloud:
        """Return the points of a LaserScan message; called in another thread."""
        motion = job.motion
        return read_scan(job.message, motion if motion is not None and has_moved(motion) else None)
