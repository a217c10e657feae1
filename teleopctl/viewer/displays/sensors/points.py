"""What the displays of points share: when they are drawn, where, and as what.

A message is drawn where its frame stood at its stamp. It waits until that is known, and newer ones
wait behind it, of which only the last one counts. Points are put together in another thread.
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
from teleopctl.viewer.displays.sensors.cloud import Cloud, CloudError, Floats
from teleopctl.viewer.displays.sensors.colors import COLOR_PROPERTIES, Coloring, Colors
from teleopctl.viewer.displays.sensors.points_node import BOXES, STYLES, PointsNode
from teleopctl.viewer.displays.stamped import no_transform, place_of

if TYPE_CHECKING:
    from teleopctl.tf import Quaternion

# Any stands for messages throughout: their classes are made at run time, from definitions.

# More is not seen, and each costs the page's process, the browser and what lies between.
_CLOUDS_PER_S = 10.0
# A transform that is this late does not come any more.
_PATIENCE_S = 1.0
# With a decay time, so many are kept at most, however long it is.
_MOST_CLOUDS = 60
_MOST_POINTS_KEPT = 1_000_000
_MOST_BOXES = 20_000

POINT_PROPERTIES = (
    Property("Style", "Flat Squares", choices=STYLES),
    Property("Size (m)", 0.01, low=0.0001, high=100.0),
    Property("Size (Pixels)", 3, low=1, high=100, hint="Of Points"),
    Property("Alpha", 1.0, low=0.0, high=1.0, hint="Only boxes can be seen through"),
    Property("Decay Time", 0.0, low=0.0, high=3600.0, hint="Seconds; 0 is the latest only"),
    Property(
        "Point Budget", 150_000, low=100, high=2_000_000, hint="The most that is drawn of one"
    ),
    *COLOR_PROPERTIES,
)


@dataclass(frozen=True, slots=True)
class Job:
    """A point message with the poses and properties that its drawing needs.

    Attributes:
        message: The message.
        fixed: The fixed frame of now.
        pose: Where the message's frame stood in that.
        sweep: Where the sensor stood at the message's end, in its frame; None if it stood still.
        coloring: How to colour.
        most: The most points.
    """

    message: Any
    fixed: str
    pose: Transform
    sweep: Transform | None
    coloring: Coloring
    most: int


@dataclass(frozen=True, slots=True)
class Drawable:
    """Points with colours, ready to be drawn.

    Attributes:
        center: The middle of the points in their frame.
        points: From there, (n, 3).
        colors: Theirs, (n, 3), or one for all, (3,).
        total: How many there were in the message.
        transformer: What gave them their colours.
        spacing: How far neighbours are from each other; see `Cloud`.
    """

    center: tuple[float, float, float]
    points: Floats
    colors: Colors
    total: int
    transformer: str
    spacing: float = 0.0


@dataclass(slots=True)
class _Drawn:
    """Points in the picture, where they belong, and until when."""

    node: PointsNode
    job: Job
    drawable: Drawable
    until: float


class PointsDisplay(Display):
    """Base of displays of points."""

    properties: ClassVar[tuple[Property, ...]] = POINT_PROPERTIES

    def _prepare(self) -> None:
        # Messages: the one that waits for its transform, and the last one behind it
        self._waiting: Any = None
        self._newest: Any = None
        self._since = 0.0
        self._due = 0.0
        self._turn = 0
        self._busy = False
        self._ready: tuple[Job, Drawable] | None = None
        self._drawn_ones: deque[_Drawn] = deque()
        self._count = 0
        self._fares = (OK, "")

    def read(self, job: Job) -> Cloud:
        """Return the points of a message; called in another thread.

        Raises:
            CloudError: It holds none that can be drawn.
        """
        raise NotImplementedError

    def size_m(self, drawable: Drawable) -> float:  # noqa: ARG002 -- for those that measure it
        """Return the size of a point in metres."""
        return self.values.number("Size (m)")

    def duration_ns(self, message: Any) -> int:  # noqa: ARG002 -- for those that take their time
        """Return how long the sensor took to measure the message, in nanoseconds."""
        return 0

    def qos(self) -> QoSProfile:
        """Return a best-effort QoS: only the newest message is drawn."""
        qos = super().qos()
        qos.depth = 1
        return qos

    def stopped(self) -> None:
        """Remove the points from the scene, and drop pending messages."""
        self._turn += 1
        self._waiting = self._newest = self._ready = None
        while self._drawn_ones:
            self._drawn_ones.popleft().node.remove()
        self._fares = (OK, "")

    def changed(self, name: str) -> None:  # noqa: ARG002 -- each of them changes all points
        """Redraw the points that are drawn."""
        newest = self._newest_message()
        self.stopped()
        self._newest, self._due = newest, 0.0

    def _newest_message(self) -> Any:
        """The message that is to be drawn next, or again; None for none."""
        last = self._drawn_ones[-1].job.message if self._drawn_ones else self._waiting
        return self._newest if self._newest is not None else last

    def received(self, message: Any) -> None:
        """Store a message, to be drawn with the next picture."""
        self.say(*self._fares)
        self._newest = message

    def tick(self) -> None:
        """Draw what is ready, start on the next message, and remove what is too old."""
        self._draw_ready()
        self._stay_in_place()
        now = time.monotonic()
        while len(self._drawn_ones) > 1 and self._is_over(now):
            self._drawn_ones.popleft().node.remove()
        if self._busy or now < self._due:
            return
        if self._waiting is None:
            self._waiting, self._newest, self._since = self._newest, None, now
        if self._waiting is not None:
            self._begin(self._waiting, now)
        self.say(*self._fares)

    def _is_over(self, now: float) -> bool:
        drawn = self._drawn_ones
        return (
            drawn[0].until <= now
            or len(drawn) > _MOST_CLOUDS
            or sum(len(one.drawable.points) for one in drawn) > _MOST_POINTS_KEPT
        )

    # --- a message becomes points ---------------------------------------------------------------

    def _begin(self, message: Any, now: float) -> None:
        header, frames = message.header, self.stage.frames
        try:
            pose = place_of(frames, header)
            sweep = self._sweep(pose, message)
        except TransformException as error:
            self._fares = (WARN, no_transform(header, frames.fixed, error))
            if self._newest is not None and now - self._since > _PATIENCE_S:
                self._waiting = None
            return
        self._waiting, self._busy = None, True
        # On from when it was due, unless that is long ago, so that the rate is kept.
        self._due = max(self._due + 1.0 / _CLOUDS_PER_S, now)
        boxes = self.values.text("Style") == BOXES
        budget = int(self.values.number("Point Budget"))
        job = Job(
            message,
            frames.fixed,
            pose,
            sweep,
            Coloring.of(self.values),
            min(budget, _MOST_BOXES) if boxes else budget,
        )
        turn = self._turn
        self.stage.work(lambda: self._put_together(job), lambda done: self._done(turn, job, done))

    def _sweep(self, pose: Transform, message: Any) -> Transform | None:
        duration, header = self.duration_ns(message), message.header
        begin = stamp_of(header.stamp)
        if not duration or begin <= 0:
            return None
        end = self.stage.frames.pose_in_fixed(header.frame_id, Time(nanoseconds=begin + duration))
        return None if end == pose else pose.inverse() @ end

    def _put_together(self, job: Job) -> Drawable:
        cloud = self.read(job)
        if not len(cloud.points):
            nothing = np.empty((0, 3), np.uint8)
            return Drawable((0.0, 0.0, 0.0), cloud.points, nothing, cloud.total, "")
        colors, transformer = job.coloring.colors(cloud, job.pose)
        # Around their middle they need fewer digits.
        center = (cloud.points.min(axis=0) + cloud.points.max(axis=0)) / 2.0
        x, y, z = (float(part) for part in center)
        return Drawable(
            (x, y, z), cloud.points - center, colors, cloud.total, transformer, cloud.spacing
        )

    def _done(self, turn: int, job: Job, done: Any) -> None:
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
        self.say(*self._fares)

    # --- points become part of the picture ------------------------------------------------------

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
            self.size_m(drawable),
            int(values.number("Size (Pixels)")),
            values.number("Alpha"),
        )
        self._place(drawn, job.pose)
        self._fares = self.verdict(drawable)
        self.say(*self._fares)

    def verdict(self, drawable: Drawable) -> tuple[str, str]:
        """Return the status of drawn points: their number and any fault."""
        shown, total = len(drawable.points), drawable.total
        count = f"{shown:,} points" if shown == total else f"{shown:,} of {total:,} points"
        chosen = self.values.given.get("Color Transformer")
        if shown and chosen and chosen != drawable.transformer:
            return (
                OK,
                f"{count}; coloured by {drawable.transformer}, not having what {chosen} needs",
            )
        return OK, count

    def _place(self, drawn: _Drawn, pose: Transform) -> None:
        place = pose @ Transform(drawn.drawable.center)
        x, y, z, w = place.rotation
        rotation: Quaternion = (w, x, y, z)
        drawn.node.place(place.translation, rotation)

    def _stay_in_place(self) -> None:
        """In another fixed frame everything stands elsewhere."""
        fixed = self.stage.frames.fixed
        for drawn in self._drawn_ones:
            job = drawn.job
            if job.fixed == fixed:
                continue
            pose = self._pose_again(job.message.header)
            drawn.node.show(shown=pose is not None)
            if pose is not None:
                drawn.job = replace(job, fixed=fixed, pose=pose)
                self._place(drawn, pose)

    def _pose_again(self, header: Any) -> Transform | None:
        try:
            return place_of(self.stage.frames, header)
        except TransformException:
            return None
