"""Publishers of ``~/statistics/…`` and ``/diagnostics`` of a controller manager."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.cycle import Cycle
from teleopctl.control.lifecycle import State
from teleopctl.control.statistics import MovingStatistics
from teleopctl.interfaces import get_message
from teleopctl.node import Clock, ClockType, qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.node import AllowableParameterValue, Node


# ros2_control publishes in each cycle. For display a lower rate is enough, and publishing in each
# cycle would take longer than the cycle itself.
_PUBLISHED_PER_S = 10.0
_DEPTH = 10


class StatisticsPublisher:
    """Publisher of ``~/statistics/…`` at 10 Hz while these topics have subscriptions.

    Args:
        node: Node of the controller manager.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
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
                # Published when the names change, and latched for later subscriptions.
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
    """Yield name-value pairs of the statistics of a control cycle, controllers and hardware.

    Args:
        name: Name of the controller manager, as prefix.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
    """
    yield from cycle.times.entries(name)
    for component in manager.resource_manager.components.values():
        yield from component.reads.entries(f"{component.name}.stats/read_cycle")
        yield from component.writes.entries(f"{component.name}.stats/write_cycle")
    for spec in list(manager.controllers.values()):
        yield from spec.statistics.entries(f"{spec.name}.stats")


_TOPIC = "/diagnostics"
_HARDWARE_ID = "ros2_control"
# Default thresholds for WARN and ERROR: Hz for periodicity, microseconds for execution time.
_DEFAULTS = {
    "periodicity.mean_error": (5.0, 10.0),
    "periodicity.standard_deviation": (5.0, 10.0),
    "execution_time.mean_error": (1000.0, 2000.0),
    "execution_time.standard_deviation": (100.0, 200.0),
}

Parameter = Callable[[str], "AllowableParameterValue"]


class DiagnosticLevel(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus: OK, WARN and ERROR."""

    OK = 0
    WARN = 1
    ERROR = 2


class DiagnosticStatus(NamedTuple):
    """Diagnostic status of controllers, hardware or control cycle: level, message and values."""

    name: str
    level: DiagnosticLevel
    message: str
    values: Sequence[tuple[str, str]]


class DiagnosticsPublisher:
    """Publisher of a controller manager's ``/diagnostics``, once a second while subscribed.

    Args:
        node: Node of the controller manager.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
        parameter: Function that returns the value of a parameter of the manager, or None.
    """

    def __init__(
        self, node: Node, manager: ControllerManager, cycle: Cycle, parameter: Parameter
    ) -> None:
        self._node = node
        self._manager = manager
        self._cycle = cycle
        self._parameter = parameter
        self._array = get_message("diagnostic_msgs/msg/DiagnosticArray")
        self._publisher = node.create_publisher(self._array, _TOPIC, 1)
        node.create_timer(1.0, self._publish, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _publish(self) -> None:
        if not self._publisher.get_subscription_count():
            return
        status: Any = get_message("diagnostic_msgs/msg/DiagnosticStatus")
        pair = get_message("diagnostic_msgs/msg/KeyValue")
        message = self._array(
            status=[
                status(
                    level=bytes([one.level]),
                    name=f"{self._node.get_name()}: {one.name}",
                    message=one.message,
                    hardware_id=_HARDWARE_ID,
                    values=[pair(key=key, value=value) for key, value in one.values],
                )
                for one in diagnostic_statuses(self._manager, self._cycle, self._parameter)
            ]
        )
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)


def diagnostic_statuses(
    manager: ControllerManager, cycle: Cycle, parameter: Parameter
) -> tuple[DiagnosticStatus, DiagnosticStatus, DiagnosticStatus]:
    """Return three diagnostic statuses: of controllers, hardware and control cycle.

    Args:
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
        parameter: Function that returns the value of a parameter of the manager, or None.
    """
    return (
        _controllers(manager, parameter),
        _hardware(manager, parameter),
        _manager(manager, cycle, parameter),
    )


def _controllers(manager: ControllerManager, parameter: Parameter) -> DiagnosticStatus:
    thresholds = _Thresholds("controllers", parameter)
    specs = list(manager.controllers.values())
    values: list[tuple[str, str]] = []
    for spec in specs:
        values.append((f"{spec.name}.state", spec.lifecycle_state.label))
        if spec.lifecycle_state is not State.ACTIVE:
            continue
        rate = round(spec.controller.update_rate)
        work = spec.statistics
        values.append(thresholds.judge(spec.name, work.execution_time, "execution_time", 0.0))
        if rate != manager.update_rate:
            values.append(thresholds.judge(spec.name, work.periodicity, "periodicity", rate))
    return thresholds.status("Controllers Activity", "controllers", specs, values)


def _hardware(manager: ControllerManager, parameter: Parameter) -> DiagnosticStatus:
    thresholds = _Thresholds("hardware_components", parameter)
    components = list(manager.resource_manager.components.values())
    values: list[tuple[str, str]] = []
    for component in components:
        values.append((f"{component.name}.state", component.lifecycle_state.label))
        if component.lifecycle_state is not State.ACTIVE:
            continue
        for part, work in (("read_cycle", component.reads), ("write_cycle", component.writes)):
            name = f"{component.name}.{part}"
            values.append(thresholds.judge(name, work.execution_time, "execution_time", 0.0))
    return thresholds.status(
        "Hardware Components Activity", "hardware components", components, values
    )


def _manager(manager: ControllerManager, cycle: Cycle, parameter: Parameter) -> DiagnosticStatus:
    thresholds = _Thresholds("controller_manager", parameter)
    rate = manager.update_rate
    values = [
        ("update_rate", str(rate)),
        thresholds.judge("", cycle.times.periodicity, "periodicity", rate),
    ]
    message = "The control cycle keeps its rate"
    if thresholds.level is not DiagnosticLevel.OK:
        message = f"The control cycle does not keep its rate of {rate} Hz"
    return DiagnosticStatus("Controller Manager Activity", thresholds.level, message, values)


class _Thresholds:
    """Thresholds of diagnostics for one kind of item, and the worst level of its statistics.

    Args:
        kind: Kind of the items in parameter names, such as ``controllers``.
        parameter: Function that returns the value of a parameter of the manager, or None.

    Attributes:
        level: Worst level so far.
    """

    def __init__(self, kind: str, parameter: Parameter) -> None:
        self._prefix = f"diagnostics.threshold.{kind}"
        self._parameter = parameter
        self._off: list[str] = []
        self.level = DiagnosticLevel.OK

    def judge(
        self, name: str, measured: MovingStatistics, quantity: str, expected: float
    ) -> tuple[str, str]:
        """Compare statistics with thresholds, raise the level if exceeded; return key and text."""
        level = DiagnosticLevel.OK
        if measured.count:
            error = measured.average - expected
            # An execution time below the expected one is no error.
            error = error if quantity == "execution_time" else abs(error)
            level = max(
                self._level(f"{quantity}.mean_error", error),
                self._level(f"{quantity}.standard_deviation", measured.standard_deviation),
            )
        if level is not DiagnosticLevel.OK and name:
            self._off.append(f"{name} ({quantity})")
        self.level = max(self.level, level)
        unit = "us" if quantity == "execution_time" else "Hz"
        return (
            f"{name}.{quantity}".lstrip("."),
            f"Avg: {measured.average:.2f} "
            f"[{measured.minimum:.2f} - {measured.maximum:.2f}] {unit}, "
            f"StdDev: {measured.standard_deviation:.2f}"
            + (f" -> Desired : {expected:g} Hz" if expected else ""),
        )

    def _level(self, quantity: str, value: float) -> DiagnosticLevel:
        levels = (DiagnosticLevel.WARN, DiagnosticLevel.ERROR)
        above = DiagnosticLevel.OK
        for level, default in zip(levels, _DEFAULTS[quantity], strict=True):
            limit = self._parameter(f"{self._prefix}.{quantity}.{level.name.lower()}")
            if value > (limit if isinstance(limit, (int, float)) else default):
                above = level
        return above

    def status(
        self, task: str, kind: str, items: Iterable[Any], values: Sequence[tuple[str, str]]
    ) -> DiagnosticStatus:
        """Return one status for all controllers or components, with the worst level so far."""
        states = [one.lifecycle_state for one in items]
        message = f"All {kind} are active"
        if not states:
            message = f"There are no {kind}"
        elif any(state is not State.ACTIVE for state in states):
            message = f"Not all {kind} are active"
        if self._off:
            message += f"; slow or irregular: {', '.join(dict.fromkeys(self._off))}"
        return DiagnosticStatus(task, self.level, message, values)
