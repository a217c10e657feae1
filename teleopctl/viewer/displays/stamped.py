"""Displays of messages with a header: each is drawn where its frame stood at its time."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

from teleopctl.node import Time
from teleopctl.tf import Transform, TransformException
from teleopctl.viewer.displays.base import OK, WARN, Display

if TYPE_CHECKING:
    from teleopctl.viewer.scene.frames import SceneFrames

# Any stands for messages throughout: their classes are made at run time, from definitions.

# As many as RViz's filter lets wait for their transforms.
_WAITING = 10


class StampedDisplay(Display):
    """Base of displays that draw the newest stamped messages.

    A message whose frame or time is not known yet waits for its transform. Where newer ones arrive
    meanwhile, the newest that can be placed is drawn, so that a late tf delays the picture but
    never empties it. What tf has already forgotten, such as a map that was published once long
    ago, is drawn where its frame stands now.

    Attributes:
        keeps: How many messages are drawn.
    """

    def _prepare(self) -> None:
        self._waiting: deque[Any] = deque(maxlen=_WAITING)
        self._placed: deque[Any] = deque()
        self._fixed = ""
        self._waits = False

    @property
    def keeps(self) -> int:
        """Number of messages that are drawn."""
        return 1

    # --- what a kind of display defines -------------------------------------------------------

    def placed(self, message: Any, pose: Transform) -> None:
        """Draw a message at the pose of its frame.

        Args:
            message: The message.
            pose: Where its frame stands in the fixed frame.
        """

    def emptied(self) -> None:
        """Remove everything from the scene."""

    # --- what the viewer calls ----------------------------------------------------------------

    def received(self, message: Any) -> None:
        """Draw a message as soon as its transform is known."""
        self._waiting.append(message)
        self._place()

    def tick(self) -> None:
        """Draw messages whose transform has arrived; redraw all if the fixed frame changed."""
        if self.stage.frames.fixed != self._fixed:
            self.draw_anew()
        elif self._waiting:
            self._place()

    def changed(self, name: str) -> None:  # noqa: ARG002 -- whichever it is
        """Redraw the messages with a changed property."""
        self.draw_anew()

    def stopped(self) -> None:
        """Drop all messages."""
        self._waiting.clear()
        self._placed.clear()
        self._waits = False
        self.emptied()

    def draw_anew(self) -> None:
        """Redraw all messages."""
        again = [*self._placed, *self._waiting][-max(self.keeps, _WAITING) :]
        self._placed.clear()
        self._waiting = deque(again, maxlen=max(self.keeps, _WAITING))
        self.emptied()
        self._place()

    # --- its own ------------------------------------------------------------------------------

    def _place(self) -> None:
        self._fixed = self.stage.frames.fixed
        waiting, keeps = list(self._waiting), self.keeps
        self._waiting.clear()
        left: list[Any] = []
        reason = ""
        # From the newest, since of a display that keeps one the older ones do not matter.
        found: list[tuple[Any, Transform]] = []
        for message in reversed(waiting):
            if len(found) >= keeps:
                break
            try:
                found.append((message, place_of(self.stage.frames, message.header)))
            except TransformException as error:
                left.append(message)
                reason = reason or no_transform(message.header, self.stage.frames.fixed, error)
        self._waiting.extend(reversed(left))
        for message, pose in reversed(found):
            if self._waits:
                self._waits = False
                self.say(OK)
            self._placed.append(message)
            while len(self._placed) > max(keeps, 1):
                self._placed.popleft()
            self.placed(message, pose)
        if reason and not found:
            self._waits = True
            self.say(WARN, reason)


# Any stands for a std_msgs/msg/Header.
def place_of(frames: SceneFrames, header: Any) -> Transform:
    """Return the pose of a header's frame at its stamp, in the fixed frame.

    An empty name stands for the fixed frame. What is older than anything that tf remembers is
    placed where its frame stands now.

    Raises:
        TransformException: That is not known, or not yet.
    """
    if not header.frame_id:
        return Transform()
    # A time before 1970 is none.
    stamp_ns = max(header.stamp.sec * 1_000_000_000 + header.stamp.nanosec, 0)
    try:
        return frames.pose_in_fixed(header.frame_id, Time(nanoseconds=stamp_ns))
    except TransformException:
        frame = header.frame_id.removeprefix("/")
        newest, pose = frames.buffer.lookup(frames.fixed, frame, 0)
        if stamp_ns > newest:
            raise
        return pose


def no_transform(header: Any, fixed: str, error: TransformException) -> str:
    """Return RViz's sentence about a message without a transform."""
    from teleopctl.tf import ExtrapolationException

    pair = f"No transform from [{header.frame_id}] to [{fixed}]"
    if isinstance(error, ExtrapolationException):
        return f"{pair} at the message's time yet"
    return pair
