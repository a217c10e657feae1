"""Gripper action controllers for one joint, which report whether the gripper stalled."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.pid import Pid, PidGains
from teleopctl.control.controllers.realtime_goal import RealtimeServerGoalHandle
from teleopctl.control.handles import (
    EFFORT,
    POSITION,
    VELOCITY,
    CommandInterface,
    MeasuredValues,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from teleopctl.node import CancelResponse, GoalResponse, ServerGoalHandle

# Any: message classes are generated at run time from definitions.


@dataclass(frozen=True)
class _Command:
    """Command of a gripper.

    Attributes:
        position: Position, rad or m.
        effort: Largest effort, N·m or N.
        velocity: Largest velocity, rad/s or m/s; used only with a velocity interface.
    """

    position: float
    effort: float
    velocity: float = 0.0


class _GripperController(ControllerInterface):
    """Common base of the gripper action controllers.

    A goal is reached within ``goal_tolerance``. A gripper that has not moved for ``stall_timeout``
    seconds has stalled, for example on an object between its fingers: with ``allow_stalling`` the
    goal then succeeds, else it is aborted. A new goal aborts the previous one; a cancelled goal
    holds the present position.
    """

    action_type: ClassVar[str]
    command_interface: ClassVar[str] = POSITION
    default_max_effort: ClassVar[float] = 0.0

    def on_init(self) -> None:
        """Declare the parameters, and mark them for re-reading whenever one is changed."""
        self.auto_declare("joint", "", read_only=True)
        self._read_parameters()
        self._stale_parameters = False
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    def _parameters_changed(self, parameters: object) -> None:
        del parameters
        self._stale_parameters = True

    def _read_parameters(self) -> None:
        self._stale_parameters = False
        self._goal_tolerance = self.auto_declare("goal_tolerance", 0.01)
        self._max_effort = self.auto_declare("max_effort", self.default_max_effort)
        self._allow_stalling = self.auto_declare("allow_stalling", False)
        self._stall_velocity = self.auto_declare("stall_velocity_threshold", 0.001)
        self._stall_timeout_ns = round(
            self.auto_declare("stall_timeout", 1.0) * NANOSECONDS_PER_SECOND
        )

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the action server ``~/gripper_cmd``."""
        from teleopctl.interfaces import get_action

        self._joint = self.auto_declare("joint", "")
        if not self._joint:
            self.logger.error("Joint name cannot be empty")
            return CallbackReturn.ERROR
        self._read_parameters()
        self._active = False
        self._incoming: deque[tuple[_Command, RealtimeServerGoalHandle]] = deque(maxlen=1)
        self._latest: RealtimeServerGoalHandle | None = None
        self._goal: RealtimeServerGoalHandle | None = None
        self._action: Any = get_action(self.action_type)
        self._server = self.create_action_server(
            self._action,
            "~/gripper_cmd",
            goal_callback=self._on_goal_request,
            handle_accepted_callback=self._begin,
            cancel_callback=self._on_cancel_request,
        )
        return None

    def on_cleanup(self) -> None:
        """Destroy the action server ``~/gripper_cmd``."""
        self._server.destroy()

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the joint's command interface, by default position."""
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL, [f"{self._joint}/{self.command_interface}"]
        )

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the joint's position and velocity interfaces."""
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL,
            [f"{self._joint}/{POSITION}", f"{self._joint}/{VELOCITY}"],
        )

    def on_activate(self) -> None:
        """Accept goals, and hold the gripper at the position measured in the first update."""
        self._incoming.clear()
        self._goal = None
        self._measured = MeasuredValues(self.state_interfaces)
        self._command = _Command(math.nan, self._max_effort)
        self._effort = 0.0
        self._active = True

    def on_deactivate(self) -> None:
        """Reject further goals, and abort the running goal."""
        self._active = False
        self._abort_latest()
        self._goal = None

    # Attributes that new code takes over; some are set by the first goal.
    _KEPT = ("_command", "_goal", "_latest", "_effort", "_moved_ns")

    def export_state(self) -> dict[str, Any]:
        """Return the command and the goals."""
        kept = {name: vars(self)[name] for name in self._KEPT if name in vars(self)}
        return {"attributes": kept, "incoming": list(self._incoming)}

    def import_state(self, state: dict[str, Any]) -> None:
        """Continue with the command and the goals of the replaced instance."""
        vars(self).update(state["attributes"])
        self._incoming.extend(state["incoming"])

    def on_restart(self) -> None:
        """Hold the present position and abort the goal: the joints have jumped or stood still."""
        position = self.state_interfaces[0].value
        if self.params.robot_stop.standstill:
            # Received before commands were refused.
            self._discard_waiting(position)
        self._hold(position)
        self._abort_goal(position)

    def abort_goals(self, reason: str) -> None:
        """Abort the goal, while no control cycle runs; the manager logs the reason."""
        del reason
        self._abort_latest()

    def on_stop(self) -> None:
        """Abort the goals, and hold the position of a gripper on its way to one."""
        position = self.state_interfaces[0].value
        moving = self._goal is not None or bool(self._incoming)
        self._discard_waiting(position)
        self._abort_goal(position)
        if moving and math.isfinite(position):
            self._hold(position)
            for command in self.interfaces_to_decelerate():
                # The joint decelerates from here: a goal is a step, however near it is.
                command.value = position

    def on_release(self) -> None:
        """Hold the position that was commanded last, while the robot was stopped."""
        for command in self.interfaces_to_decelerate():
            if math.isfinite(command.value):
                self._hold(command.value)

    def interfaces_to_decelerate(self) -> Sequence[CommandInterface]:
        """Return the position command; none with an effort command, which holds the position."""
        return [
            command for command in self.command_interfaces if command.interface_name == POSITION
        ]

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Write the gripper command; end the goal if it is reached, stalled or canceled."""
        if self._stale_parameters:
            self._read_parameters()
        position, velocity = (state.value for state in self.state_interfaces)
        last = self._measured.read()[0]
        if self._measured.watch(period):
            self._measurement_changed(last, period)
        if not (math.isfinite(position) and math.isfinite(velocity)):
            if self._measured.lost:
                self._discard_waiting(last)
            return None
        if self._incoming:
            self._command, self._goal = self._incoming.pop()
            self._moved_ns = time_ns
        goal = self._goal
        if goal is not None and goal.cancel_requested:
            self._hold(position)
            goal.try_cancel(**self._result(position))
            self._goal = goal = None
        if math.isnan(self._command.position):
            self._hold(position)
        error = self._command.position - position
        if goal is not None:
            self._check(goal, time_ns, position, error, velocity)
        self._effort = self._write(self._command, error, velocity, period)
        return None

    def _measurement_changed(self, last: float, period: float) -> None:
        """Stop at the last measured position while the joint is not measured; abort the goal."""
        lost = self._measured.lost
        if not lost or not math.isfinite(last):
            return
        log = realtime_log(self.params.publish_queue)
        log.try_publish((self.logger.error, f"{lost}: the gripper stops, and goals are aborted"))
        self._abort_goal(last)
        self._hold(last)
        self._effort = self._write(self._command, 0.0, 0.0, period)

    def _discard_waiting(self, position: float) -> None:
        while self._incoming:
            self._incoming.pop()[1].try_abort(**self._result(position))

    def _abort_goal(self, position: float) -> None:
        if self._goal is not None:
            self._goal.try_abort(**self._result(position))
            self._goal = None

    def _hold(self, position: float) -> None:
        self._command = _Command(position, self._max_effort, self._command.velocity)

    def _check(
        self,
        goal: RealtimeServerGoalHandle,
        time_ns: int,
        position: float,
        error: float,
        velocity: float,
    ) -> None:
        """End the goal if the gripper is at the position or has stalled."""
        if abs(error) < self._goal_tolerance:
            goal.try_succeed(**self._result(position, reached_goal=True))
            self._goal = None
        elif abs(velocity) > self._stall_velocity or time_ns < self._moved_ns:
            self._moved_ns = time_ns
        elif time_ns - self._moved_ns > self._stall_timeout_ns:
            end = goal.try_succeed if self._allow_stalling else goal.try_abort
            end(**self._result(position, stalled=True))
            self._goal = None

    # -- callbacks of the action -------------------------------------------------------------------

    def _on_goal_request(self, goal: Any) -> GoalResponse:
        from teleopctl.node import GoalResponse

        if not self._active:
            self.logger.error("Can't accept new action goals. Controller is not running.")
            return GoalResponse.REJECT
        if self.is_refused("The action goal", getattr(self._server, "goal_sender", b"")):
            return GoalResponse.REJECT
        problem = self._problem(goal)
        if problem:
            self.logger.error(problem)
            return GoalResponse.REJECT
        self.logger.info("Received & accepted new action goal")
        return GoalResponse.ACCEPT

    def _begin(self, handle: ServerGoalHandle[Any, Any, Any]) -> None:
        self._abort_latest()
        self._latest = goal = RealtimeServerGoalHandle(
            handle, self._action, self.params.publish_queue
        )
        goal.start()
        if self.is_refused("The action goal"):
            self._abort_latest()
            return
        self._incoming.append((self._command_of(handle.request), goal))
        if not self._active:
            self._abort_latest()

    def _on_cancel_request(self, handle: ServerGoalHandle[Any, Any, Any]) -> CancelResponse:
        from teleopctl.node import CancelResponse

        del handle
        self.logger.info("Got request to cancel goal")
        return CancelResponse.ACCEPT

    def _abort_latest(self) -> None:
        goal, self._latest = self._latest, None
        if goal is not None:
            goal.abort(**self._result(self.state_interfaces[0].value))

    # -- implemented by subclasses -----------------------------------------------------------------

    def _problem(self, goal: Any) -> str | None:
        """Return why a goal cannot be accepted; None if it can."""
        raise NotImplementedError

    def _command_of(self, goal: Any) -> _Command:
        """Return the gripper command of a goal."""
        raise NotImplementedError

    def _write(self, command: _Command, error: float, velocity: float, period: float) -> float:
        """Write the command to the interfaces; return the effort."""
        raise NotImplementedError

    def _result(
        self, position: float, *, reached_goal: bool = False, stalled: bool = False
    ) -> dict[str, object]:
        """Return the fields of a goal's result."""
        raise NotImplementedError


class _GripperCommandController(_GripperController):
    """Base of controllers with the action control_msgs/action/GripperCommand."""

    action_type = "control_msgs/action/GripperCommand"

    def _problem(self, goal: Any) -> str | None:
        position = goal.command.position
        return None if math.isfinite(position) else f"The position {position} is not a number"

    def _command_of(self, goal: Any) -> _Command:
        return _Command(goal.command.position, goal.command.max_effort)

    def _result(
        self, position: float, *, reached_goal: bool = False, stalled: bool = False
    ) -> dict[str, object]:
        return {
            "position": position,
            "effort": self._effort,
            "stalled": stalled,
            "reached_goal": reached_goal,
        }


class PositionGripperActionController(_GripperCommandController):
    """Controller that moves a gripper by position commands for GripperCommand goals.

    Plug-in type ``position_controllers/GripperActionController``.
    """

    def _write(self, command: _Command, error: float, velocity: float, period: float) -> float:
        del error, velocity, period
        self.command_interfaces[0].value = command.position
        return command.effort


class EffortGripperActionController(_GripperCommandController):
    """Controller that moves a gripper by a PID, within the effort of a GripperCommand goal.

    Plug-in type ``effort_controllers/GripperActionController``.
    """

    command_interface = EFFORT

    def on_activate(self) -> None:
        """Hold the position measured in the first update, with a new PID from the parameters."""
        super().on_activate()
        read = self.auto_declare
        clamp = abs(read(f"gains.{self._joint}.i_clamp", 0.0))
        p, i, d = (read(f"gains.{self._joint}.{name}", 0.0) for name in "pid")
        self._pid = Pid(PidGains(p, i, d, i_clamp_max=clamp, i_clamp_min=-clamp))

    def export_state(self) -> dict[str, Any]:
        """Return the command, the goals, and the state of the PID."""
        return super().export_state() | {"pid": self._pid.export_state()}

    def import_state(self, state: dict[str, Any]) -> None:
        """Continue with command, goals and integral of the replaced instance."""
        super().import_state(state)
        self._pid.import_state(state["pid"])

    def on_restart(self) -> None:
        """Hold the present position and reset the PID, after a simulation reset."""
        super().on_restart()
        self._pid.reset()

    def on_deactivate(self) -> None:
        """Reject further goals, abort the running goal, and command zero effort."""
        super().on_deactivate()
        self.command_interfaces[0].value = 0.0

    def _write(self, command: _Command, error: float, velocity: float, period: float) -> float:
        limit = abs(command.effort)
        effort = min(max(self._pid.update(error, -velocity, period), -limit), limit)
        self.command_interfaces[0].value = effort
        return effort


class ParallelGripperActionController(_GripperController):
    """Controller that moves a gripper by position commands for ParallelGripperCommand goals.

    Plug-in type ``parallel_gripper_action_controller/GripperActionController``.
    """

    action_type = "control_msgs/action/ParallelGripperCommand"
    # In N, as in ROS 2.
    default_max_effort = 10.0

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, with optional interface names, and create the action server."""
        self._max_velocity = self.auto_declare("max_velocity", 0.1)
        self._effort_interface = self.auto_declare("max_effort_interface", "")
        self._velocity_interface = self.auto_declare("max_velocity_interface", "")
        return super().on_configure()

    def on_activate(self) -> None:
        """Accept goals, and hold the gripper at the position measured in the first update."""
        super().on_activate()
        self._command = _Command(math.nan, self._max_effort, self._max_velocity)

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the position interface, and those for maximum effort and velocity if set."""
        names = [f"{self._joint}/{POSITION}", self._effort_interface, self._velocity_interface]
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL, [name for name in names if name]
        )

    def _problem(self, goal: Any) -> str | None:
        positions = goal.command.position
        if len(positions) != 1:
            return (
                "Received action goal with wrong number of position values, expects 1, got "
                f"{len(positions)}"
            )
        if not math.isfinite(positions[0]):
            return f"The position {positions[0]} is not a number"
        return None

    def _command_of(self, goal: Any) -> _Command:
        command = goal.command
        effort, velocity = self._max_effort, self._max_velocity
        if self._effort_interface and len(command.effort):
            effort = float(command.effort[0])
        if self._velocity_interface and len(command.velocity):
            velocity = float(command.velocity[0])
        return _Command(float(command.position[0]), effort, velocity)

    def _hold(self, position: float) -> None:
        self._command = _Command(position, self._max_effort, self._max_velocity)

    def _write(self, command: _Command, error: float, velocity: float, period: float) -> float:
        del error, velocity, period
        for interface in self.command_interfaces:
            if interface.name == self._effort_interface:
                interface.value = command.effort
            elif interface.name == self._velocity_interface:
                interface.value = command.velocity
            else:
                interface.value = command.position
        return command.effort if self._effort_interface else 0.0

    def _result(
        self, position: float, *, reached_goal: bool = False, stalled: bool = False
    ) -> dict[str, object]:
        from teleopctl.interfaces import get_message

        state = get_message("sensor_msgs/msg/JointState")(
            name=[self._joint], position=[position], effort=[self._effort]
        )
        return {"state": state, "stalled": stalled, "reached_goal": reached_goal}
