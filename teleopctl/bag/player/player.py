"""Player node: plays bags, controlled by rosbag2's services."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.playback import BagPath, Playback
from teleopctl.bag.records import BagMessage
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_service
from teleopctl.node import ReentrantCallbackGroup

if TYPE_CHECKING:
    from teleopctl.bag.player.playback import Playback
    from teleopctl.node import Node, Service


START_TIME, END_TIME = "playback.start_time_ns", "playback.end_time_ns"
"""Names of the parameters with start and end time of the playback, in ns since the epoch."""

LOOP, MARKS_PARAMETER = "playback.loop", "playback.marks"
"""Names of the parameters of looping, see `Playback.loops`, and of the marks on a time line.

A mark is a text of three words or more: time in nanoseconds since the epoch, kind, and what
happened.
"""


class PlayerServices:
    """rosbag2's services that control a player, such as ``~/pause`` and ``~/seek``.

    Args:
        node: Node of the player.
        player: Player that the services control.
    """

    def __init__(self, node: Node, player: Playback) -> None:
        self._node = node
        self._player = player
        self._services: list[Service[Any, Any]] = []
        # Reentrant: a burst may take long, and can be stopped by another service.
        self._group = ReentrantCallbackGroup()
        for name, type_name, answer in (
            ("pause", "Pause", self._pause),
            ("resume", "Resume", self._resume),
            ("toggle_paused", "TogglePaused", self._toggle_paused),
            ("is_paused", "IsPaused", self._is_paused),
            ("get_rate", "GetRate", self._get_rate),
            ("set_rate", "SetRate", self._set_rate),
            ("play", "Play", self._play),
            ("play_next", "PlayNext", self._play_next),
            ("burst", "Burst", self._burst),
            ("seek", "Seek", self._seek),
            ("stop", "Stop", self._stop),
        ):
            service = get_service(f"rosbag2_interfaces/srv/{type_name}")
            self._services.append(
                node.create_service(service, f"~/{name}", answer, callback_group=self._group)
            )

        # Ours: rosbag2's player does not publish the times of the bag.
        for name, time_ns in ((START_TIME, player.start_ns), (END_TIME, player.end_ns)):
            node.declare_parameter(name, time_ns)
        node.declare_parameter(LOOP, player.loops)
        # An empty text stands for no marks: an empty list has no type.
        node.declare_parameter(MARKS_PARAMETER, [""])
        node.add_post_set_parameters_callback(self._take_parameters)

    # Any: a parameter's value is checked by its type before.
    def _take_parameters(self, parameters: Sequence[Any]) -> None:
        for one in parameters:
            if one.name == LOOP:
                self._player.loops = bool(one.value)

    def close(self) -> None:
        """Destroy the services, and undeclare the parameters of start and end time."""
        if self._node.has_parameter(LOOP):
            self._node.remove_post_set_parameters_callback(self._take_parameters)
        for name in (START_TIME, END_TIME, LOOP, MARKS_PARAMETER):
            if self._node.has_parameter(name):
                self._node.undeclare_parameter(name)
        for service in self._services:
            self._node.destroy_service(service)

    # Any: requests and responses of types that are created at run time.

    def _pause(self, _: Any, response: Any) -> Any:
        self._player.pause()
        return response

    def _resume(self, _: Any, response: Any) -> Any:
        self._player.resume()
        return response

    def _toggle_paused(self, _: Any, response: Any) -> Any:
        self._player.toggle_paused()
        return response

    def _is_paused(self, _: Any, response: Any) -> Any:
        response.paused = self._player.is_paused
        return response

    def _get_rate(self, _: Any, response: Any) -> Any:
        response.rate = self._player.rate
        return response

    def _set_rate(self, request: Any, response: Any) -> Any:
        response.success = self._player.set_rate(request.rate)
        return response

    def _play(self, request: Any, response: Any) -> Any:
        # A request with default values plays the whole bag.
        response.success = self._player.play_from(
            max(0, _nanoseconds(request.start_offset)),
            _positive(_nanoseconds(request.playback_duration)),
            _positive(_nanoseconds(request.playback_until_timestamp)),
        )
        return response

    def _play_next(self, _: Any, response: Any) -> Any:
        response.success = self._player.play_next()
        return response

    def _burst(self, request: Any, response: Any) -> Any:
        response.actually_burst = self._player.burst(request.num_messages)
        return response

    def _seek(self, request: Any, response: Any) -> Any:
        response.success = self._player.seek(_nanoseconds(request.time))
        return response

    def _stop(self, _: Any, response: Any) -> Any:
        self._player.stop()
        return response


def _nanoseconds(time: Any) -> int:
    return int(time.sec * NANOSECONDS_PER_SECOND + time.nanosec)


def _positive(nanoseconds: int) -> int | None:
    return nanoseconds if nanoseconds > 0 else None


class Player(Playback):
    """Player of one bag, or of several merged by time, controlled by methods or rosbag2's services.

    The node gets rosbag2's services for players, which need an executor that spins the node;
    playing does not. Programs may call the methods of the same names from any thread.

    Example:
        ```python
        with Player(node, "my_bag", PlayOptions(rate=2.0)) as player:
            player.play()
            player.wait()
        ```

    Args:
        node: Node that publishes, owned by the caller. Remappings of the node apply.
        bags: Path of a bag, or several paths, each with its storage format if needed.
        options: Options of the playback; the defaults of ``ros2 bag play`` if None.
        on_published: Called on the playing thread with each published message.

    Raises:
        NotFoundError: A bag does not exist.
        InvalidFileError: A bag cannot be read.
    """

    def __init__(
        self,
        node: Node,
        bags: str | Path | Sequence[BagPath],
        options: PlayOptions | None = None,
        *,
        on_published: Callable[[BagMessage], object] = lambda _: None,
    ) -> None:
        super().__init__(node, bags, options or PlayOptions(), on_published)
        self._services = PlayerServices(node, self)

    def close(self) -> None:
        """Stop, close the bags, and destroy the player's publishers, clients and services."""
        self._services.close()
        super().close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
