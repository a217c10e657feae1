"""``InteractiveMarkers``: markers of another program that are moved and clicked on the page."""

from __future__ import annotations

import secrets
import time
from typing import Any, ClassVar

from teleopctl.base.printable import printable_line
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import QoSProfile
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.markers.interactive_marker import (
    FEEDBACK_KEEP_ALIVE,
    InteractiveMarker,
)
from teleopctl.viewer.displays.markers.marker_drawing import MarkerFault
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.displays.markers.update_feed import UpdateFeed
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import pose_of

# Any stands for messages: their classes are made at run time, from definitions.

_NAMESPACE = "Interactive Markers Namespace"
_UPDATE = "/update"
_MOST_MARKERS = 500
# A server that does not answer is asked again after this.
_PATIENCE_S = 5.0
# A server refuses others for a second after the last word of who holds a marker.
_WORD_EVERY_S = 0.4


class InteractiveMarkers(Display):
    """Display of a server's interactive markers."""

    rviz_class = "InteractiveMarkers"
    message_type = "visualization_msgs/msg/InteractiveMarkerUpdate"
    topic_key: ClassVar[str] = _NAMESPACE
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Show Descriptions", True),
        Property("Show Axes", False),
    )

    def _prepare(self) -> None:
        said = self.values.given.get(_NAMESPACE) or self.values.given.get("Update Topic")
        if isinstance(said, dict):
            said = said.get("Value")
        if isinstance(said, str) and said:
            self.topic = f"{said.removesuffix(_UPDATE).rstrip('/')}{_UPDATE}"
        self.markers: dict[str, InteractiveMarker] = {}
        # What the server says of a marker while a person holds it.
        self._later: dict[str, Any] = {}
        self._client_id = f"rviz{self.root}/{secrets.token_hex(4)}"
        self._feed = UpdateFeed()
        self._files = MarkerFiles(self.stage, self._file_arrived)
        self._client: Any = None
        self._publisher: Any = None
        self._asked_at = 0.0
        self._told_at = 0.0
        self._fixed = ""
        self._numbers = 0
        self._turn = 0
        self._fault = ""

    # --- the graph ----------------------------------------------------------------------------

    def listen_to(self, topic: str) -> None:
        """Set the topic of updates, and the interactive marker namespace of the file."""
        super().listen_to(topic)
        self.values.given[_NAMESPACE] = topic.removesuffix(_UPDATE)

    def qos(self) -> QoSProfile:
        """Return a reliable QoS with a long queue: every update counts."""
        return QoSProfile(depth=100)

    def started(self) -> None:
        """Subscribe to updates and prepare to request the full state."""
        namespace = self.topic.removesuffix(_UPDATE)
        if not self.topic:
            return
        node = self.stage.node
        self._feed = UpdateFeed()
        self._asked_at = 0.0
        self._client = node.create_client(
            get_service("visualization_msgs/srv/GetInteractiveMarkers"),
            f"{namespace}/get_interactive_markers",
        )
        self._publisher = node.create_publisher(
            get_message("visualization_msgs/msg/InteractiveMarkerFeedback"),
            f"{namespace}/feedback",
            100,
        )

    def stopped(self) -> None:
        """Remove all markers from the scene."""
        self._turn += 1
        self._clear()
        if self._client is not None:
            self.stage.node.destroy_client(self._client)
            self.stage.node.destroy_publisher(self._publisher)
            self._client = self._publisher = None

    def received(self, message: Any) -> None:
        """Apply an update if it is the next one in sequence."""
        if self._feed.take(message):
            self._apply(message)
        self._say_how()

    def tick(self) -> None:
        """Request the full state if needed, and update the poses of markers."""
        if self._client is None:
            return
        now = time.monotonic()
        if self._feed.needs_state and now - self._asked_at > _PATIENCE_S:
            if self._client.service_is_ready():
                self._ask(now)
            else:
                self.say(WARN, f"Nobody offers {self._client.srv_name}")
        fixed = self.stage.frames.fixed
        camera = None
        if any(marker.faces_viewer for marker in self.markers.values()):
            camera = self.stage.camera()
        for name, marker in self.markers.items():
            marker.place_anew() if fixed != self._fixed else marker.follow()
            if camera is not None:
                marker.face(camera)
            if marker.held and now - self._told_at > _WORD_EVERY_S:
                self._tell(name, FEEDBACK_KEEP_ALIVE, marker.held, 0)
        self._fixed = fixed
        if not self._feed.needs_state:
            self._say_how()

    def changed(self, name: str) -> None:  # noqa: ARG002 -- whichever it is
        """Redraw the markers with a changed property."""
        for marker in list(self.markers.values()):
            self._draw(marker.message, marker.pose)

    def _ask(self, now: float) -> None:
        self._asked_at = now
        turn = self._turn
        future = self._client.call_async(
            get_service("visualization_msgs/srv/GetInteractiveMarkers").Request()
        )

        def answered(done: Any) -> None:
            state = None if done.exception() is not None else done.result()
            if turn == self._turn and self._feed.needs_state and state is not None:
                self._guarded(lambda: self._take_state(state))

        future.add_done_callback(answered)

    def _take_state(self, state: Any) -> None:
        self._clear()
        for message in state.markers:
            self._draw(message)
        for update in self._feed.start(state.sequence_number):
            self._apply(update)
        if self._feed.needs_state:
            self._asked_at = 0.0
        self._say_how()

    # --- the picture --------------------------------------------------------------------------

    def _apply(self, update: Any) -> None:
        for message in update.markers:
            self._draw(message)
        for moved in update.poses:
            marker, pose = self.markers.get(moved.name), pose_of(moved.pose)
            if pose is None:
                self._fault = (
                    f"{printable_line(moved.name)} is moved by numbers that are not finite"
                )
            if marker is None or pose is None:
                continue
            if moved.header.frame_id == marker.message.header.frame_id:
                marker.stand_at(pose)
            elif not marker.held:
                marker.message.header = moved.header
                self._draw(marker.message, pose)
        for name in update.erases:
            self._remove(name)
        self._files.forget_unused(set().union(*(one.files for one in self.markers.values())))

    def _draw(self, message: Any, pose: Transform | None = None) -> None:
        name = str(message.name)
        if name in self.markers and self.markers[name].held:
            self._later[name] = message
            return
        self._remove(name)
        if len(self.markers) >= _MOST_MARKERS:
            self._fault = f"There are more than {_MOST_MARKERS} markers: the last are not drawn"
            return
        self._numbers += 1

        def tell(event: int, control: str, entry: int) -> None:
            self._tell(name, event, control, entry)

        try:
            marker = InteractiveMarker(
                self.stage,
                f"{self.root}/marker{self._numbers}",
                message,
                self._files,
                tell,
                show_description=self.values.flag("Show Descriptions"),
                show_axes=self.values.flag("Show Axes"),
            )
        except MarkerFault as fault:
            self._fault = f"{printable_line(name)} {fault}"
            return
        self.markers[name] = marker
        if pose is not None:
            marker.stand_at(pose)

    def _remove(self, name: str) -> None:
        self._later.pop(name, None)
        marker = self.markers.pop(name, None)
        if marker is not None:
            marker.remove()

    def _clear(self) -> None:
        for name in list(self.markers):
            self._remove(name)
        self._fault = ""

    def _file_arrived(self) -> None:
        for marker in self.markers.values():
            marker.refresh()

    def _say_how(self) -> None:
        fault = self._fault
        for name, marker in self.markers.items():
            if fault:
                break
            if not marker.is_placed:
                frame = marker.message.header.frame_id
                fault = f"No transform from [{frame}] to [{self.stage.frames.fixed}]"
            elif marker.fault:
                fault = f"A marker of {printable_line(name)} {marker.fault}"
        fault = fault or next(iter(self._files.faults.values()), "")
        self.say(WARN if fault else OK, fault)

    # --- feedback -----------------------------------------------------------------------------

    def _tell(self, name: str, event: int, control: str, entry: int) -> None:
        marker = self.markers.get(name)
        if marker is None or self._publisher is None:
            return
        self._told_at = time.monotonic()
        feedback = get_message("visualization_msgs/msg/InteractiveMarkerFeedback")()
        feedback.header.frame_id = marker.message.header.frame_id
        feedback.header.stamp = self.stage.node.get_clock().now().to_msg()
        feedback.client_id = self._client_id
        feedback.marker_name, feedback.control_name = name, control
        feedback.event_type, feedback.menu_entry_id = event, entry
        place, turn = feedback.pose.position, feedback.pose.orientation
        place.x, place.y, place.z = marker.pose.translation
        turn.x, turn.y, turn.z, turn.w = marker.pose.rotation
        self._publisher.publish(feedback)
        if not marker.held and name in self._later:
            self._draw(self._later.pop(name))
