"""Measurements of a manager: ``~/statistics/…``, ``~/introspection_data/…``, ``/diagnostics``.

The service ``~/get_execution_times`` has histograms of all execution times.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.base.exception_origin import with_origin
from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controller_spec import ControllerSpec
from teleopctl.control.cycle import Cycle
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import State
from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.control.statistics import DurationHistogram, MovingStatistics, WorkStatistics
from teleopctl.interfaces import get_message, get_service, set_stamp
from teleopctl.node import Clock, ClockType, qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.interfaces import AllowableParameterValue
    from teleopctl.node import Node


# ros2_control publishes in each cycle. For display a lower rate is enough, and publishing in each
# cycle would take longer than the cycle itself.
_PUBLISHED_PER_S = 10.0
# Interval at which subscriptions to introspection data are looked for.
INTROSPECTION_CHECK_S = 0.1
_DEPTH = 10


class StatisticsTopics:
    """Publishers of names and values as pal_statistics: ``…/full``, ``…/names``, ``…/values``.

    Args:
        node: Node of the publishers.
        topic: Common part of the topic names, such as ``~/statistics``.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._node = node
        self._known: Sequence[str] = ()
        self._version = 0
        # Any: messages of three types, whose classes are generated at run time.
        self._full, self._names, self._values = (
            node.create_publisher(_message(kind), f"{topic}/{name}", qos)
            for kind, name, qos in (
                ("Statistics", "full", _DEPTH),
                # Published when the names change, and latched for later subscriptions.
                ("StatisticsNames", "names", qos_profile_latched),
                ("StatisticsValues", "values", _DEPTH),
            )
        )

    def is_subscribed(self) -> bool:
        """Return whether one of the topics has a subscription."""
        topics = (self._full, self._values, self._names)
        return any(topic.get_subscription_count() > 0 for topic in topics)

    def publish(self, names: Sequence[str], values: Sequence[float], stamp_ns: int) -> None:
        """Publish values on the topics with subscriptions, and the names if they have changed.

        Args:
            names: Names of the values.
            values: Values, one per name.
            stamp_ns: Time of the values in nanoseconds.
        """
        if names != self._known:
            self._known = names
            self._version += 1
            self._send(self._names, "StatisticsNames", stamp_ns, names=list(names), **self._number)
        if self._values.get_subscription_count() > 0:
            self._send(
                self._values, "StatisticsValues", stamp_ns, values=list(values), **self._number
            )
        if self._full.get_subscription_count() > 0:
            statistic = _message("Statistic")
            pairs = zip(names, values, strict=True)
            statistics = [statistic(name=name, value=value) for name, value in pairs]
            self._send(self._full, "Statistics", stamp_ns, statistics=statistics)

    @property
    def _number(self) -> dict[str, int]:
        return {"names_version": self._version}

    # Any: messages of three types.
    def _send(self, publisher: Any, kind: str, stamp_ns: int, **fields: Any) -> None:
        message = _message(kind)(**fields)
        set_stamp(message.header.stamp, stamp_ns)
        publisher.publish(message)


# Any: message classes are generated at run time.
def _message(kind: str) -> Any:
    return get_message(f"pal_statistics_msgs/msg/{kind}")


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
        self._topics = StatisticsTopics(node, "~/statistics")
        node.create_timer(
            1.0 / _PUBLISHED_PER_S, self._publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _publish(self) -> None:
        if not self._topics.is_subscribed():
            return
        entries = list(statistics_entries(self._node.get_name(), self._manager, self._cycle))
        names, values = [name for name, _ in entries], [value for _, value in entries]
        self._topics.publish(names, values, self._node.get_clock().now().nanoseconds)


class IntrospectionPublisher:
    """Publisher of interfaces and registered values on ``~/introspection_data/…`` in each cycle.

    Nothing is read or published while these topics have no subscription.

    Args:
        node: Node of the controller manager.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
        publish_queue: Queue of values that are published outside of the control cycle.
    """

    def __init__(
        self, node: Node, manager: ControllerManager, cycle: Cycle, publish_queue: PublishQueue
    ) -> None:
        self._manager = manager
        self._cycle = cycle
        self._topics = StatisticsTopics(node, "~/introspection_data")
        self._states: Mapping[str, StateInterface] = {}
        self._commands: Mapping[str, CommandInterface] = {}
        self._names: Sequence[str] = ()
        self._reported: set[str] = set()
        self._publisher = RealtimePublisher(publish_queue, self._publish)

    def follow_subscriptions(self) -> None:
        """Make the cycle collect values if a topic has a subscription, else stop it.

        Called by a timer: asking for subscriptions in each cycle would cost time in each of them.
        """
        self._cycle.on_written = self._collect if self._topics.is_subscribed() else None

    def _collect(self) -> None:
        """Queue the values of all interfaces; called at the end of a control cycle."""
        resources = self._manager.resource_manager
        states, commands = resources.state_interfaces, resources.command_interfaces
        if states is not self._states or commands is not self._commands:
            self._states, self._commands = states, commands
            self._names = introspection_names(states, commands)
        names, values = [*self._names], [state.value for state in states.values()]
        for command in commands.values():
            values += (command.value, float(command.is_limited))
        for spec in list(self._manager.controllers.values()):
            if (update := spec.async_update) is not None:
                names += (f"{spec.name}.total_triggers", f"{spec.name}.failed_triggers")
                values += (float(update.total_triggers), float(update.failed_triggers))
            if spec.lifecycle_state is State.ACTIVE:
                self._add_registered(spec.name, spec.controller.introspected, names, values)
        for component in resources.components.values():
            if component.lifecycle_state is State.ACTIVE:
                self._add_registered(component.name, component.hardware.introspected, names, values)
        self._publisher.try_publish((self._cycle.time_ns, names, values))

    def _add_registered(
        self,
        owner: str,
        functions: Mapping[str, Callable[[], float]],
        names: list[str],
        values: list[float],
    ) -> None:
        """Append the values that a controller or hardware has registered; NaN if one raises."""
        for name, function in functions.items():
            full_name = f"{owner}.{name}"
            try:
                value = float(function())
            except Exception as error:  # noqa: BLE001 - a plug-in's failure must not end the cycle
                value = math.nan
                if full_name not in self._reported:
                    self._reported.add(full_name)
                    self._cycle.report(
                        f"The value '{full_name}' of introspection data raised {with_origin(error)}"
                    )
            names.append(full_name)
            values.append(value)

    def _publish(self, collected: tuple[int, Sequence[str], list[float]]) -> None:
        stamp_ns, names, values = collected
        self._topics.publish(names, values, stamp_ns)


def introspection_names(states: Iterable[str], commands: Iterable[str]) -> list[str]:
    """Return the names of interfaces' values in introspection data, as ros2_control has them.

    Args:
        states: Full names of state interfaces.
        commands: Full names of command interfaces. Each has two values: the command, and 1 if it
            was clamped to a limit, else 0.
    """
    return [f"state_interface.{name}" for name in states] + [
        f"command_interface.{name}{suffix}" for name in commands for suffix in ("", ".is_limited")
    ]


def statistics_entries(
    name: str, manager: ControllerManager, cycle: Cycle
) -> Iterator[tuple[str, float]]:
    """Yield name-value pairs of the statistics of a control cycle, controllers and hardware.

    Beyond those of ros2_control: the numbers of missed cycles, and of commands of each controller
    that were clamped to limits.

    Args:
        name: Name of the controller manager, as prefix.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
    """
    yield from cycle.times.entries(name)
    yield f"{name}.missed_cycles", float(cycle.missed_count)
    for component in manager.resource_manager.components.values():
        yield from component.reads.entries(f"{component.name}.stats/read_cycle")
        yield from component.writes.entries(f"{component.name}.stats/write_cycle")
    for spec in list(manager.controllers.values()):
        yield from spec.statistics.entries(f"{spec.name}.stats")
        yield f"{spec.name}.stats/limited_commands", float(_limited_commands(manager, spec))


def _limited_commands(manager: ControllerManager, spec: ControllerSpec) -> int:
    """Return how many commands of a controller's interfaces were clamped to limits."""
    commands = manager.resource_manager.command_interfaces
    return sum(
        commands[name].limited_count
        for name in spec.required_command_interfaces
        if name in commands
    )


EXECUTION_TIMES = "teleopctl_msgs/srv/GetExecutionTimes"
"""Type of the service ``~/get_execution_times``."""


# Time without a request after which execution times are no longer counted.
_COUNTED_FOR_S = 600.0
# Interval at which that is looked for.
EXECUTION_TIMES_CHECK_S = 60.0


class ExecutionTimesService:
    """Service ``~/get_execution_times``: histograms of all execution times since the first request.

    The difference of two responses gives the percentiles of all updates between them. The manager
    counts from the first request on, until ten minutes after the last one. This is no topic, since
    a recording of all topics would keep it counting.

    Args:
        node: Node of the controller manager.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
    """

    def __init__(self, node: Node, manager: ControllerManager, cycle: Cycle) -> None:
        self._name = node.get_name()
        self._manager = manager
        self._cycle = cycle
        self._requested_s = -math.inf
        node.create_service(get_service(EXECUTION_TIMES), "~/get_execution_times", self._answer)

    # Any: message classes are generated at run time.
    def _answer(self, _: Any, response: Any) -> Any:
        self._requested_s = time.monotonic()
        self._count(True)
        set_stamp(response.stamp, self._cycle.time_ns)
        response.missed_cycles = self._cycle.missed_count
        response.times = list(execution_times(self._name, self._manager, self._cycle))
        return response

    def end_unused_counting(self) -> None:
        """Count no longer if there was no request for some minutes; called by a timer."""
        if time.monotonic() - self._requested_s > _COUNTED_FOR_S:
            self._count(False)

    def _count(self, wanted: bool) -> None:
        self._cycle.times.count_durations(wanted)
        for component in self._manager.resource_manager.components.values():
            component.reads.count_durations(wanted)
            component.writes.count_durations(wanted)
        for spec in list(self._manager.controllers.values()):
            spec.statistics.count_durations(wanted)


def execution_times(name: str, manager: ControllerManager, cycle: Cycle) -> Iterator[Any]:
    """Yield ExecutionTimes messages: of the cycle, its period errors, hardware and controllers.

    Args:
        name: Name of the controller manager.
        manager: Controller manager with the controllers and hardware.
        cycle: Control cycle of the manager.
    """
    rate, times = float(manager.update_rate), cycle.times
    for kind, durations, longest_ns in (
        ("cycle", times.durations, times.longest_ns),
        ("period_error", times.period_errors, times.largest_period_error_ns),
    ):
        yield _execution_times(durations, name=name, kind=kind, rate=rate, longest_ns=longest_ns)
    for component in manager.resource_manager.components.values():
        for kind, work in (("read", component.reads), ("write", component.writes)):
            yield _execution_times(
                work.durations,
                name=component.name,
                kind=kind,
                state=component.lifecycle_state.label,
                rate=float(component.rw_rate),
                longest_ns=_longest_ns(work),
            )
    for spec in list(manager.controllers.values()):
        yield _execution_times(
            spec.statistics.durations,
            name=spec.name,
            kind="update",
            state=spec.lifecycle_state.label,
            rate=float(spec.controller.update_rate),
            longest_ns=_longest_ns(spec.statistics),
            limited_commands=_limited_commands(manager, spec),
        )


def _longest_ns(work: WorkStatistics) -> int:
    return round(work.execution_time.maximum * 1e3)


# Any: fields of a message, and a message whose class is generated at run time.
def _execution_times(durations: DurationHistogram | None, **fields: Any) -> Any:
    bins = durations.bins() if durations is not None else []
    return get_message("teleopctl_msgs/msg/ExecutionTimes")(
        overruns=durations.over_limit if durations is not None else 0,
        bin_begins_ns=[begin for begin, _, _ in bins],
        bin_ends_ns=[end for _, end, _ in bins],
        bin_counts=[count for _, _, count in bins],
        **fields,
    )


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
        # An asynchronous update may take the whole period.
        longest_us = 0.0 if spec.async_update is None else 1e6 / rate
        measured = thresholds.judge(spec.name, work.execution_time, "execution_time", longest_us)
        values.append(measured)
        if rate != manager.update_rate or spec.async_update is not None:
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
        rate = component.rw_rate
        longest_us = 1e6 / rate if component.is_async else 0.0
        for part, work in (("read_cycle", component.reads), ("write_cycle", component.writes)):
            name = f"{component.name}.{part}"
            values.append(thresholds.judge(name, work.execution_time, "execution_time", longest_us))
            if rate != manager.update_rate or component.is_async:
                values.append(thresholds.judge(name, work.periodicity, "periodicity", rate))
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
            + (f" -> Desired : {expected:g} {unit}" if expected else ""),
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
