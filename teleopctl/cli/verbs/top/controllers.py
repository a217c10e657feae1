"""Controllers of all controller managers, with their states and execution times."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from teleopctl.control import ControllerManagerClient, ControllerManagerUnavailableError
from teleopctl.interfaces import deserialize, get_message

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.wire import Graph

_SERVICE = "/list_controllers"
_STATISTICS = "pal_statistics_msgs/msg/Statistics"
_TIME = ".stats/execution_time"
_LONGEST_WAIT_S = 2.0


class ControllerRow(NamedTuple):
    """Row of a controller: manager, state, type, update rate in Hz and execution times.

    The average and the longest execution time of its updates are in microseconds; None if unknown.
    """

    manager: str
    name: str
    state: str
    type_name: str
    update_rate: int
    average_us: float | None = None
    longest_us: float | None = None


class ControllerTable:
    """Client of all controller managers that lists controllers for ``teleopctl top``.

    Args:
        node: Node that calls the controller managers.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, ControllerManagerClient] = {}
        self._measured: dict[str, bytes] = {}

    def rows(self, graph: Graph) -> list[ControllerRow]:
        """Request and return the controllers of all managers in the graph that respond."""
        rows: list[ControllerRow] = []
        for service, _ in graph.service_names_and_types():
            if not service.endswith(_SERVICE) or not graph.servers(service):
                continue
            manager = service.removesuffix(_SERVICE)
            if manager not in self._clients:
                self._clients[manager] = ControllerManagerClient(
                    self._node, manager, call_timeout=_LONGEST_WAIT_S, attempts=1
                )
                self._subscribe(manager)
            times = self._times(manager)
            try:
                rows += [
                    ControllerRow(
                        manager,
                        c.name,
                        c.state,
                        c.type,
                        c.update_rate,
                        times.get(f"{c.name}{_TIME}/average"),
                        times.get(f"{c.name}{_TIME}/max"),
                    )
                    for c in self._clients[manager].list_controllers()
                ]
            except ControllerManagerUnavailableError:
                continue
        return rows

    def _subscribe(self, manager: str) -> None:
        def keep(data: bytes) -> None:
            # In ROS 2 a message arrives in each control cycle: only the last one is deserialized.
            self._measured[manager] = data

        statistics = get_message(_STATISTICS)
        self._node.create_subscription(
            statistics, f"{manager}/statistics/full", keep, 1, raw=True, immediate=True
        )

    def _times(self, manager: str) -> dict[str, float]:
        """Return the manager's statistics by name; empty before the first message."""
        data = self._measured.get(manager)
        if data is None:
            return {}
        message = deserialize(data, get_message(_STATISTICS))
        return {one.name: one.value for one in message.statistics}
