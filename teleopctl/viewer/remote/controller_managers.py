"""Controller managers in any namespace, followed by the events that they publish."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.node import qos_profile_latched
from teleopctl.viewer.remote.service_calls import ServiceCalls

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.viewer.page.page import Page

_LIST = "list_controllers"

# Any stands for messages: their classes are made at run time, from definitions.


def controller_managers(node: Node) -> list[str]:
    """Return the names of the graph's controller managers."""
    return [
        name.removesuffix(f"/{_LIST}")
        for name, types in node.get_service_names_and_types()
        # A client's service is listed too, though nobody serves it.
        if name.endswith(f"/{_LIST}")
        and "controller_manager_msgs/srv/ListControllers" in types
        and node.count_services(name)
    ]


class ControllerManagerWatch:
    """Follows the controllers and hardware components of one controller manager.

    Managers before ROS 2 Jazzy say nothing: they are asked at the start, and by `ask`.

    Attributes:
        name: The manager.
        controllers: As controller_manager_msgs/ControllerState.
        components: As controller_manager_msgs/HardwareComponentState.

    Args:
        page: Whose node asks.
        name: The manager.
        changed: Called when the answers are there.
        failed: Called with a sentence where there is no answer.
        with_hardware: Whether to ask for hardware components too.
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
        self._is_asking = self._is_stale = False
        self._end = page.stage.subscribe(
            f"{name}/activity",
            "controller_manager_msgs/msg/ControllerManagerActivity",
            lambda _message: self.ask(),
            qos_profile_latched,
        )
        self.ask()

    def ask(self) -> None:
        """Request the lists, or request them again after the pending response."""
        if self._is_asking:
            self._is_stale = True
            return
        self._is_asking, self._is_stale = True, False
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
            self._give_up,
        )

    def _give_up(self, reason: str) -> None:
        self._is_asking = False
        self._failed(reason)
        if self._is_stale:
            self.ask()

    def _finish(self) -> None:
        self._is_asking = False
        self._changed()
        if self._is_stale:
            self.ask()

    def close(self) -> None:
        """Stop following the manager."""
        self._end()
        self._calls.close()
