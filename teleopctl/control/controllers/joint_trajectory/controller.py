"""Moves joints along trajectories."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

from teleopctl.control.controllers.base import (
    ControllerInterface,
    ControllerInterfaceParams,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.joint_trajectory.inputs import Incoming, TrajectoryInputs
from teleopctl.control.controllers.joint_trajectory.pid import Pid
from teleopctl.control.controllers.joint_trajectory.points import TrajectoryPoint
from teleopctl.control.controllers.joint_trajectory.settings import (
    UNSUPPORTED,
    InvalidSettingsError,
    read_gains,
    read_settings,
    read_tolerances,
)
from teleopctl.control.controllers.joint_trajectory.state import (
    MeasuredValues,
    TrajectoryStatePublisher,
)
from teleopctl.control.controllers.joint_trajectory.tolerances import violation
from teleopctl.control.controllers.joint_trajectory.trajectory import (
    Sample,
    Trajectory,
    shortest_angle,
)
from teleopctl.control.handles import (
    ACCELERATION,
    EFFORT,
    POSITION,
    VELOCITY,
    CommandInterface,
    StateInterface,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND


class JointTrajectoryController(ControllerInterface):
    """``joint_trajectory_controller/JointTrajectoryController``.

    Commands lead by one period: what is written is where the trajectory will be when the next
    command can be written. Trajectories come over ``~/joint_trajectory`` and ``~/commands``; the
    action ``~/follow_joint_trajectory`` is not offered.
    """

    def __init__(self, params: ControllerInterfaceParams) -> None:
        super().__init__(params)
        self._incoming: deque[Incoming] = deque(maxlen=1)
        self._trajectory = Trajectory()
        self._holding = False
        self._trajectory_ns = 0
        self._commanded_ns = 0
        self._last_update_ns = 0
        self._stale_parameters = False

    def on_init(self) -> None:
        """Declare the parameters that do not depend on others."""
        for name in ("joints", "command_joints", "command_interfaces", "state_interfaces"):
            self.auto_declare(name, [], read_only=True)
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    def _parameters_changed(self, parameters: object) -> None:
        del parameters
        self._stale_parameters = True

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters and open the topics."""
        try:
            self._settings = settings = read_settings(self.auto_declare)
        except InvalidSettingsError as error:
            self.logger.error(str(error))
            return CallbackReturn.FAILURE
        if self.auto_declare("open_loop_control", False):
            self.logger.warning(
                "[Deprecated] 'open_loop_control' parameter is deprecated. Instead, set the "
                "feedback gains to zero and use 'interpolate_from_desired_state' parameter"
            )
        for name in UNSUPPORTED:
            if self.get_node().has_parameter(name) and self.get_node().get_parameter(name).value:
                self.logger.warning(f"Parameter '{name}' is not supported and has no effect.")
        self._tolerances = read_tolerances(settings.joints, self.auto_declare)
        self._scaling = settings.initial_scaling
        self._pids = [Pid(read_gains(joint, self.auto_declare)) for joint in settings.joints]
        self._stale_parameters = False
        self._wrap = [joint in self.params.continuous_joints for joint in settings.joints]
        self._wraps = any(self._wrap)
        commanded = dict(zip(settings.command_joints, range(len(settings.joints)), strict=False))
        if len(settings.command_joints) < len(settings.joints):
            commanded = {joint: settings.joints.index(joint) for joint in settings.command_joints}
        self._commanded = list(commanded.values())
        self._inputs = TrajectoryInputs(self, settings, self._incoming)
        self._state_publisher = TrajectoryStatePublisher(
            self.get_node(), self.params.publish_queue, settings
        )
        # Logging is output: not inside the cycle.
        self._log = realtime_log(self.params.publish_queue)
        self.logger.info(
            f"Command interfaces are [{' '.join(settings.command_interfaces)}] and "
            f"state interfaces are [{' '.join(settings.state_interfaces)}]."
        )
        return None

    def on_cleanup(self) -> None:
        """Close the topics."""
        self._inputs.close()
        self._state_publisher.close()

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Joint by joint, in the order of the parameters."""
        settings = self._settings
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL,
            [
                f"{j}/{name}"
                for j in settings.command_joints
                for name in settings.command_interfaces
            ],
        )

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Joint by joint, in the order of the parameters; then the speed scaling."""
        settings = self._settings
        names = [f"{j}/{name}" for j in settings.joints for name in settings.state_interfaces]
        if settings.scaling_state_interface:
            names.append(settings.scaling_state_interface)
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def on_activate(self) -> None:
        """Hold: the last command where there is one, else what is measured."""
        self._sort_interfaces()
        for pid in self._pids:
            pid.reset()
        held = self._position_states.read()
        last = self._last_command()
        if self._settings.hold_last_command and last is not None:
            held = last
        self._incoming.clear()
        # A trajectory that comes before the first update goes on from what is commanded, too.
        self._has_command = held is last
        self._commanded_state = TrajectoryPoint(held)
        self._last_update_ns = 0
        # A simulation that is paused has not told yet where its joints are: hold them once it has.
        self._awaits_state = not all(map(math.isfinite, held))
        self._hold(held)
        self._inputs.active = True

    def _sort_interfaces(self) -> None:
        """Find each joint's interfaces by quantity, so that ``update`` only walks lists."""
        settings = self._settings
        count = len(settings.state_interfaces)
        by_state: dict[str, list[StateInterface]] = {
            name: self.state_interfaces[index : len(settings.joints) * count : count]
            for index, name in enumerate(settings.state_interfaces)
        }
        self._position_states = MeasuredValues(by_state[POSITION])
        self._velocity_states = MeasuredValues(by_state.get(VELOCITY, []))
        self._acceleration_states = MeasuredValues(by_state.get(ACCELERATION, []))
        self._scaling_state = (
            self.state_interfaces[-1] if settings.scaling_state_interface else None
        )
        count = len(settings.command_interfaces)
        self._outputs: dict[str, list[CommandInterface]] = {
            name: self.command_interfaces[index::count]
            for index, name in enumerate(settings.command_interfaces)
        }

    def _last_command(self) -> list[float] | None:
        """The values on the position command interfaces, if there are any for all joints."""
        outputs = self._outputs.get(POSITION)
        if not outputs or len(outputs) != len(self._settings.joints):
            return None
        values = [output.value for output in outputs]
        return values if all(map(math.isfinite, values)) else None

    def on_deactivate(self) -> None:
        """Positions keep their command; everything that moves or pushes is set to zero."""
        self._inputs.active = False
        for name, outputs in self._outputs.items():
            if name != POSITION:
                for output in outputs:
                    output.value = 0.0

    def _hold(self, positions: list[float]) -> None:
        self._trajectory = Trajectory([TrajectoryPoint(list(positions))])
        self._holding = True

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """One step along the trajectory."""
        if self._stale_parameters:
            self._read_changed_parameters()
        positions = self._position_states.read()
        velocities = self._velocity_states.read()
        if self._awaits_state:
            if not all(map(math.isfinite, positions)):
                return None
            self._awaits_state = False
            self._hold(positions)
        if time_ns < self._last_update_ns:
            # The clock went back (a simulation began again): old start times mean nothing now.
            self._has_command = False
            self._hold(positions)
        self._last_update_ns = time_ns
        if self._scaling_state is not None and math.isfinite(self._scaling_state.value):
            self._scaling = max(0.0, self._scaling_state.value)
        if self._incoming:
            self._take_over(self._incoming.pop())
        trajectory, method = self._trajectory, self._settings.method
        first = not trajectory.sampled_already
        if first:
            self._begin(trajectory, time_ns, positions, velocities)
        else:
            self._trajectory_ns += round(period * self._scaling * NANOSECONDS_PER_SECOND)
        now = self._trajectory_ns
        desired = trajectory.sample(now, method)
        ahead = now + round(NANOSECONDS_PER_SECOND * self._scaling / self.update_rate)
        # A slower pace shortens the lead; what has been commanded is not taken back.
        self._commanded_ns = ahead = ahead if first else max(ahead, self._commanded_ns)
        command = trajectory.sample(ahead, method, advance=False)
        if desired is None or command is None:
            return None
        errors = self._errors(desired.state.positions, positions)
        rates = zip(desired.state.velocities, velocities, strict=False)
        velocity_errors = [wanted - is_now for wanted, is_now in rates]
        if self._within_tolerances(desired, errors, velocity_errors, first=first):
            self._write(command.state, errors, velocity_errors, period)
            self._commanded_state, self._has_command = command.state, True
        else:
            self._hold(positions)
        self._publish(time_ns, desired.state, positions, velocities, errors, velocity_errors)
        return None

    def _take_over(self, incoming: Incoming) -> None:
        """Replace the trajectory; joints that it leaves out stay where they are commanded to be."""
        current = self._last_command() or self._position_states.read()
        self._trajectory = Trajectory(incoming.points(current), incoming.start_ns)
        self._from_command = incoming.from_command or self._settings.open_loop
        self._holding = False

    def _begin(
        self, trajectory: Trajectory, time_ns: int, positions: list[float], velocities: list[float]
    ) -> None:
        """Fix where the trajectory begins: where the robot is, or where it is commanded to be."""
        self._trajectory_ns = time_ns
        if not self._holding and self._from_command and self._has_command:
            last = self._last_command()
            before = (
                self._commanded_state
                if last is None
                else replace(self._commanded_state, positions=last)
            )
            # The last command was for now: commands lead by one period.
            trajectory.set_point_before(time_ns, before, self._wrap)
            return
        before = TrajectoryPoint(positions, velocities, self._acceleration_states.read())
        trajectory.set_point_before(time_ns, before, self._wrap)

    def _errors(self, desired: list[float], measured: list[float]) -> list[float]:
        if not self._wraps:
            return [wanted - is_now for wanted, is_now in zip(desired, measured, strict=True)]
        return [
            shortest_angle(is_now, wanted) if wrap else wanted - is_now
            for wanted, is_now, wrap in zip(desired, measured, self._wrap, strict=True)
        ]

    def _within_tolerances(
        self, desired: Sample, errors: list[float], velocity_errors: list[float], *, first: bool
    ) -> bool:
        if self._holding:
            return True
        trajectory, tolerances = self._trajectory, self._tolerances
        joints = self._settings.joints
        running = desired.end_index < len(trajectory.points)
        if running or first:
            failure = violation(tolerances.path, joints, errors, velocity_errors)
            if failure:
                reason = "Holding position due to state tolerance violation"
                self._log.try_publish(
                    (self.logger.error, f"State tolerances failed for {failure}", reason)
                )
                return False
        if running:
            return True
        late = (self._trajectory_ns - trajectory.end_ns) / NANOSECONDS_PER_SECOND
        if 0.0 < tolerances.goal_time < late:
            failure = violation(tolerances.goal, joints, errors, velocity_errors)
            if failure:
                reason = "Exceeded goal_time_tolerance: holding position..."
                self._log.try_publish(
                    (self.logger.error, f"State tolerances failed for {failure}", reason)
                )
                return False
        if 0.0 < self._settings.cmd_timeout < late:
            self._log.try_publish((self.logger.warning, "Aborted due to command timeout"))
            return False
        return True

    def _write(
        self,
        state: TrajectoryPoint,
        errors: list[float],
        velocity_errors: list[float],
        period: float,
    ) -> None:
        outputs, commanded = self._outputs, self._commanded
        uses_pid = self._settings.uses_pid
        for name, values in (
            (POSITION, state.positions),
            (ACCELERATION, state.accelerations),
            (VELOCITY, state.velocities),
            (EFFORT, state.effort),
        ):
            interfaces = outputs.get(name)
            if interfaces is None:
                continue
            if uses_pid:
                self._write_pid(name, interfaces, state, errors, velocity_errors, period)
                continue
            for interface, index in zip(interfaces, commanded, strict=True):
                interface.value = values[index] if values else 0.0

    def _write_pid(
        self,
        name: str,
        interfaces: list[CommandInterface],
        state: TrajectoryPoint,
        errors: list[float],
        velocity_errors: list[float],
        period: float,
    ) -> None:
        for interface, index in zip(interfaces, self._commanded, strict=True):
            pid = self._pids[index]
            velocity_error = velocity_errors[index] if velocity_errors else 0.0
            output = pid.update(errors[index], velocity_error, period)
            if state.velocities:
                output += pid.gains.ff_velocity_scale * state.velocities[index]
            if name == EFFORT and state.effort:
                output += state.effort[index]
            interface.value = output

    def _publish(
        self,
        time_ns: int,
        desired: TrajectoryPoint,
        positions: list[float],
        velocities: list[float],
        errors: list[float],
        velocity_errors: list[float],
    ) -> None:
        start_ns = self._trajectory.start_ns
        self._state_publisher.try_publish(
            time_ns,
            replace(desired, time_ns=self._trajectory_ns - start_ns),
            TrajectoryPoint(
                positions,
                velocities,
                self._acceleration_states.read(),
                time_ns=time_ns - start_ns,
            ),
            TrajectoryPoint(errors, velocity_errors),
            {name: [o.value for o in outputs] for name, outputs in self._outputs.items()},
            self._scaling,
        )

    @property
    def speed_scaling(self) -> float:
        """Factor on the speed of the trajectory; 0 pauses it."""
        return self._scaling

    @speed_scaling.setter
    def speed_scaling(self, factor: float) -> None:
        if math.isfinite(factor) and factor >= 0.0:
            self._scaling = factor

    def state_at(self, time_ns: int) -> TrajectoryPoint | None:
        """Where the trajectory will be at a time; None without one, or outside it."""
        trajectory = self._trajectory
        if not self._inputs.active or not trajectory.sampled_already:
            return None
        if not trajectory.start_ns <= time_ns < trajectory.end_ns:
            return None
        sample = trajectory.sample(time_ns, self._settings.method, advance=False)
        return None if sample is None else sample.state

    def _read_changed_parameters(self) -> None:
        self._stale_parameters = False
        parameter = self.auto_declare
        self._tolerances = read_tolerances(self._settings.joints, parameter)
        for pid, joint in zip(self._pids, self._settings.joints, strict=True):
            pid.gains = read_gains(joint, parameter)
