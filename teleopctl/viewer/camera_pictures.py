"""Pictures of the robot's cameras for a page around the 3D view, which has no panels."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.node import Clock, ClockType
from teleopctl.pictures import Picture, PictureError
from teleopctl.viewer.displays.sensors.images import ImageFeed
from teleopctl.viewer.panels.camera import camera_topics, image_topics
from teleopctl.viewer.subscriptions import topic_qos

if TYPE_CHECKING:
    from teleopctl.viewer.viewer import Viewer

_WIDTH_PX = 480
# Period in which a new image is looked for, s; `ImageFeed` shows at most twelve a second.
_PERIOD_S = 0.04
# Parts of the names of topics whose images are no pictures in colour.
_NO_COLOUR = ("depth", "disparity", "labels_map", "/ir", "infra")


class CameraPictures:
    """Newest pictures of cameras, each subscribed to and compressed once, and only if looked at.

    The subscription is that of the camera's panel, if a browser shows it, too.

    Args:
        viewer: The viewer's node. All methods are called on its thread.
    """

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._feeds: dict[str, _Feed] = {}

    def topics(self) -> list[str]:
        """Return the image topics of the cameras that look in colour, one for each."""
        found = camera_topics(image_topics(self._viewer))
        return [topic for topic in found if not any(part in topic for part in _NO_COLOUR)]

    def watch(self, topic: str, show: Callable[[Picture], object]) -> Callable[[], None]:
        """Call a function with each picture of a topic; return a function that ends this.

        Args:
            topic: One of `topics`; another one gives no pictures.
            show: Called on the node's thread.
        """
        feed = self._feeds.get(topic)
        if feed is None:
            types = image_topics(self._viewer)
            if topic not in types:
                return lambda: None
            feed = self._feeds[topic] = _Feed(self._viewer, topic, types[topic])
        feed.watchers = (*feed.watchers, show)
        if feed.newest is not None:
            show(feed.newest)

        def end() -> None:
            feed.watchers = tuple(each for each in feed.watchers if each is not show)
            if not feed.watchers and self._feeds.get(topic) is feed:
                del self._feeds[topic]
                feed.close()

        return end


class _Feed:
    """Subscription to an image topic with the functions that get its pictures."""

    def __init__(self, viewer: Viewer, topic: str, type_name: str) -> None:
        self.watchers: tuple[Callable[[Picture], object], ...] = ()
        self.newest: Picture | None = None
        self._viewer = viewer
        self._feed = ImageFeed(viewer, self._take, _WIDTH_PX)
        qos = topic_qos(viewer, topic, {})
        qos.depth = 1
        self._end = viewer.subscribe(topic, type_name, self._feed.add, qos)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = viewer.create_timer(_PERIOD_S, self._feed.tick, clock=steady)

    def _take(self, _message: object, picture: Picture | PictureError) -> None:
        if isinstance(picture, Picture):
            self.newest = picture
            for show in self.watchers:
                show(picture)

    def close(self) -> None:
        """Unsubscribe."""
        self._end()
        self._viewer.destroy_timer(self._timer)
        self._feed.clear()
