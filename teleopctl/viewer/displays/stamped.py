"""Bases of displays whose messages have a header: drawn at the pose of its frame at its stamp."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

from teleopctl.node import Time
from teleopctl.tf import Transform, TransformException
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing, merged

if TYPE_CHECKING:
    from teleopctl.viewer.scene.frames import SceneFrames

# Any: messages, whose classes are created from definitions at run time.

# Queue size of RViz's message filter.
_WAITING = 10


class StampedDisplay(Display):
    """Base of displays that draw the newest messages, each at its frame's pose at its stamp.

    A message is queued until its transform is known, as in RViz's message filter. Of several queued
    messages, the newest with a transform is drawn, so that late tf delays the drawing but never
    clears it. A message older than the tf buffer, such as a latched map, is drawn at its frame's
    newest pose.

    Attributes:
        history_length: Number of messages that are drawn.
    """

    def _prepare(self) -> None:
        self._waiting: deque[Any] = deque(maxlen=_WAITING)
        self._placed: deque[Any] = deque()
        self._fixed = ""
        self._waits = False

    @property
    def history_length(self) -> int:
        """Largest number of messages drawn at a time; 1 unless a display overrides it."""
        return 1

    # --- overridden by displays ---------------------------------------------------------------

    def draw_at(self, message: Any, pose: Transform) -> None:
        """Draw a message at a pose, called once the message's transform is known.

        Override.

        Args:
            message: Message to draw.
            pose: Pose of the message's frame in the fixed frame, at the message's stamp.
        """

    def clear_drawings(self) -> None:
        """Remove all drawings from the scene, but keep the messages.

        Override.
        """

    # --- called by the viewer -----------------------------------------------------------------

    def received(self, message: Any) -> None:
        """Draw a message, or queue it until its transform is known."""
        self._waiting.append(message)
        self._place()

    def tick(self) -> None:
        """Draw messages whose transform has arrived; redraw all if the fixed frame changed."""
        if self.stage.frames.fixed != self._fixed:
            self.redraw()
        elif self._waiting:
            self._place()

    def changed(self, name: str) -> None:  # noqa: ARG002 -- the same for every property
        """Redraw all kept messages after a property was set."""
        self.redraw()

    def stopped(self) -> None:
        """Drop all messages, and remove their drawings; called when the display stops."""
        self._waiting.clear()
        self._placed.clear()
        self._waits = False
        self.clear_drawings()

    def redraw(self) -> None:
        """Draw all kept messages again, with the present transforms and properties."""
        again = [*self._placed, *self._waiting][-max(self.history_length, _WAITING) :]
        self._placed.clear()
        self._waiting = deque(again, maxlen=max(self.history_length, _WAITING))
        self.clear_drawings()
        self._place()

    # --- transforms ---------------------------------------------------------------------------

    def _place(self) -> None:
        self._fixed = self.stage.frames.fixed
        waiting, keeps = list(self._waiting), self.history_length
        self._waiting.clear()
        left: list[Any] = []
        reason = ""
        # From the newest: older messages beyond `history_length` are not drawn.
        found: list[tuple[Any, Transform]] = []
        for message in reversed(waiting):
            if len(found) >= keeps:
                break
            try:
                found.append((message, pose_at_stamp(self.stage.frames, message.header)))
            except TransformException as error:
                left.append(message)
                reason = reason or no_transform_text(message.header, self.stage.frames.fixed, error)
        self._waiting.extend(reversed(left))
        for message, pose in reversed(found):
            if self._waits:
                self._waits = False
                self.set_status(OK)
            self._placed.append(message)
            while len(self._placed) > max(keeps, 1):
                self._placed.popleft()
            self.draw_at(message, pose)
        if reason and not found:
            self._waits = True
            self.set_status(WARN, reason)


# Any: a std_msgs/msg/Header.
def pose_at_stamp(frames: SceneFrames, header: Any) -> Transform:
    """Return a header frame's pose in the fixed frame at the stamp; the newest if that is too old.

    An empty frame means the fixed frame. For a stamp older than the tf buffer the newest pose is
    returned.

    Raises:
        TransformException: The transform is not known, or not yet.
    """
    if not header.frame_id:
        return Transform()
    # A stamp before 1970 is treated as unset.
    stamp_ns = max(header.stamp.sec * 1_000_000_000 + header.stamp.nanosec, 0)
    try:
        return frames.pose_in_fixed_frame(header.frame_id, Time(nanoseconds=stamp_ns))
    except TransformException:
        frame = header.frame_id.removeprefix("/")
        newest, pose = frames.buffer.lookup(frames.fixed, frame, 0)
        if stamp_ns > newest:
            raise
        return pose


def no_transform_text(header: Any, fixed: str, error: TransformException) -> str:
    """Return the status text that a message's transform is not known, in RViz's words."""
    from teleopctl.tf import ExtrapolationException

    pair = f"No transform from [{header.frame_id}] to [{fixed}]"
    if isinstance(error, ExtrapolationException):
        return f"{pair} at the message's time yet"
    return pair


class DrawnDisplay(StampedDisplay):
    """Base of displays that convert each message to a `Drawing` and show all in one canvas."""

    def _prepare(self) -> None:
        super()._prepare()
        self.canvas = Canvas(self.stage.scene, self.root)
        self._drawings: deque[Drawing] = deque()
        self._stale = False

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a message, in the frame of its header. Override."""
        raise NotImplementedError

    def draw_at(self, message: Any, pose: Transform) -> None:
        """Add a message's drawing, and drop the oldest beyond `history_length`."""
        self._drawings.append(self.drawing(message).moved(pose))
        while len(self._drawings) > self.history_length:
            self._drawings.popleft()
        self._stale = True

    def tick(self) -> None:
        """Draw messages whose transform has arrived, and send changed drawings to the scene."""
        super().tick()
        if self._stale:
            self._stale = False
            self.canvas.show(self.combined_drawing())

    def combined_drawing(self) -> Drawing:
        """Return one drawing of all kept messages, in the fixed frame."""
        return merged(self._drawings)

    def clear_drawings(self) -> None:
        """Drop the drawings of all messages, and update the scene with the next `tick`."""
        self._drawings.clear()
        self._stale = True
        if not self.is_drawn:
            self._stale = False
            self.canvas.remove()
