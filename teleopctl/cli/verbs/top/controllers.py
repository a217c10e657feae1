"""The controllers of all controller managers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from teleopctl.control import ControllerManagerClient, ControllerManagerUnavailableError

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.wire import Graph

_SERVICE = "/list_controllers"
_LONGEST_WAIT_S = 2.0


class ControllerRow(NamedTuple):
    """A controller as its manager tells it; the rate is in Hz."""

    manager: str
    name: str
    state: str
    type_name: str
    update_rate: int


class Controllers:
    """Asks the managers that are in the graph; not on the thread that draws.

    Args:
        node: Asks.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, ControllerManagerClient] = {}

    def look(self, graph: Graph) -> list[ControllerRow]:
        """The controllers of the managers that answer."""
        rows: list[ControllerRow] = []
        for service, _ in graph.service_names_and_types():
            if not service.endswith(_SERVICE) or not graph.servers(service):
                continue
            manager = service.removesuffix(_SERVICE)
            if manager not in self._clients:
                self._clients[manager] = ControllerManagerClient(
                    self._node, manager, call_timeout=_LONGEST_WAIT_S, attempts=1
                )
            try:
                rows += [
                    ControllerRow(manager, c.name, c.state, c.type, c.update_rate)
                    for c in self._clients[manager].list_controllers()
                ]
            except ControllerManagerUnavailableError:
                continue
        return rows
