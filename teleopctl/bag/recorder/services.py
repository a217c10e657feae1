"""Services and events of the recorder in the graph, as rosbag2's recorder has them."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service, snake_case
from teleopctl.node import QoSProfile

if TYPE_CHECKING:
    from teleopctl.bag.recorder.losses import Losses
    from teleopctl.node import Node

_PACKAGE = "rosbag2_interfaces"
_EVENTS_DEPTH = 3
_DONE, _FAILED = 0, 1

# Longest wait of a service for the writing thread.
_LONGEST_S = 60.0

# Any, in this file: requests and responses of types that are created at run time.


class RecorderControls(Protocol):
    """Interface of a recorder that its ROS services call."""

    @property
    def is_recording(self) -> bool:
        """Whether a bag is open for recording."""

    @property
    def is_paused(self) -> bool:
        """Whether the recording is paused."""

    @property
    def is_discovering(self) -> bool:
        """Whether topics that appear in the graph later are recorded."""

    def record(self, folder: Path | None = None) -> None:
        """Start recording into a new bag in a folder; None for the folder of the last bag."""

    def stop(self) -> None:
        """Stop recording and finish the bag."""

    def pause(self) -> None:
        """Pause the recording, so that received messages are skipped."""

    def resume(self) -> None:
        """Resume the recording after `pause`."""

    def toggle_paused(self) -> None:
        """Pause the recording, or resume it if it is paused."""

    def set_discovery(self, *, active: bool) -> None:
        """Start or stop recording topics that appear in the graph later."""

    def split(self) -> Future[tuple[Path, Path]] | None:
        """Start a new file of the bag; return a future of both paths, or None if no bag is open."""

    def take_snapshot(self) -> Future[bool] | None:
        """Write the snapshot buffer to the bag; return a bool future, or None if no bag is open."""


class RecorderServices:
    """rosbag2's services that control a recorder, and publishers of the recorder's events.

    Args:
        node: Node of the recorder.
        recorder: Recorder that the services control.
        takes_snapshots: Whether to provide the service ``~/snapshot``.
    """

    def __init__(self, node: Node, recorder: RecorderControls, *, takes_snapshots: bool) -> None:
        self._node = node
        self._recorder = recorder
        self._split_event = get_message(f"{_PACKAGE}/msg/WriteSplitEvent")
        self._lost_event = get_message(f"{_PACKAGE}/msg/MessagesLostEvent")
        self._lost_statistics = get_message(f"{_PACKAGE}/msg/MessagesLostEventTopicStat")
        qos = QoSProfile(depth=_EVENTS_DEPTH)
        self._splits = node.create_publisher(self._split_event, "events/write_split", qos)
        self._lost = node.create_publisher(self._lost_event, "events/rosbag2_messages_lost", qos)
        services: dict[str, Callable[[Any, Any], Any]] = {
            "IsPaused": self._is_paused,
            "Pause": self._pause,
            "Resume": self._resume,
            "TogglePaused": self._toggle_paused,
            "SplitBagfile": self._split,
            "Record": self._record,
            "Stop": self._stop,
            "IsDiscoveryRunning": self._is_discovering,
            "StartDiscovery": self._start_discovery,
            "StopDiscovery": self._stop_discovery,
        }
        if takes_snapshots:
            services["Snapshot"] = self._snapshot
        for name, answer in services.items():
            service = get_service(f"{_PACKAGE}/srv/{name}")
            node.create_service(service, f"~/{snake_case(name)}", answer)

    def publish_split(self, closed: Path, opened: Path) -> None:
        """Publish rosbag2's WriteSplitEvent with the closed and the opened file."""
        self._splits.publish(
            self._split_event(
                closed_file=str(closed.absolute()),
                opened_file=str(opened.absolute()),
                node_name=self._node.get_fully_qualified_name(),
            )
        )

    def publish_losses(self, losses: Losses) -> None:
        """Publish losses as rosbag2's MessagesLostEvent."""
        self._lost.publish(
            self._lost_event(
                node_name=self._node.get_fully_qualified_name(),
                messages_lost_statistics=[
                    self._lost_statistics(
                        topic_name=topic,
                        messages_lost_in_transport=losses.in_transport.get(topic, 0),
                        messages_lost_in_recorder=losses.in_recorder.get(topic, 0),
                    )
                    for topic in losses.topics
                ],
            )
        )

    def _is_paused(self, _: Any, response: Any) -> Any:
        response.paused = self._recorder.is_paused
        return response

    def _pause(self, _: Any, response: Any) -> Any:
        self._recorder.pause()
        return response

    def _resume(self, _: Any, response: Any) -> Any:
        self._recorder.resume()
        return response

    def _toggle_paused(self, _: Any, response: Any) -> Any:
        self._recorder.toggle_paused()
        return response

    def _split(self, _: Any, response: Any) -> Any:
        self._outcome("SplitBagfile", self._recorder.split())
        return response

    def _snapshot(self, _: Any, response: Any) -> Any:
        response.success = bool(self._outcome("Snapshot", self._recorder.take_snapshot()))
        return response

    def _record(self, request: Any, response: Any) -> Any:
        try:
            self._recorder.record(Path(request.uri) if request.uri else None)
        except TeleopctlError as error:
            return self._refuse(response, "Record", error.message)
        response.return_code = _DONE
        return response

    def _stop(self, _: Any, response: Any) -> Any:
        if not self._recorder.is_recording:
            self._node.get_logger().warning(
                "Received Stop request while not in recording. Ignoring request."
            )
        try:
            self._recorder.stop()
        except TeleopctlError as error:
            self._node.get_logger().error(f"Error during Stop request: {error.message}")
        return response

    def _is_discovering(self, _: Any, response: Any) -> Any:
        response.running = self._recorder.is_discovering
        return response

    def _start_discovery(self, _: Any, response: Any) -> Any:
        if not self._recorder.is_recording:
            return self._refuse(response, "StartDiscovery", "Recorder is not currently recording.")
        if self._recorder.is_discovering:
            return self._refuse(response, "StartDiscovery", "Discovery is already running.")
        self._recorder.set_discovery(active=True)
        return response

    def _stop_discovery(self, _: Any, response: Any) -> Any:
        if not self._recorder.is_discovering:
            return self._refuse(response, "StopDiscovery", "Discovery is not running.")
        self._recorder.set_discovery(active=False)
        return response

    def _refuse(self, response: Any, request: str, why: str) -> Any:
        self._node.get_logger().warning(f"Refused a {request} request: {why}")
        response.return_code = _FAILED
        response.error_string = why
        return response

    def _outcome(self, request: str, future: Future[Any] | None) -> Any:
        """Return the result of the writing thread; None, with a log line, if there is none."""
        logger = self._node.get_logger()
        if future is None:
            logger.warning(f"Received {request} request while not in recording. Ignoring request.")
            return None
        try:
            return future.result(_LONGEST_S)
        except TeleopctlError as error:
            logger.error(f"Error during {request} request: {error.message}")
        except (CancelledError, TimeoutError):
            logger.error(f"Error during {request} request: the recording has ended")
        return None
