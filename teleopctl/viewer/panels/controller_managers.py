"""State of controller managers, updated on their events, and the logged causes of failed calls."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.node import qos_profile_latched, qos_profile_rosout_default
from teleopctl.viewer.service_calls import ServiceCalls, servers_of

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.viewer.panels.base import Page

_LIST = "list_controllers"

# Any: messages, whose classes are created from definitions at run time.


def controller_managers(node: Node) -> list[str]:
    """Return the full names of the controller managers in the ROS graph, sorted."""
    return servers_of(node, _LIST, "controller_manager_msgs/srv/ListControllers")


class ControllerManagerWatch:
    """Controllers and hardware components of one controller manager, kept up to date.

    Both lists are requested at the start, by `refresh`, and after each message on the manager's
    ``~/activity``, which managers before ROS 2 Jazzy do not publish.

    Attributes:
        name: Full name of the manager.
        controllers: List of controller_manager_msgs/ControllerState.
        components: List of controller_manager_msgs/HardwareComponentState.

    Args:
        page: The viewer's node.
        name: Full name of the manager.
        changed: Function called when new lists were received.
        failed: Function called with a sentence when no response was received.
        with_hardware: Whether to request hardware components too.
    """

    def __init__(
        self,
        page: Page,
        name: str,
        changed: Callable[[], object],
        failed: Callable[[str], object],
        *,
        with_hardware: bool = False,
    ) -> None:
        self.name = name
        self.controllers: list[Any] = []
        self.components: list[Any] = []
        self._changed = changed
        self._failed = failed
        self._with_hardware = with_hardware
        self._calls = ServiceCalls(page)
        self._is_requesting = self._is_stale = False
        self._end = page.stage.subscribe(
            f"{name}/activity",
            "controller_manager_msgs/msg/ControllerManagerActivity",
            lambda _message: self.refresh(),
            qos_profile_latched,
        )
        self.refresh()

    def refresh(self) -> None:
        """Request the controllers, and hardware if configured, now or after a pending request."""
        if self._is_requesting:
            self._is_stale = True
            return
        self._is_requesting, self._is_stale = True, False
        self._call(_LIST, "ListControllers", self._take_controllers)

    def _take_controllers(self, response: Any) -> None:
        self.controllers = list(response.controller)
        if self._with_hardware:
            self._call("list_hardware_components", "ListHardwareComponents", self._take_components)
        else:
            self._finish()

    def _take_components(self, response: Any) -> None:
        self.components = list(response.component)
        self._finish()

    def _call(self, service: str, type_name: str, then: Callable[[Any], object]) -> None:
        self._calls.call(
            f"{self.name}/{service}",
            f"controller_manager_msgs/srv/{type_name}",
            then,
            self._request_failed,
        )

    def _request_failed(self, reason: str) -> None:
        self._is_requesting = False
        self._failed(reason)
        if self._is_stale:
            self.refresh()

    def _finish(self) -> None:
        self._is_requesting = False
        self._changed()
        if self._is_stale:
            self.refresh()

    def close(self) -> None:
        """Unsubscribe from the controller manager, and drop pending requests."""
        self._end()
        self._calls.close()


_ERROR = 40
_MOST_ERRORS = 50
# Time to wait for a log message that arrives after the response, in ticks of 0.1 s.
_LONGEST_WAIT_TICKS = 5


class ManagerErrors:
    """Recent errors on ``/rosout``, to explain failed calls of a controller manager.

    The manager's services respond with ``ok: false`` alone; the cause is in the manager's log.

    Args:
        page: The viewer's node.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._errors: deque[tuple[int, str, str]] = deque(maxlen=_MOST_ERRORS)
        self._count = 0
        self._waiting: list[_Search] = []
        self._end: Callable[[], None] | None = None

    def begin(self) -> None:
        """Subscribe to ``/rosout``."""
        self._end = self._page.stage.subscribe(
            "/rosout", "rcl_interfaces/msg/Log", self._take, qos_profile_rosout_default
        )

    def end(self) -> None:
        """Unsubscribe from ``/rosout``, and drop pending searches."""
        if self._end is not None:
            self._end()
            self._end = None
        self._waiting.clear()

    def mark(self) -> int:
        """Return a number for `find_cause`, which ignores errors received before this call."""
        return self._count

    def find_cause(
        self, nodes: Sequence[str], since: int, callback: Callable[[str | None], object]
    ) -> None:
        """Call ``callback`` with nodes' first error since a `mark`, or None after half a second.

        Args:
            nodes: Full names of the nodes.
            since: Result of `mark` before the failed call.
            callback: Function called with the error's text, or None if none is received in time.
        """
        self._waiting.append(
            _Search({name.strip("/").replace("/", ".") for name in nodes}, since, callback)
        )
        self._end_searches()

    def tick(self) -> None:
        """End searches that have waited half a second; called ten times a second."""
        for search in self._waiting:
            search.ticks += 1
        self._end_searches()

    def _take(self, log: Any) -> None:
        if log.level >= _ERROR:
            self._count += 1
            self._errors.append((self._count, log.name, log.msg))
            self._end_searches()

    def _end_searches(self) -> None:
        for search in tuple(self._waiting):
            found = search.first_error(self._errors)
            if found is not None or search.ticks >= _LONGEST_WAIT_TICKS:
                self._waiting.remove(search)
                search.callback(found)


class _Search:
    """A pending search for an error of some loggers after a mark."""

    def __init__(
        self, loggers: set[str], since: int, callback: Callable[[str | None], object]
    ) -> None:
        self._loggers = loggers
        self._since = since
        self.callback = callback
        self.ticks = 0

    def first_error(self, errors: deque[tuple[int, str, str]]) -> str | None:
        for number, logger, text in errors:
            # Child loggers have the node's name as prefix.
            own = any(logger == name or logger.startswith(f"{name}.") for name in self._loggers)
            if number > self._since and own:
                return text
        return None
