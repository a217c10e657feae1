"""RViz's ``InteractiveMarkers``: markers of another program that are moved and clicked on the page.

A server numbers its updates. A client requests the full state, which contains the number of the
last update, and then applies the following updates. If an update is missing, the client requests
the state again.
"""

from __future__ import annotations

import secrets
import time
from collections import deque
from typing import Any, ClassVar

from teleopctl.base.printable import printable_line
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import QoSProfile
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.conversions import pose_of
from teleopctl.viewer.displays.markers.interactive_marker import (
    FEEDBACK_KEEP_ALIVE,
    InteractiveMarker,
)
from teleopctl.viewer.displays.markers.marker_drawing import MarkerError
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.displays.properties import Property

KEEP_ALIVE, UPDATE = 0, 1
# Number of updates kept until the full state arrives.
_MOST_WAITING = 100


class UpdateSequence:
    """Sequence check of an interactive marker server's updates, to find missing ones.

    Attributes:
        needs_state: Whether the full state has to be requested.
    """

    def __init__(self) -> None:
        self.needs_state = True
        self._last = 0
        self._server = ""
        # Any: visualization_msgs/msg/InteractiveMarkerUpdate.
        self._waiting: deque[Any] = deque(maxlen=_MOST_WAITING)

    # Any: as above.
    def add(self, update: Any) -> bool:
        """Check an update's number, or keep the update for `start`; return whether to apply now.

        Updates before the full state are kept for `start`. A missing update sets `needs_state`.
        """
        if self._server and update.server_id != self._server:
            # another server, or a restart of the same server
            self._request_state()
        self._server = update.server_id
        if self.needs_state:
            self._waiting.append(update)
            return False
        if update.type == KEEP_ALIVE:
            if update.seq_num != self._last:
                self._request_state()
            return False
        if update.seq_num == self._last + 1:
            self._last = update.seq_num
            return True
        if update.seq_num > self._last:
            self._request_state()
            self._waiting.append(update)
        return False

    # Any: as above.
    def start(self, sequence_number: int) -> list[Any]:
        """Continue from the full state's sequence number; return the kept updates to apply now."""
        self._last, self.needs_state = sequence_number, False
        waiting = [each for each in self._waiting if each.type == UPDATE]
        self._waiting.clear()
        return [update for update in waiting if not self.needs_state and self.add(update)]

    def _request_state(self) -> None:
        self.needs_state = True
        self._waiting.clear()


# Any: messages, whose classes are created from definitions at run time.

_NAMESPACE = "Interactive Markers Namespace"
_UPDATE = "/update"
_MOST_MARKERS = 500
# The full state is requested again after this time without a response.
_REQUEST_PERIOD_S = 5.0
# A server rejects feedback of other clients until 1 s after the dragging client's last feedback.
_FEEDBACK_PERIOD_S = 0.4


class InteractiveMarkers(Display):
    """RViz's ``InteractiveMarkers`` display: the markers of one interactive marker server."""

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
        # Messages about a marker that are received while a user drags it.
        self._later: dict[str, Any] = {}
        self._client_id = f"rviz{self.root}/{secrets.token_hex(4)}"
        self._feed = UpdateSequence()
        self._files = MarkerFiles(self.stage, self._file_arrived)
        self._client: Any = None
        self._publisher: Any = None
        self._requested_at = 0.0
        self._feedback_at = 0.0
        self._fixed = ""
        self._numbers = 0
        self._turn = 0
        self._fault = ""

    # --- the graph ----------------------------------------------------------------------------

    def set_topic(self, topic: str) -> None:
        """Set the update topic; its namespace is stored in the ``.rviz`` mapping."""
        super().set_topic(topic)
        self.values.given[_NAMESPACE] = topic.removesuffix(_UPDATE)

    def qos(self) -> QoSProfile:
        """Return a reliable QoS with a depth of 100, since every update is needed."""
        return QoSProfile(depth=100)

    def started(self) -> None:
        """Create the service client for the full state and the publisher of feedback."""
        namespace = self.topic.removesuffix(_UPDATE)
        if not self.topic:
            return
        node = self.stage.node
        self._feed = UpdateSequence()
        self._requested_at = 0.0
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
        """Remove all markers from the scene; destroy the client and the publisher."""
        self._turn += 1
        self._clear()
        if self._client is not None:
            self.stage.node.destroy_client(self._client)
            self.stage.node.destroy_publisher(self._publisher)
            self._client = self._publisher = None

    def received(self, message: Any) -> None:
        """Apply an InteractiveMarkerUpdate if it is the next in sequence; set the status."""
        if self._feed.add(message):
            self._apply(message)
        self._update_status()

    def tick(self) -> None:
        """Request the full state if needed, update poses, and publish keep-alives during drags."""
        if self._client is None:
            return
        now = time.monotonic()
        if self._feed.needs_state and now - self._requested_at > _REQUEST_PERIOD_S:
            if self._client.service_is_ready():
                self._request(now)
            else:
                self.set_status(WARN, f"No node offers {self._client.srv_name}")
        fixed = self.stage.frames.fixed
        camera = None
        if any(marker.faces_viewer for marker in self.markers.values()):
            camera = self.stage.camera()
        for name, marker in self.markers.items():
            marker.reset_pose() if fixed != self._fixed else marker.update_pose()
            if camera is not None:
                marker.face_camera(camera)
            if marker.held and now - self._feedback_at > _FEEDBACK_PERIOD_S:
                self._publish_feedback(name, FEEDBACK_KEEP_ALIVE, marker.held, 0)
        self._fixed = fixed
        if not self._feed.needs_state:
            self._update_status()

    def changed(self, name: str) -> None:  # noqa: ARG002 -- the same for every property
        """Redraw all interactive markers after a property was set."""
        for marker in list(self.markers.values()):
            self._draw(marker.message, marker.pose)

    def _request(self, now: float) -> None:
        self._requested_at = now
        turn = self._turn
        future = self._client.call_async(
            get_service("visualization_msgs/srv/GetInteractiveMarkers").Request()
        )

        def answered(done: Any) -> None:
            state = None if done.exception() is not None else done.result()
            if turn == self._turn and self._feed.needs_state and state is not None:
                self._guarded(lambda: self._apply_state(state))

        future.add_done_callback(answered)

    def _apply_state(self, state: Any) -> None:
        self._clear()
        for message in state.markers:
            self._draw(message)
        for update in self._feed.start(state.sequence_number):
            self._apply(update)
        if self._feed.needs_state:
            self._requested_at = 0.0
        self._update_status()

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
                marker.set_pose(pose)
            elif not marker.held:
                marker.message.header = moved.header
                self._draw(marker.message, pose)
        for name in update.erases:
            self._remove(name)
        self._files.drop_unused(set().union(*(one.files for one in self.markers.values())))

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

        def publish_feedback(event: int, control: str, entry: int) -> None:
            self._publish_feedback(name, event, control, entry)

        try:
            marker = InteractiveMarker(
                self.stage,
                f"{self.root}/marker{self._numbers}",
                message,
                self._files,
                publish_feedback,
                show_description=self.values.flag("Show Descriptions"),
                show_axes=self.values.flag("Show Axes"),
            )
        except MarkerError as fault:
            self._fault = f"{printable_line(name)} {fault}"
            return
        self.markers[name] = marker
        if pose is not None:
            marker.set_pose(pose)

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

    def _update_status(self) -> None:
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
        self.set_status(WARN if fault else OK, fault)

    # --- feedback -----------------------------------------------------------------------------

    def _publish_feedback(self, name: str, event: int, control: str, entry: int) -> None:
        marker = self.markers.get(name)
        if marker is None or self._publisher is None:
            return
        self._feedback_at = time.monotonic()
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
