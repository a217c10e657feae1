"""What the displays of a camera's pictures share."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.node import QoSProfile
from teleopctl.pictures import COMPRESSED, RAW, GreyRange, Picture, PictureError
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.picture_feed import PictureFeed, type_by_name
from teleopctl.viewer.displays.properties import Property

# Any stands for messages throughout: their classes are made at run time, from definitions.

GREY_PROPERTIES = (
    Property("Normalize Range", True, hint="Black and white are the least and the most measured"),
    Property("Min Value", 0.0, hint="Black, where the range is not normalized"),
    Property("Max Value", 1.0, hint="White, where the range is not normalized"),
    Property("Median window", 5, low=1, high=1000, hint="Pictures whose range counts"),
)
_GREY = frozenset(known.name for known in GREY_PROPERTIES)


class PictureDisplay(Display):
    """Base of displays of images, raw or compressed, with rate and size in their status."""

    message_type = RAW
    other_types: ClassVar[tuple[str, ...]] = (COMPRESSED,)
    properties: ClassVar[tuple[Property, ...]] = GREY_PROPERTIES

    def _prepare(self) -> None:
        self._feed = PictureFeed(self.stage, self._take_picture)
        self._fares = (OK, "")

    def type_of_topic(self) -> str:
        """Return the type of the image topic: the published one, else by the topic's name."""
        if self.stage.node.get_publishers_info_by_topic(self.topic):
            return super().type_of_topic()
        return type_by_name(self.topic)

    def qos(self) -> QoSProfile:
        """Return a best-effort QoS: only the newest image is shown."""
        qos = super().qos()
        qos.depth = 1
        return qos

    def started(self) -> None:
        """Set the range of grey from the properties."""
        values = self.values
        self._feed.shades = GreyRange(
            automatic=values.flag("Normalize Range"),
            low=values.number("Min Value"),
            high=values.number("Max Value"),
            window=int(values.number("Median window")),
        )

    def stopped(self) -> None:
        """Drop pending images."""
        self._feed.clear()
        self._fares = (OK, "")

    def changed(self, name: str) -> None:
        """Show the last image with another range of grey."""
        if name in _GREY:
            PictureDisplay.started(self)
            self._feed.again()

    def received(self, message: Any) -> None:
        """Store an image, to be shown with the next picture."""
        self.say(*self._fares)
        self._feed.take(message)

    def tick(self) -> None:
        """Show the newest image, if it is due."""
        self._feed.tick()

    def time_jumped_back(self) -> None:
        """Do nothing: images have no time here."""

    def _take_picture(self, message: Any, picture: Picture | PictureError) -> None:
        if not self.is_drawn:
            return
        if isinstance(picture, PictureError):
            self._fares = (ERROR, picture.message)
        else:
            size = f"{picture.width} x {picture.height}, {picture.encoding}"
            rate = f", {self._feed.rate:.3g} Hz" if self._feed.rate else ""
            self._fares = (WARN, picture.left_out) if picture.left_out else (OK, size + rate)
            self.show(message, picture)
        self.say(*self._fares)

    def show(self, message: Any, picture: Picture) -> None:
        """Show a decoded image."""
        raise NotImplementedError
