"""Checks of ``control doctor``: what keeps controllers from activation or joints from motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from teleopctl.base.typed import Any
from teleopctl.cli.verbs.control.manager import command_line, manager_option
from teleopctl.cli.verbs.doctor.findings import Finding
from teleopctl.control import managers_of_same_robot
from teleopctl.errors import did_you_mean
from teleopctl.wire import Graph

# Any: messages of controller_manager_msgs, whose classes are generated at run time.

COMMANDS_TYPE = "std_msgs/msg/Float64MultiArray"
"""Type of the messages on ``~/commands``."""
_TRAJECTORY = "/JointTrajectoryController"
_FORWARDING = (
    "ForwardCommandController",
    "JointGroupEffortController",
    "JointGroupPositionController",
    "JointGroupVelocityController",
)


_ROUNDING = 1e-4


@dataclass(frozen=True)
class ManagerSnapshot:
    """State of a controller manager, its controllers and hardware at one time.

    Attributes:
        manager: Full name of the controller manager.
        controllers: ControllerState messages of the loaded controllers.
        components: HardwareComponentState messages of the hardware.
        available: Full names of all command and state interfaces, and whether each is available.
        values: Introspection data by name; None if no control cycle has run meanwhile.
        is_stopped: Whether the robot is stopped.
        is_paused: Whether a simulation is paused.
        graph: The ROS graph.
        lengths: Number of values in a message on a controller's ``~/commands``, by topic.
        ranges: Lowest and highest command by interface, from the robot description.
    """

    manager: str
    controllers: Sequence[Any] = ()
    components: Sequence[Any] = ()
    available: Mapping[str, bool] = field(default_factory=dict)
    values: Mapping[str, float] | None = None
    is_stopped: bool = False
    is_paused: bool = False
    graph: Graph = field(default_factory=Graph)
    lengths: Mapping[str, int] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def topic(self, controller: str, name: str) -> str:
        """Return the full name of a controller's topic ``~/name``."""
        return f"{self.manager.rpartition('/')[0]}/{controller}/{name}"

    def command_line(self, verb: str, *words: str) -> str:
        """Return a command line of ``teleopctl control`` for this manager."""
        return command_line(self.manager, verb, *words)

    def with_state(self, *states: str) -> list[Any]:
        """Return the controllers that are in one of some lifecycle states."""
        return [one for one in self.controllers if one.state in states]


Check = Callable[[ManagerSnapshot, str | None], Iterator[Finding]]


def check_hardware(snapshot: ManagerSnapshot, controller: str | None) -> Iterator[Finding]:
    """Yield hardware that is not active, unless the controller uses none of its interfaces."""
    asked = [one for one in snapshot.controllers if one.name == controller]
    if not snapshot.components:
        yield Finding(
            "There is no hardware: the robot description has no <ros2_control>.",
            "teleopctl robot check FILE",
        )
    for component in snapshot.components:
        state = component.state.label
        if state == "active" or not all(_uses(one, component) for one in asked):
            continue
        if state == "finalized":
            yield Finding(
                f"Hardware '{component.name}' is finalized after a failure: start the controller "
                "manager again.",
                "teleopctl ps",
            )
        else:
            failed = "; if it has failed, the manager's log says why" * (state == "unconfigured")
            yield Finding(
                f"Hardware '{component.name}' is {state}: its joints do not move{failed}.",
                snapshot.command_line("set_hardware_component_state", component.name, "active"),
            )


def _uses(controller: Any, component: Any) -> bool:
    """Return whether a controller uses interfaces of a component, or may once it is configured."""
    needed = {*controller.required_command_interfaces, *controller.required_state_interfaces}
    interfaces = (*component.command_interfaces, *component.state_interfaces)
    return not needed or not needed.isdisjoint(one.name for one in interfaces)


def check_controllers(snapshot: ManagerSnapshot, controller: str | None) -> Iterator[Finding]:
    """Yield controllers that are not active, and why; only one controller if it is given."""
    names = [one.name for one in snapshot.controllers]
    if controller is not None and controller not in names:
        loaded = f"; loaded are {', '.join(names)}" if names else ""
        near = did_you_mean(controller, names, most=1)
        yield Finding(
            f"Controller '{controller}' is not loaded{loaded}.{f' {near}' if near else ''}",
            _spawner(snapshot, controller),
        )
    elif not names:
        yield Finding(
            "No controller is loaded.",
            "teleopctl launch spawn_controllers.yaml controllers_file:=FILE"
            if not manager_option(snapshot.manager)
            else _spawner(snapshot, "CONTROLLER"),
        )
    for one in snapshot.with_state("unconfigured", "inactive", "finalized"):
        if controller in (None, one.name):
            yield _inactive_finding(snapshot, one, is_asked=controller is not None)


def _spawner(snapshot: ManagerSnapshot, controller: str) -> str:
    words = ("spawner", controller, *manager_option(snapshot.manager), "--param-file FILE")
    return f"teleopctl run controller_manager {' '.join(words)}"


def _inactive_finding(snapshot: ManagerSnapshot, one: Any, *, is_asked: bool) -> Finding:
    subject = f"Controller '{one.name}' is {one.state}"
    # A command and a state may have the same name.
    needed = dict.fromkeys((*one.required_command_interfaces, *one.required_state_interfaces))
    missing = [name for name in needed if name not in snapshot.available]
    unavailable = [name for name in needed if not snapshot.available.get(name, True)]
    holders = {
        other.name: held
        for other in snapshot.with_state("active")
        if (held := [n for n in other.claimed_interfaces if n in one.required_command_interfaces])
    }
    if one.state == "finalized":
        return Finding(
            f"{subject} after a failure: unload it, and spawn it again.",
            snapshot.command_line("unload_controller", one.name),
        )
    if one.state == "unconfigured":
        return Finding(
            f"{subject}.", snapshot.command_line("load_controller", one.name, "--set-state active")
        )
    if missing:
        near = did_you_mean(missing[0], snapshot.available, most=1)
        return Finding(
            f"{subject}: neither hardware nor a controller has {', '.join(missing)}."
            f"{f' {near}' if near else ''}",
            snapshot.command_line("list_hardware_interfaces"),
        )
    if unavailable:
        text = f"{subject}: {', '.join(unavailable)} {_are(unavailable)} not available"
        for component in snapshot.components:
            interfaces = (*component.command_interfaces, *component.state_interfaces)
            if component.state.label != "finalized" and any(
                each.name in unavailable for each in interfaces
            ):
                return Finding(
                    f"{text}, as their hardware '{component.name}' is {component.state.label}.",
                    snapshot.command_line("set_hardware_component_state", component.name, "active"),
                )
        return Finding(f"{text}.", snapshot.command_line("list_hardware_components"))
    if holders:
        by = "; ".join(f"'{holder}' commands {', '.join(of)}" for holder, of in holders.items())
        return Finding(
            f"{subject}: {by}.",
            snapshot.command_line(
                "switch_controllers",
                f"--deactivate {' '.join(holders)} --activate {one.name}",
            ),
            is_error=is_asked,
        )
    asleep = [
        component.name
        for component in snapshot.components
        if component.state.label != "active" and _uses(one, component)
    ]
    if asleep:
        return Finding(
            f"{subject}, as is its hardware '{asleep[0]}'.",
            snapshot.command_line("set_hardware_component_state", asleep[0], "active"),
        )
    return Finding(
        f"{subject}, and could be activated.",
        snapshot.command_line("set_controller_state", one.name, "active"),
    )


def check_stop(snapshot: ManagerSnapshot, _: str | None) -> Iterator[Finding]:
    """Yield that the robot is stopped, if so: controllers refuse commands."""
    if snapshot.is_stopped:
        yield Finding(
            "The robot is stopped: commands and goals are refused.",
            "teleopctl stop --robot --release",
        )


def check_managers(snapshot: ManagerSnapshot, _: str | None) -> Iterator[Finding]:
    """Yield other controller managers of the same robot."""
    for other, topic in managers_of_same_robot(snapshot.graph.endpoints, snapshot.manager).items():
        yield Finding(
            f"{other} takes the robot description on {topic}, too: two controller managers command "
            "the same joints.",
            "teleopctl ps",
        )


def check_cycle(snapshot: ManagerSnapshot, _: str | None) -> Iterator[Finding]:
    """Yield that no control cycle runs, if so."""
    if snapshot.is_paused:
        yield Finding("The simulation is paused: no control cycle runs.", "teleopctl sim play")
    elif snapshot.values is None and all(c.state.label == "active" for c in snapshot.components):
        yield Finding(
            f"{snapshot.manager} runs no control cycle: its hardware sends no states, or its loop "
            "waits.",
            "teleopctl topic echo /diagnostics",
        )


def check_commands(snapshot: ManagerSnapshot, controller: str | None) -> Iterator[Finding]:
    """Yield active controllers without commands, and publishers of unsuitable messages to them."""
    for one in snapshot.controllers:
        if controller not in (None, one.name):
            continue
        yield from _wrong_publishers(snapshot, one)
        if one.state != "active" or snapshot.values is None:
            continue
        if one.is_chained:
            if controller is not None:
                yield Finding(
                    f"Controller '{one.name}' is chained: it takes the commands of another "
                    "controller, and none from topics.",
                    snapshot.command_line("view_controller_chains"),
                    is_error=False,
                )
            continue
        silent = [
            name
            for name in one.claimed_interfaces
            if math.isnan(snapshot.values.get(f"command_interface.{name}", 0.0))
        ]
        if silent:
            is_measured = not any(
                math.isnan(snapshot.values.get(f"state_interface.{name}", 0.0)) for name in silent
            )
            measured = "" if is_measured else "; its hardware measures NaN, too"
            yield Finding(
                f"Controller '{one.name}' is active, and has no command for {', '.join(silent)} "
                f"yet (NaN){measured}.",
                _how_to_command(snapshot, one)
                if is_measured
                else snapshot.command_line("list_hardware_components", "-v"),
                is_error=controller is not None,
            )


def _how_to_command(snapshot: ManagerSnapshot, one: Any) -> str:
    """Return the command line that sends the present state as command, if that is possible."""
    if not one.type.endswith(_FORWARDING) or snapshot.values is None:
        return f"teleopctl node info {snapshot.topic(one.name, '')[:-1]}"
    states = [snapshot.values.get(f"state_interface.{n}", 0.0) for n in one.claimed_interfaces]
    data = ", ".join(str(round(value, 3) + 0.0) for value in states)
    topic = snapshot.topic(one.name, "commands")
    return f"teleopctl topic pub --once {topic} {COMMANDS_TYPE} '{{data: [{data}]}}'"


def _wrong_publishers(snapshot: ManagerSnapshot, one: Any) -> Iterator[Finding]:
    prefix = snapshot.topic(one.name, "")
    taken = {
        endpoint.name: endpoint.type_name
        for endpoint in snapshot.graph.endpoints
        if endpoint.kind.name == "MS" and endpoint.full_name == prefix[:-1]
        if endpoint.name.startswith(prefix)
    }
    for topic, type_name in sorted(taken.items()):
        for publisher in snapshot.graph.publishers(topic):
            if publisher.type_name != type_name:
                yield Finding(
                    f"{publisher.full_name} publishes {publisher.type_name} on {topic}, where "
                    f"'{one.name}' takes {type_name}.",
                    f"teleopctl topic info --verbose {topic}",
                )
    topic = snapshot.topic(one.name, "commands")
    length, expected = snapshot.lengths.get(topic), _values_per_command(one)
    if length is not None and expected and length != len(expected):
        yield Finding(
            f"Messages on {topic} have {length} value{'s' if length != 1 else ''}, '{one.name}' "
            f"takes {len(expected)}: {', '.join(expected)}.",
            f"teleopctl topic echo --once {topic}",
        )


def _values_per_command(one: Any) -> list[str]:
    """Return the meaning of the values in a message on ``~/commands``."""
    names = list(one.required_command_interfaces)
    if one.type.endswith(_TRAJECTORY):
        # It takes one position for each joint.
        return list(dict.fromkeys(name.rpartition("/")[0] for name in names))
    return names if one.type.endswith(_FORWARDING) else []


def check_limits(snapshot: ManagerSnapshot, controller: str | None) -> Iterator[Finding]:
    """Yield commands of active controllers that are beyond limits of their joints.

    The controller manager clamps them if it enforces limits; otherwise the robot stops there.
    """
    values = snapshot.values or {}
    for one in snapshot.with_state("active"):
        if controller not in (None, one.name):
            continue
        beyond = [
            f"{name} ({how}, measured {values.get(f'state_interface.{name}', math.nan):g})"
            for name in one.claimed_interfaces
            if (how := _beyond_limits(snapshot, name))
        ]
        if beyond:
            topic = "controller_state" if one.type.endswith(_TRAJECTORY) else "commands"
            yield Finding(
                f"Controller '{one.name}' commands more than the limits of its joints: "
                f"{', '.join(beyond)}.",
                f"teleopctl topic echo --once {snapshot.topic(one.name, topic)}",
            )


def _beyond_limits(snapshot: ManagerSnapshot, name: str) -> str:
    """Return the command of an interface and the limits that it exceeds; empty if none."""
    values = snapshot.values or {}
    command = values.get(f"command_interface.{name}", math.nan)
    if values.get(f"command_interface.{name}.is_limited"):
        return f"clamped to {command:g}"
    lower, upper = snapshot.ranges.get(name, (-math.inf, math.inf))
    # The tolerance is for limits that are rounded in a description.
    if math.isnan(command) or lower - _ROUNDING <= command <= upper + _ROUNDING:
        return ""
    return f"{command:g}, limits [{lower:g}, {upper:g}]"


def _are(things: Sequence[str]) -> str:
    return "is" if len(things) == 1 else "are"


CHECKS: Mapping[str, Check] = {
    "managers": check_managers,
    "hardware": check_hardware,
    "controllers": check_controllers,
    "stop": check_stop,
    "cycle": check_cycle,
    "commands": check_commands,
    "limits": check_limits,
}
"""Checks by their subjects, in the order in which a user would look."""
