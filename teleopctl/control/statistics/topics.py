"""The topics ``~/statistics/…``: what is measured in the cycle, for PlotJuggler and the like."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.cycle import Cycle
from teleopctl.interfaces import get_message
from teleopctl.node import Clock, ClockType, qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.node import Node

# ros2_control publishes in each cycle. What is shown needs less, and here it would cost more than
# the cycle.
_PUBLISHED_PER_S = 10.0
_DEPTH = 10


class StatisticsTopics:
    """Publishes ros2_control's statistics topics while they have subscribers.

    Args:
        node: The manager's node.
        manager: Whose controllers and hardware it is about.
        cycle: Their cycle.
    """

    def __init__(self, node: Node, manager: ControllerManager, cycle: Cycle) -> None:
        self._node = node
        self._manager = manager
        self._cycle = cycle
        self._known: list[str] = []
        self._version = 0
        self._full, self._names, self._values = (
            node.create_publisher(
                get_message(f"pal_statistics_msgs/msg/{kind}"), f"~/statistics/{name}", qos
            )
            for kind, name, qos in (
                ("Statistics", "full", _DEPTH),
                # Sent when they change, for whoever listens later too.
                ("StatisticsNames", "names", qos_profile_latched),
                ("StatisticsValues", "values", _DEPTH),
            )
        )
        node.create_timer(
            1.0 / _PUBLISHED_PER_S, self._publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _publish(self) -> None:
        full = self._full.get_subscription_count() > 0
        apart = self._values.get_subscription_count() > 0
        if not (full or apart or self._names.get_subscription_count() > 0):
            return
        entries = list(statistics_entries(self._node.get_name(), self._manager, self._cycle))
        names = [name for name, _ in entries]
        if names != self._known:
            self._known = names
            self._version += 1
            self._send(self._names, names=names, names_version=self._version)
        if apart:
            values = [value for _, value in entries]
            self._send(self._values, values=values, names_version=self._version)
        if full:
            statistic = get_message("pal_statistics_msgs/msg/Statistic")
            self._send(
                self._full,
                statistics=[statistic(name=name, value=value) for name, value in entries],
            )

    # Any: messages of three types.
    def _send(self, publisher: Any, **fields: Any) -> None:
        message = publisher.msg_type(**fields)
        message.header.stamp = self._node.get_clock().now().to_msg()
        publisher.publish(message)


def statistics_entries(
    name: str, manager: ControllerManager, cycle: Cycle
) -> Iterator[tuple[str, float]]:
    """Yield all statistics under ros2_control's names.

    Args:
        name: The manager's.
        manager: Its controllers and hardware.
        cycle: Their cycle.
    """
    yield from cycle.times.entries(name)
    for component in manager.resource_manager.components.values():
        yield from component.reads.entries(f"{component.name}.stats/read_cycle")
        yield from component.writes.entries(f"{component.name}.stats/write_cycle")
    for spec in list(manager.controllers.values()):
        yield from spec.statistics.entries(f"{spec.name}.stats")
