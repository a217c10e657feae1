"""Joint trajectory controller."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from teleopctl.control.controllers.base import (
    ControllerInterface,
    ControllerInterfaceParams,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.joint_trajectory.action import FollowJointTrajectoryServer
from teleopctl.control.controllers.joint_trajectory.blending import blend
from teleopctl.control.controllers.joint_trajectory.goal import (
    GOAL_TOLERANCE_VIOLATED,
    INVALID_GOAL,
    PATH_TOLERANCE_VIOLATED,
    SUCCESSFUL,
    FollowedGoal,
)
from teleopctl.control.controllers.joint_trajectory.inputs import (
    ReceivedTrajectory,
    TrajectoryInputs,
)
from teleopctl.control.controllers.joint_trajectory.outputs import CommandOutputs
from teleopctl.control.controllers.joint_trajectory.settings import (
    InvalidSettingsError,
    read_gains,
    read_settings,
    read_tolerances,
)
from teleopctl.control.controllers.joint_trajectory.state import TrajectoryStatePublisher
from teleopctl.control.controllers.joint_trajectory.stopping import (
    stopping_points,
    stopping_trajectory,
)
from teleopctl.control.controllers.joint_trajectory.tolerances import (
    ToleranceVerdict,
    check_tolerances,
    tracking_error,
)
from teleopctl.control.controllers.joint_trajectory.trajectory import (
    Trajectory,
    TrajectoryPoint,
    TrajectorySample,
)
from teleopctl.control.controllers.joint_trajectory.validation import find_jump
from teleopctl.control.controllers.pid import Pid, PidGains
from teleopctl.control.handles import (
    ACCELERATION,
    POSITION,
    VELOCITY,
    CommandInterface,
    MeasuredValues,
    StateInterface,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND


class JointTrajectoryController(ControllerInterface):
    """Controller that moves joints along trajectories received by action or topic.

    Plug-in type ``joint_trajectory_controller/JointTrajectoryController``.

    Commands lead by one period: each command is the trajectory's state at the time of the next
    command. Trajectories are received by the action ``~/follow_joint_trajectory`` and the topics
    ``~/joint_trajectory`` and ``~/commands``. A trajectory from a topic replaces the present one
    without ending its goal, which is then judged by the new trajectory.
    """

    def __init__(self, params: ControllerInterfaceParams) -> None:
        super().__init__(params)
        self._incoming: deque[ReceivedTrajectory] = deque(maxlen=1)
        self._trajectory = Trajectory()
        self._holding = self._from_command = False
        self._goal: FollowedGoal | None = None
        self._trajectory_ns = 0
        self._commanded_ns = 0
        self._stopping_from: TrajectoryPoint | None = None
        self._stale_parameters = False
        self._reported_jump = False

    def on_init(self) -> None:
        """Declare the parameters of joints and interfaces; re-read parameters after changes."""
        for name in ("joints", "command_joints", "command_interfaces", "state_interfaces"):
            self.auto_declare(name, [], read_only=True)
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    def _parameters_changed(self, parameters: object) -> None:
        del parameters
        self._stale_parameters = True

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create subscriptions, services, publisher and action server."""
        try:
            self._settings = settings = read_settings(self.auto_declare)
            self._pids = [Pid(self._gains(joint)) for joint in settings.joints]
        except InvalidSettingsError as error:
            self.logger.error(str(error))
            return CallbackReturn.FAILURE
        if self.auto_declare("open_loop_control", False):
            self.logger.warning(
                "[Deprecated] 'open_loop_control' parameter is deprecated. Instead, set the "
                "feedback gains to zero and use 'interpolate_from_desired_state' parameter"
            )
        self._report_upsampling()
        if not settings.decelerations and self.auto_declare(
            "constraints.decelerate_on_cancel", False
        ):
            self.logger.warning(
                "'constraints.decelerate_on_cancel' has no effect: it needs velocity as a state "
                "interface and a max_deceleration_on_cancel above 0 for every joint. A trajectory "
                "that is cancelled ends on the spot."
            )
        self._tolerances = read_tolerances(settings.joints, self.auto_declare)
        self._scaling = self._requested_scaling = settings.initial_scaling
        self._stale_parameters = False
        self._wrap = [joint in self.params.continuous_joints for joint in settings.joints]
        self._inputs = TrajectoryInputs(self, settings, self._incoming)
        self._action = FollowJointTrajectoryServer(
            self, settings, self._inputs, lambda: self._tolerances
        )
        self._state_publisher = TrajectoryStatePublisher(
            self.get_node(), self.params.publish_queue, settings
        )
        # Logging is output, which the control cycle must not do.
        self._log = realtime_log(self.params.publish_queue)
        self.logger.info(
            f"Command interfaces are [{' '.join(settings.command_interfaces)}] and "
            f"state interfaces are [{' '.join(settings.state_interfaces)}]."
        )
        return None

    def _report_upsampling(self) -> None:
        """Log whether trajectories of positions get velocities."""
        frequency = self.auto_declare("positions_upsampling.policy_frequency", 0.0)
        if not self.auto_declare("positions_upsampling.enable", False):
            return
        self.logger.info(f"Positions upsampling enabled (policy_frequency={frequency:.2f} Hz).")
        if not self._settings.upsampling:
            self.logger.warning(
                "positions_upsampling has no effect when interpolation_method is 'none'."
            )
        if frequency == 0.0:
            self.logger.warning(
                "positions_upsampling.policy_frequency is 0: chunks without their own timing will "
                "be rejected."
            )

    def on_cleanup(self) -> None:
        """Destroy the subscriptions, query service, state publisher and action server."""
        self._action.close()
        self._inputs.close()
        self._state_publisher.close()

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces, joint by joint, then that of speed scaling if any."""
        settings = self._settings
        names = [
            f"{j}/{name}" for j in settings.command_joints for name in settings.command_interfaces
        ]
        if settings.scaling_command_interface:
            names.append(settings.scaling_command_interface)
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces, joint by joint, then the speed scaling interface if any."""
        settings = self._settings
        names = [f"{j}/{name}" for j in settings.joints for name in settings.state_interfaces]
        if settings.scaling_state_interface:
            names.append(settings.scaling_state_interface)
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def on_activate(self) -> None:
        """Accept trajectories; hold the last commanded positions, or else the measured ones."""
        self._sort_interfaces()
        for pid in self._pids:
            pid.reset()
        held = self._position_states.read()
        last = self._outputs.positions()
        if self._settings.hold_last_command and last is not None:
            held = last
        self._incoming.clear()
        self._goal = None
        self._stopping_from = None
        self._reported_jump = False
        # A trajectory received before the first update starts from the commanded state, too.
        self._has_command = held is last
        self._commanded_state = TrajectoryPoint(held)
        # A paused simulation may not have published joint states yet: hold the first ones.
        self._awaits_state = not all(map(math.isfinite, held))
        self._hold(held)
        self._inputs.active = True

    def _sort_interfaces(self) -> None:
        """Sort the joints' interfaces by quantity into the lists that ``update`` reads."""
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
        self._scaling_command = None
        commands = self.command_interfaces
        if settings.scaling_command_interface:
            *commands, self._scaling_command = commands
        self._outputs = CommandOutputs(settings, commands, self._pids)

    # State that new code takes over: attributes, and what `export_state` adds.
    _KEPT = (
        "_trajectory",
        "_holding",
        "_from_command",
        "_goal",
        "_trajectory_ns",
        "_commanded_ns",
        "_commanded_state",
        "_has_command",
        "_awaits_state",
        "_scaling",
        "_requested_scaling",
        "_stopping_from",
    )

    def export_state(self) -> object:
        """Return the trajectory with the time on it, its goal, and the state of the PIDs."""
        return {
            "joints": self._settings.joints,
            "attributes": {name: getattr(self, name) for name in self._KEPT},
            "incoming": list(self._incoming),
            "pids": [pid.export_state() for pid in self._pids],
        }

    # Any: attributes of any type.
    def import_state(self, state: dict[str, Any]) -> None:
        """Continue with the trajectory and the goal of the replaced instance.

        Raises:
            ValueError: The joints are others.
        """
        if state["joints"] != self._settings.joints:
            raise ValueError(f"the joints were {', '.join(state['joints'])}")
        vars(self).update(state["attributes"])
        if not self.params.robot_stop.is_stopped:
            # The old instance stopped as a joint was not measured; that is found again.
            self._stopping_from = None
        self._incoming.extend(state["incoming"])
        for pid, of_pid in zip(self._pids, state["pids"], strict=True):
            pid.import_state(of_pid)
        newest = self._incoming[-1].goal if self._incoming else None
        self._action.follow(newest or self._goal)

    def on_restart(self) -> None:
        """Hold the present positions and abort the goal: the joints have jumped or stood still."""
        reason = "The simulation was reset"
        if self.params.robot_stop.standstill:
            # One may have been received before commands were refused.
            reason = self.params.robot_stop.reason
            self._discard_waiting(reason)
        for pid in self._pids:
            pid.reset()
        self._has_command = False
        positions = self._position_states.read()
        self._awaits_state = not all(map(math.isfinite, positions))
        self._hold(positions)
        self._stopping_from = None
        self._abort_goal(INVALID_GOAL, reason)

    def abort_goals(self, reason: str) -> None:
        """Abort the goal, while no control cycle runs."""
        self._action.abort_goal(reason)

    def on_stop(self) -> None:
        """Abort the goals, and decelerate all joints within their limits, on their path."""
        self._stop_for(f"The robot is stopped by {self.params.robot_stop.by}")

    def _stop_for(self, reason: str) -> None:
        """Abort the goals for a reason, and decelerate until `_stopping_from` is None."""
        self._discard_waiting(reason)
        self._abort_goal(INVALID_GOAL, reason)
        if self._awaits_state:
            return
        joints, stop = self._settings.joints, self.params.robot_stop
        unknown = TrajectoryPoint([math.nan] * len(joints))
        commanded = self._commanded_state if self._has_command else unknown
        measured = TrajectoryPoint(self._position_states.read(), self._velocity_states.read())
        if self._position_states.lost and self._has_command:
            # What was measured last is old.
            measured = unknown
        self._trajectory, self._stopping_from = stopping_trajectory(
            stop, joints, commanded, measured, self._scaling, self._trajectory, self.nominal_period
        )
        self._holding = True

    def on_release(self) -> None:
        """Hold the positions at which the robot has stopped."""
        # A goal may have been accepted at the instant of the stop.
        self._discard_waiting("The robot was stopped")
        self._stopping_from = None

    def _discard_waiting(self, reason: str) -> None:
        while self._incoming:
            if (waiting := self._incoming.pop().goal) is not None:
                waiting.try_abort(error_code=INVALID_GOAL, error_string=reason)

    def interfaces_to_decelerate(self) -> Sequence[CommandInterface]:
        """Return none: the controller decelerates the joints by a trajectory."""
        return ()

    def on_deactivate(self) -> None:
        """Abort the goal, and command zero on all command interfaces except positions."""
        self._inputs.active = False
        self._action.abort_goal("Current goal cancelled during deactivate transition.")
        self._goal = None
        self._outputs.zero_commands()

    def _hold(self, positions: list[float]) -> None:
        self._stop(positions, [])

    def _stop(self, positions: list[float], velocities: list[float]) -> None:
        """Replace the trajectory: hold a position, after slowing down if decelerations are set."""
        self._trajectory = Trajectory(
            stopping_points(positions, velocities, self._settings.decelerations)
        )
        self._holding = True

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Command the trajectory's state one period ahead, check tolerances, end a goal if due."""
        if self._stale_parameters:
            self._read_changed_parameters()
        positions = self._position_states.read()
        velocities = self._velocity_states.read()
        if self._position_states.watch(period) or self._position_states.lost:
            self._follow_measurement()
        if self._awaits_state:
            if not all(map(math.isfinite, positions)):
                return None
            self._awaits_state = False
            self._hold(positions)
        if self._scaling_command is not None:
            self._scaling_command.value = self._requested_scaling
        if self._scaling_state is not None and math.isfinite(self._scaling_state.value):
            self._scaling = max(0.0, self._scaling_state.value)
        stopping = self._stopping_from is not None
        if self._incoming and not stopping:
            self._replace_trajectory(self._incoming.pop(), time_ns)
        if self._goal is not None and self._goal.cancel_requested:
            self._stop(positions, velocities)
            self._goal.try_cancel()
            self._goal = None
        trajectory, method = self._trajectory, self._settings.method
        scaling = 1.0 if stopping else self._scaling
        first = not trajectory.sampled_already
        if first:
            self._start(trajectory, time_ns, positions, velocities)
        else:
            self._trajectory_ns += round(period * scaling * NANOSECONDS_PER_SECOND)
        now = self._trajectory_ns
        desired = trajectory.sample(now, method)
        if first and not (self._holding or self._reported_jump or stopping):
            self._report_jump(trajectory, now)
        ahead = now + round(NANOSECONDS_PER_SECOND * scaling / self.update_rate)
        # A smaller scaling shortens the lead; the command must not go back in time.
        self._commanded_ns = ahead = ahead if first else max(ahead, self._commanded_ns)
        command = trajectory.sample(ahead, method, advance=False)
        if desired is None or command is None:
            return None
        is_shown = self._state_publisher.has_subscribers
        if self._holding and self._goal is None and not (is_shown or self._settings.uses_pid):
            # While holding, only the state topic and the PID use the error.
            self._outputs.write(command.state, desired.state.effort, (), (), period)
            self._commanded_state, self._has_command = command.state, True
            return None
        accelerations = self._acceleration_states.read()
        reference = desired.state.at(now - trajectory.start_ns)
        feedback = TrajectoryPoint(
            positions, velocities, accelerations, time_ns=time_ns - trajectory.start_ns
        )
        error = tracking_error(reference, feedback, self._wrap)
        if self._position_states.lost:
            # An error that stays would drive the joints, through the PIDs.
            error = TrajectoryPoint([0.0] * len(positions), [0.0] * len(positions))
        verdict, blame = self._check_error(desired, error, first=first)
        if verdict in (
            ToleranceVerdict.PATH_VIOLATED,
            ToleranceVerdict.GOAL_LATE,
            ToleranceVerdict.TIMED_OUT,
        ):
            self._stop(positions, velocities)
        else:
            self._outputs.write(
                command.state, desired.state.effort, error.positions, error.velocities, period
            )
            self._commanded_state, self._has_command = command.state, True
        if self._goal is not None:
            self._goal.try_feedback(time_ns, reference, feedback, error)
        self._end_goal(verdict, blame)
        if is_shown:
            self._state_publisher.try_publish(
                time_ns, reference, feedback, error, self._outputs.values(), self._scaling
            )
        return None

    def _follow_measurement(self) -> None:
        """Stop while a joint is not measured; hold from when all are measured again."""
        log, lost = self._log.try_publish, self._position_states.lost
        stops = self._stopping_from is not None or self._awaits_state
        if not lost:
            if not self._awaits_state:
                log((self.logger.info, "All positions are measured again"))
            if not self.params.robot_stop.is_stopped:
                self._stopping_from = None
        elif self._incoming and stops:
            log((self.logger.error, f"The trajectory is refused: {lost}"))
            self._discard_waiting(lost)
        elif not stops:
            log((self.logger.error, f"{lost}: the joints decelerate and hold"))
            self._stop_for(lost)

    def _replace_trajectory(self, incoming: ReceivedTrajectory, time_ns: int) -> None:
        """Replace the trajectory; joints that the new one lacks hold their commanded positions.

        With the parameter ``allow_trajectory_replacement`` they continue on a running trajectory.
        """
        current = self._outputs.positions() or self._position_states.read()
        points, start_ns = incoming.points(current), incoming.start_ns
        if (blended := self._blend(points, incoming, time_ns)) is not None:
            points, start_ns = blended, 0
        self._trajectory = Trajectory(points, start_ns)
        self._from_command = incoming.from_command or self._settings.open_loop
        self._holding = False
        if incoming.goal is not None:
            self._goal = incoming.goal

    def _blend(
        self, points: list[TrajectoryPoint], incoming: ReceivedTrajectory, time_ns: int
    ) -> list[TrajectoryPoint] | None:
        """Return points that continue the running trajectory; None if there is none to continue."""
        running = self._trajectory
        if (
            not self._settings.replacement
            or not incoming.commanded
            or self._holding
            or not running.sampled_already
            or len(running.points) < 2
        ):
            return None
        wait_ns = max(0, incoming.start_ns - time_ns) if incoming.start_ns else 0
        return blend(
            running,
            points,
            incoming.commanded,
            self._trajectory_ns,
            self._trajectory_ns + round(wait_ns * self._scaling),
            self._settings.method,
        )

    def _start(
        self, trajectory: Trajectory, time_ns: int, positions: list[float], velocities: list[float]
    ) -> None:
        """Set the trajectory's point before: the measured state, or the commanded one."""
        self._trajectory_ns = time_ns
        if self._stopping_from is not None:
            trajectory.set_point_before(time_ns, self._stopping_from, self._wrap)
            return
        if not self._holding and self._from_command and self._has_command:
            last = self._outputs.positions()
            before = (
                self._commanded_state
                if last is None
                else replace(self._commanded_state, positions=last)
            )
            # The last command was for this time: commands lead by one period.
            trajectory.set_point_before(time_ns, before, self._wrap)
            return
        before = TrajectoryPoint(positions, velocities, self._acceleration_states.read())
        trajectory.set_point_before(time_ns, before, self._wrap)

    def _report_jump(self, trajectory: Trajectory, now_ns: int) -> None:
        """Log, once since the activation, that a trajectory starts elsewhere."""
        settings, limits = self._settings, self.params.joint_limits
        period = self.nominal_period
        if sentence := find_jump(trajectory, now_ns, period, settings.joints, limits):
            self._reported_jump = True
            topic = f"{self.get_node().get_namespace().rstrip('/')}/{self.name}/controller_state"
            where = f"'teleopctl topic echo --once {topic}' prints where the joints are."
            self._log.try_publish((self.logger.warning, f"{sentence} {where}"))

    def _check_error(
        self, desired: TrajectorySample, error: TrajectoryPoint, *, first: bool
    ) -> tuple[ToleranceVerdict, str]:
        if self._holding:
            return ToleranceVerdict.MOVING, ""
        trajectory, settings = self._trajectory, self._settings
        late = None
        if desired.end_index == len(trajectory.points):
            late = (self._trajectory_ns - trajectory.end_ns) / NANOSECONDS_PER_SECOND
        self._late = late or 0.0
        return check_tolerances(
            self._tolerances if self._goal is None else self._goal.tolerances,
            settings.joints,
            TrajectoryPoint(
                error.positions,
                error.velocities if settings.checks_velocity else [],
                error.accelerations if ACCELERATION in settings.command_interfaces else [],
            ),
            late,
            settings.cmd_timeout,
            first=first,
        )

    def _end_goal(self, verdict: ToleranceVerdict, blame: str) -> None:
        """End the goal according to the verdict, and log violations."""
        if verdict in (ToleranceVerdict.MOVING, ToleranceVerdict.WAITING):
            return
        log, goal = self._log.try_publish, self._goal
        failed = f"State tolerances failed for {blame}"
        if verdict is ToleranceVerdict.PATH_VIOLATED:
            reason = "Holding position due to state tolerance violation"
            if goal is not None:
                reason = "Aborted due to state tolerance violation"
            log((self.logger.error, failed, reason))
            self._abort_goal(
                PATH_TOLERANCE_VIOLATED, f"Aborted due to path tolerance violation: {blame}"
            )
        elif verdict is ToleranceVerdict.GOAL_LATE:
            reason = f"Aborted due to goal_time_tolerance exceeding by {self._late:f} seconds"
            said = "Exceeded goal_time_tolerance: holding position..." if goal is None else reason
            log((self.logger.error, failed, said))
            self._abort_goal(GOAL_TOLERANCE_VIOLATED, f"{reason}: {blame}")
        elif verdict is ToleranceVerdict.TIMED_OUT:
            reason = "Aborted due to command timeout"
            log((self.logger.warning, reason))
            if blame:
                self._abort_goal(GOAL_TOLERANCE_VIOLATED, f"{reason}: {blame}")
        if goal is not None and not blame:
            log((self.logger.info, "Goal reached, success!"))
            goal.try_succeed(error_code=SUCCESSFUL, error_string="Goal successfully reached!")
            self._goal = None
            # The last point stays commanded, with its velocity, and is not checked any more.
            self._holding = True

    def _abort_goal(self, error_code: int, error_string: str) -> None:
        if self._goal is not None:
            self._goal.try_abort(error_code=error_code, error_string=error_string)
            self._goal = None

    @property
    def speed_scaling(self) -> float:
        """Factor on the speed at which trajectories are followed; 0 pauses the motion."""
        return self._scaling

    @speed_scaling.setter
    def speed_scaling(self, factor: float) -> None:
        if not (math.isfinite(factor) and factor >= 0.0):
            return
        self._requested_scaling = factor
        # Otherwise the hardware reports the factor that it applies.
        if not self._settings.scaling_state_interface:
            self._scaling = factor

    def state_at(self, time_ns: int) -> TrajectoryPoint | None:
        """Return the desired state at a time; None outside the trajectory or if inactive."""
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
        try:
            for pid, joint in zip(self._pids, self._settings.joints, strict=True):
                pid.gains = self._gains(joint)
        except InvalidSettingsError as error:
            self.logger.error(f"Received invalid gains: {error}. Skipping new gains.")

    def _gains(self, joint: str) -> PidGains:
        """Return the PID gains of a joint, checked if PIDs are used."""
        gains = read_gains(joint, self.auto_declare)
        if self._settings.uses_pid and (problem := gains.problem()):
            raise InvalidSettingsError(f"Gains of '{joint}': {problem}")
        return gains
