"""``interactive_markers.interactive_marker_server``. Server of interactive markers."""

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, auto

from geometry_msgs.msg import Pose
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.time import Time
from std_msgs.msg import Header
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)
from visualization_msgs.srv import GetInteractiveMarkers

__all__ = ["InteractiveMarkerServer"]

FeedbackCallback = Callable[[InteractiveMarkerFeedback], object]
DEFAULT_FEEDBACK_CALLBACK = 255

# Time in which one client alone moves a marker.
_ONE_CLIENT = Duration(seconds=1.0)


@dataclass
class _Callbacks:
    """Callbacks of a marker: for one type of feedback each, and for all others."""

    default: FeedbackCallback | None = None
    by_type: dict[int, FeedbackCallback] = field(default_factory=dict)

    def set(self, callback: FeedbackCallback | None, feedback_type: int) -> None:
        if feedback_type == DEFAULT_FEEDBACK_CALLBACK:
            self.default = callback
        elif callback is None:
            self.by_type.pop(feedback_type, None)
        else:
            self.by_type[feedback_type] = callback


class _Change(Enum):
    INSERTED = auto()
    MOVED = auto()
    ERASED = auto()


@dataclass
class _Update:
    """Change of a marker that is not published yet."""

    change: _Change
    marker: InteractiveMarker
    callbacks: _Callbacks


@dataclass
class _Shown:
    """Marker as last published."""

    marker: InteractiveMarker
    callbacks: _Callbacks
    moved_at: Time
    moved_by: str = ""


class InteractiveMarkerServer:
    """Server of interactive markers for clients such as RViz.

    Changes reach the clients with `applyChanges`.

    Args:
        node: Node of the server.
        namespace: Namespace of the topics ``update`` and ``feedback`` and of the service.
        update_pub_qos: QoS profile of the updates.
        feedback_sub_qos: QoS profile of the feedback.

    Example:
        >>> server = InteractiveMarkerServer(node, "simple_marker")
        >>> server.insert(marker, feedback_callback=lambda feedback: print(feedback.pose))
        >>> server.applyChanges()
    """

    DEFAULT_FEEDBACK_CALLBACK = DEFAULT_FEEDBACK_CALLBACK

    def __init__(
        self,
        node: Node,
        namespace: str,
        *,
        update_pub_qos: QoSProfile | None = None,
        feedback_sub_qos: QoSProfile | None = None,
    ) -> None:
        self.node = node
        self.namespace = namespace
        self.seq_num = 0
        self.mutex = threading.RLock()
        self._shown: dict[str, _Shown] = {}
        self._updates: dict[str, _Update] = {}
        self._is_shutdown = False
        self._service = node.create_service(
            GetInteractiveMarkers, f"{namespace}/get_interactive_markers", self._answer
        )
        self._publisher = node.create_publisher(
            InteractiveMarkerUpdate, f"{namespace}/update", update_pub_qos or QoSProfile(depth=100)
        )
        self._subscription = node.create_subscription(
            InteractiveMarkerFeedback,
            f"{namespace}/feedback",
            self.processFeedback,
            feedback_sub_qos or QoSProfile(depth=1),
        )

    def shutdown(self) -> None:
        """Erase all markers, and end the server. Idempotent."""
        if self._is_shutdown:
            return
        self._is_shutdown = True
        if self.node.context.ok():
            self.clear()
            self.applyChanges()
        self.node.destroy_service(self._service)
        self.node.destroy_publisher(self._publisher)
        self.node.destroy_subscription(self._subscription)

    def __del__(self) -> None:
        # A constructor that failed has not set the attributes.
        with contextlib.suppress(AttributeError):
            self.shutdown()

    def insert(
        self,
        marker: InteractiveMarker,
        *,
        feedback_callback: FeedbackCallback | None = None,
        feedback_type: int = DEFAULT_FEEDBACK_CALLBACK,
    ) -> None:
        """Add or replace a marker, and set a callback of it.

        Args:
            marker: Marker, identified by its name.
            feedback_callback: Called with feedback; the callbacks stay if None.
            feedback_type: Type of the feedback; by default any that has no callback of its own.
        """
        with self.mutex:
            before = self._updates.get(marker.name)
            callbacks = _Callbacks() if before is None else before.callbacks
            self._updates[marker.name] = _Update(_Change.INSERTED, marker, callbacks)
        if feedback_callback is not None:
            self.setCallback(marker.name, feedback_callback, feedback_type)

    def setPose(self, name: str, pose: Pose, header: Header | None = None) -> bool:
        """Move a marker; return False if there is none, or if it is being inserted.

        Args:
            name: Name of the marker.
            pose: New pose.
            header: New header; None or one without a frame keeps the present one.
        """
        with self.mutex:
            shown, update = self._shown.get(name), self._updates.get(name)
            if shown is None or (update is not None and update.change is _Change.INSERTED):
                return False
            if header is None or not header.frame_id:
                header = shown.marker.header
            self._move(name, pose, header)
            return True

    def erase(self, name: str) -> bool:
        """Erase a marker; return False if there is none."""
        with self.mutex:
            if name in self._updates:
                self._updates[name].change = _Change.ERASED
            elif name in self._shown:
                marker = self._shown[name].marker
                self._updates[name] = _Update(_Change.ERASED, marker, _Callbacks())
            else:
                return False
            return True

    def clear(self) -> None:
        """Erase all markers."""
        with self.mutex:
            self._updates.clear()
            for name in self._shown:
                self.erase(name)

    def setCallback(
        self,
        name: str,
        feedback_callback: FeedbackCallback | None,
        feedback_type: int = DEFAULT_FEEDBACK_CALLBACK,
    ) -> bool:
        """Set or, with None, remove a callback of a marker; return False if there is none.

        Args:
            name: Name of the marker.
            feedback_callback: Called with feedback.
            feedback_type: Type of the feedback; by default any that has no callback of its own.
        """
        with self.mutex:
            found = [each for each in (self._shown.get(name), self._updates.get(name)) if each]
            for each in found:
                each.callbacks.set(feedback_callback, feedback_type)
            return bool(found)

    def applyChanges(self) -> None:
        """Publish the changes since the last call."""
        with self.mutex:
            if not self._updates:
                return
            message = InteractiveMarkerUpdate(type=InteractiveMarkerUpdate.UPDATE)
            for name, update in self._updates.items():
                self._apply(name, update, message)
            self._updates = {}
            self.seq_num += 1
            message.seq_num = self.seq_num
            self._publisher.publish(message)

    def get(self, name: str) -> InteractiveMarker | None:
        """Return a marker with its changes that are not applied yet; None if there is none."""
        with self.mutex:
            update = self._updates.get(name)
            if update is not None:
                return None if update.change is _Change.ERASED else update.marker
            return self._shown[name].marker if name in self._shown else None

    def processFeedback(self, feedback: InteractiveMarkerFeedback) -> None:
        """Move the marker that a client has moved, and call the callback of the feedback."""
        with self.mutex:
            shown = self._shown.get(feedback.marker_name)
            if shown is None:
                return
            now = self.node.get_clock().now()
            is_other = shown.moved_by != feedback.client_id
            if is_other and now - shown.moved_at < _ONE_CLIENT:
                self.node.get_logger().debug(
                    f"Rejecting feedback for '{feedback.marker_name}': conflicting feedback from "
                    "separate clients"
                )
                return
            shown.moved_at, shown.moved_by = now, feedback.client_id
            if feedback.event_type == InteractiveMarkerFeedback.POSE_UPDATE:
                stamp = shown.marker.header.stamp
                is_unstamped = (stamp.sec, stamp.nanosec) == (0, 0)
                header = shown.marker.header if is_unstamped else feedback.header
                self._move(feedback.marker_name, feedback.pose, header)
            callbacks = shown.callbacks
        callback = callbacks.by_type.get(feedback.event_type, callbacks.default)
        if callback is not None:
            callback(feedback)
        self.applyChanges()

    def _move(self, name: str, pose: Pose, header: Header) -> None:
        update = self._updates.get(name)
        if update is None:
            shown = self._shown[name].marker
            moved = InteractiveMarker(
                **{slot: getattr(shown, slot) for slot in shown.get_fields_and_field_types()}
            )
            update = self._updates[name] = _Update(_Change.MOVED, moved, _Callbacks())
        elif update.change is not _Change.INSERTED:
            update.change = _Change.MOVED
        update.marker.pose, update.marker.header = pose, header

    def _apply(self, name: str, update: _Update, message: InteractiveMarkerUpdate) -> None:
        shown = self._shown.get(name)
        if update.change is _Change.INSERTED:
            if shown is None:
                now = self.node.get_clock().now()
                shown = self._shown[name] = _Shown(update.marker, update.callbacks, now)
            shown.marker = update.marker
            message.markers.append(update.marker)
        elif shown is None:
            return
        elif update.change is _Change.MOVED:
            shown.marker.pose, shown.marker.header = update.marker.pose, update.marker.header
            message.poses.append(
                InteractiveMarkerPose(
                    header=shown.marker.header, pose=shown.marker.pose, name=shown.marker.name
                )
            )
        else:
            del self._shown[name]
            message.erases.append(name)

    def _answer(
        self,
        _: GetInteractiveMarkers.Request,
        response: GetInteractiveMarkers.Response,
    ) -> GetInteractiveMarkers.Response:
        with self.mutex:
            response.sequence_number = self.seq_num
            response.markers = [shown.marker for shown in self._shown.values()]
            return response
