"""The pictures of one topic: the newest, a few times a second, decoded in another thread."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.pictures import COMPRESSED, RAW, GreyRange, Picture, PictureError, picture_of

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

_TRANSPORTS = ("compressed", "compressedDepth")
# More is not seen, and each costs the page's process and the browser.
_PICTURES_PER_S = 12.0
_ARRIVALS = 30


# Any stands for messages and for what viser gives.
class PictureFeed:
    """Decodes the newest image message in another thread, and shows it.

    Args:
        stage: Where work is done in another thread.
        show: Called on the node's thread with the message and its picture, or the error that
            says why there is none.
        width: The most pixels in a row.
    """

    def __init__(
        self,
        stage: Stage,
        show: Callable[[Any, Picture | PictureError], object],
        width: int = 640,
    ) -> None:
        self.shades = GreyRange()
        self._stage = stage
        self._show = show
        self._width = width
        self._newest: Any = None
        self._last: Any = None
        self._busy = False
        self._due = 0.0
        self._turn = 0
        self._arrivals: deque[float] = deque(maxlen=_ARRIVALS)

    @property
    def rate(self) -> float:
        """Return the recent rate of messages in Hz; 0 for fewer than two."""
        arrivals, now = self._arrivals, time.monotonic()
        if len(arrivals) < 2:
            return 0.0
        span = arrivals[-1] - arrivals[0]
        silence = now - arrivals[-1]
        if silence > 2 * span / (len(arrivals) - 1) + 1.0 or span <= 0.0:
            return 0.0
        return (len(arrivals) - 1) / span

    def take(self, message: Any) -> None:
        """Store a message, to be shown at a later `tick`."""
        self._newest = message
        self._arrivals.append(time.monotonic())

    def again(self) -> None:
        """Show the last message again, after a property was set."""
        if self._newest is None:
            self._newest = self._last

    def tick(self) -> None:
        """Start decoding the newest message, if it is due."""
        now = time.monotonic()
        if self._newest is None or self._busy or now < self._due:
            return
        # On from when it was due, unless that is long ago, so that the rate is kept.
        period = 1.0 / _PICTURES_PER_S
        self._due = max(self._due + period, now)
        message, self._newest = self._newest, None
        self._last, self._busy, turn = message, True, self._turn
        self._stage.work(
            lambda: picture_of(message, self._width, self.shades),
            lambda result: self._done(turn, message, result),
        )

    def clear(self) -> None:
        """Drop all messages, also the one being decoded."""
        self._newest = self._last = None
        self._turn += 1
        self._arrivals.clear()

    def _done(self, turn: int, message: Any, result: Any) -> None:
        self._busy = False
        if turn != self._turn:
            return
        if isinstance(result, BaseException) and not isinstance(result, PictureError):
            result = PictureError(f"{type(result).__name__}: {result}")
        self._show(message, result)


# Any: viser's handles of pictures in a panel, in the scene and in a frustum share no class.
def put(handle: Any, picture: Picture) -> None:
    """Set the picture of a viser image handle, without encoding it again.

    viser would take an array of pixels and encode it, on the thread that asks. What is encoded
    already goes into the properties that it would set.

    Args:
        handle: viser's image or camera frustum.
        picture: What to show.
    """
    handle._format = picture.format  # noqa: SLF001
    name = "_image_data" if hasattr(handle, "_image_data") else "_data"
    setattr(handle, name, picture.data)


def base_topic(topic: str) -> str:
    """Return the base topic of an image topic, without its transport."""
    head, _, tail = topic.rpartition("/")
    return head if tail in _TRANSPORTS and head else topic


def type_by_name(topic: str) -> str:
    """Return the message type of an image topic by its name, as image_transport names topics."""
    return RAW if base_topic(topic) == topic else COMPRESSED


def camera_info_topic(topic: str) -> str:
    """Return the CameraInfo topic beside an image topic."""
    return f"{base_topic(topic).rpartition('/')[0]}/camera_info"
