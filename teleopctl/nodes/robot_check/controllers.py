"""Check that a robot's controllers move it: ros2_control and simulator in lockstep, in memory.

Resource manager, controller manager, controllers and the simulator's loop are those of
``sim.yaml``; messages are passed in memory, without a ROS graph.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from teleopctl.control import (
    ControllerSpec,
    ControlStack,
    State,
    SwitchRequest,
    controller_load_parameters,
    switch_controller,
)
from teleopctl.errors import InvalidParameterError, TeleopctlError
from teleopctl.node import read_parameter_file
from teleopctl.nodes.robot_check.base_motion import planar_move_motions
from teleopctl.nodes.robot_check.controller_tester import ControllerTester, ControllerTrial
from teleopctl.robot import COMMANDS_TOPIC, STATES_TOPIC

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

    from teleopctl.robot import ChosenControllers
    from teleopctl.sim import SimulatedRobot

_MANAGER = "controller_manager"
PLANAR_MOVE = "planar_move"
"""Type in the report for a Gazebo plug-in that moves a base instead of a controller."""
_DEFAULT_RATE_HZ = 100
# The simulator's highest update rate.
_MOST_HZ = 100_000
# Seconds with states only before the controllers are activated, and seconds for which the
# controllers hold afterwards.
_BEFORE_S = 0.1
_SETTLING_S = 0.5


@dataclass
class ControllerReport:
    """Result of testing all controllers of a robot in simulation.

    Attributes:
        own: Whether the controllers are the robot's own, not defaults.
        motions: Results of the controllers that command joints or a base.
        inactive: Controllers that did not become active, with the reason.
        joints: Joints whose state a controller publishes.
        fault: Reason why the test is incomplete; empty if it is complete.
    """

    own: bool
    motions: list[ControllerTrial] = field(default_factory=list)
    inactive: dict[str, str] = field(default_factory=dict)
    joints: set[str] = field(default_factory=set)
    fault: str = ""

    @property
    def verdict(self) -> str:
        """Whether controllers moved the robot: ``yes``, ``no``, ``N of M``, or ``-`` for none."""
        if self.fault:
            return "no"
        if not self.motions:
            return "no" if self.own and self.inactive else "-"
        moved = sum(motion.moved for motion in self.motions)
        return {0: "no", len(self.motions): "yes"}.get(moved, f"{moved} of {len(self.motions)}")

    @property
    def why_not(self) -> str:
        """First controller that failed, and the reason, as text; empty if none failed."""
        if self.fault:
            return self.fault
        still = [motion for motion in self.motions if not motion.moved]
        if still:
            return f"controller '{still[0].controller}': {still[0].result}"
        if not self.motions and self.own and self.inactive:
            (name, why), *others = self.inactive.items()
            more = f" and {len(others)} more" if others else ""
            return f"controller '{name}'{more}: {why}"
        return ""


def check_controllers(
    robot: SimulatedRobot, controllers: ChosenControllers | None
) -> ControllerReport | None:
    """Test controllers and planar-move plug-ins in simulation; return a report, None without any.

    Args:
        robot: Simulated robot, whose model is used for the new simulation.
        controllers: Controllers of the robot; None for a robot without controllers.

    Returns:
        Report; None if neither a controller nor a planar-move plug-in moves the robot.
    """
    driven = ControllerReport(controllers is not None and controllers.own)
    for topic, way in planar_move_motions(robot).items():
        driven.own = True
        driven.motions.append(ControllerTrial(topic, PLANAR_MOVE, way.is_enough, way.summary))
    if controllers is None:
        return driven if driven.motions else None
    try:
        _run_controllers(robot, controllers, driven)
    except TeleopctlError as error:
        driven.fault = f"{error.message} ({error.hint})" if error.hint else error.message
    return driven


def _run_controllers(
    robot: SimulatedRobot, given: ChosenControllers, driven: ControllerReport
) -> None:
    from teleopctl.sim import Simulation, run_in_lockstep

    file = read_parameter_file(given.file)
    manager = f"{given.namespace}/{_MANAGER}"
    parameters = file.for_node(manager)
    rate = parameters.get("update_rate", _DEFAULT_RATE_HZ)
    if isinstance(rate, bool) or not isinstance(rate, int) or not 1 <= rate <= _MOST_HZ:
        raise InvalidParameterError(
            f"{given.file}: update_rate of '{manager}' is {rate!r}, expected a whole number "
            f"from 1 to {_MOST_HZ}"
        )
    simulation = Simulation(robot.model, control_period_ns=round(1e9 / rate))
    simulation.movers = robot.simulation.movers
    stack = ControlStack(update_rate=rate, parameters=parameters, last_only=True)
    stack.time_ns = 0
    stack.load_urdf(robot.description.urdf)
    hardware = [component.hardware for component in stack.resources.components.values()]
    # The states of one component start the cycles, which read and write all components.
    next(one for one in hardware if one.drives_cycle).set_cycle(stack.cycle.run)
    tester = ControllerTester(stack, simulation, robot)
    script = _script(stack, given, tester, driven)
    ended = False

    def answer(time_ns: int, state: JointState) -> JointState | None:
        nonlocal ended
        stack.time_ns = time_ns
        stack.node.receive(STATES_TOPIC, state)
        ended = next(script, True) is True
        command: JointState = stack.node.published(COMMANDS_TOPIC)[-1]
        return command

    run_in_lockstep(simulation, answer, lambda _: not ended and not simulation.diverged)
    if simulation.diverged:
        driven.fault = f"physics diverged after {stack.time_ns * 1e-9:.2f} s with its controllers"
    for node in stack.nodes.values():
        for name, endpoint in node.endpoints.items():
            if name.endswith("joint_states") and endpoint.messages:
                driven.joints.update(getattr(endpoint.messages[-1], "name", ()))


def _script(
    stack: ControlStack,
    given: ChosenControllers,
    tester: ControllerTester,
    driven: ControllerReport,
) -> Iterator[None]:
    """Yield after each control period of the test: wait, activate controllers, command each."""
    yield from tester.wait(_BEFORE_S)
    for name in given.names:
        if why := _bring_up(stack, name, given):
            driven.inactive[name] = why
    yield from tester.wait(_SETTLING_S)
    for spec in list(stack.manager.controllers.values()):
        if spec.lifecycle_state is State.ACTIVE:
            yield from tester.try_controller(spec, driven.motions)


def _bring_up(stack: ControlStack, name: str, given: ChosenControllers) -> str:
    """Load, configure and activate a controller as the spawner does; return a failure's reason."""
    before = len(stack.log.lines)
    settings = controller_load_parameters(name, f"{given.namespace}/{_MANAGER}", [str(given.file)])
    if "type" in settings:
        stack.node.declare_parameter(f"{name}.type", settings["type"])
    stack.set_controller_parameters(name, _parameters(name, given))
    manager = stack.manager
    if not (manager.load_controller(name) and manager.configure_controller(name)):
        return _reason(stack, manager.controllers.get(name), before)
    accepted, message = switch_controller(manager, SwitchRequest((name,), ()))
    return "" if accepted else message or _reason(stack, manager.controllers[name], before)


# Any: parameter values have one of nine types.
def _parameters(name: str, given: ChosenControllers) -> Mapping[str, Any]:
    """Return a controller's parameters, including those given below the manager's node."""
    file = read_parameter_file(given.file)
    prefix = f"{name}."
    below = {
        key.removeprefix(prefix): value
        for key, value in file.for_node(f"{given.namespace}/{_MANAGER}").items()
        if key.startswith(prefix)
    }
    return {**below, **file.for_node(f"{given.namespace}/{name}")}


def _reason(stack: ControlStack, spec: ControllerSpec | None, before: int) -> str:
    """Return the last error that was logged about a controller."""
    said = [text for kind, text in stack.log.lines[before:] if kind == "error"]
    if spec is not None:
        said += stack.nodes[spec.name].log.texts("error")
    return said[-1] if said else "refused"
