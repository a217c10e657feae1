"""An arm of the running robot: plans and executes motions for a program."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from teleopctl.commander.commands import RunningMotion
from teleopctl.commander.controllers import Controllers, choose_controllers, listed
from teleopctl.commander.gripper import GripperCommander, gripper_positions, opening_part
from teleopctl.commander.planning import (
    EXECUTE_TRAJECTORY,
    MOVE_ACTION,
    MoveGroupPlanner,
    PlannedMotion,
    plan_here,
)
from teleopctl.commander.running_robot import lookup_frame, receive_robot
from teleopctl.commander.targets import (
    MotionGoal,
    MotionTarget,
    Numbers,
    frame_transform,
    target_of,
)
from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError
from teleopctl.interfaces import get_action, get_message
from teleopctl.kinematics import rotation_vector
from teleopctl.node import (
    ActionClient,
    Node,
    StopHolders,
    open_node,
    qos_profile_sensor_data,
)

if TYPE_CHECKING:
    from teleopctl.kinematics import Arm

# Polling period of the goals, timeout for an action's server, and time after which a gone
# controller is noticed, s.
_PERIOD_S, _ANSWER_S, _LOOK_S = 0.05, 5.0, 1.0
# Longest wait of a motion that failed for the news that the robot is stopped, s.
_STOP_NEWS_S = 0.5
# Longest time, s, until the joints are at rest after a motion: change in a period, rad or m; and
# the time that a gripper without an action is waited for.
_REST_S, _RESTS, _GRIPPER_S = 0.5, 1e-4, 5.0
# Distance, rad or m, from the end of its trajectory at which a joint is held by something.
_SHORT_RAD, _SHORT_M = 0.05, 0.01

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True, slots=True)
class MotionResult:
    """Where a motion has ended, by the measured positions of the joints.

    Attributes:
        text: Result in one sentence.
        joints: Positions of the joints that were moved, rad or m, by name.
        time_s: Duration of the motion, s.
        position: Position of the tool in the root link's frame, m; None for a gripper.
        position_error_m: Its distance from the goal, m; None if the goal was no pose.
        rotation_error_rad: The same of the rotation, rad; None if any was allowed.
        largest_joint_error: Largest distance of a joint from the goal, rad or m; None for a pose.

    Example:
        >>> with RunningArm() as arm:  # of ``teleopctl launch sim.yaml``
        ...     home = arm.move(named="home")
        >>> home.largest_joint_error < 0.01
        True
    """

    text: str
    joints: Mapping[str, float]
    time_s: float
    position: tuple[float, float, float] | None = None
    position_error_m: float | None = None
    rotation_error_rad: float | None = None
    largest_joint_error: float | None = None


class ExecutionError(TeleopctlError):
    """A motion did not come to its end: rejected, failed, stopped, or held by something.

    Args:
        message: Problem, in one sentence.
        result: Where the joints are.
        code: Error code of the controller or of move_group; 0 without one.

    Attributes:
        result: Where the joints are.
        code: Error code of the controller or of move_group; 0 without one.

    Example:
        >>> with RunningArm() as arm:  # of ``teleopctl launch sim.yaml``
        ...     try:
        ...         reached = arm.move(joints={"joint_1": 0.2}).joints
        ...     except ExecutionError as error:
        ...         reached = error.result.joints
        >>> round(reached["joint_1"], 2)
        0.2
    """

    def __init__(self, message: str, result: MotionResult, code: int = 0) -> None:
        super().__init__(message)
        self.result, self.code = result, code


class RunningArm:
    """An arm of the robot that runs, in simulation or not: plans and executes motions.

    Positions are those of the group's independent joints, rad or m; poses are those of the tool,
    in the root link's frame or in a frame that is given. Each motion blocks until the arm rests.
    Ctrl-C (KeyboardInterrupt) in one, and `stop` from another thread, stop the arm. Where a
    ``move_group`` runs, it plans and executes, with its scene; else this process does, by the
    active trajectory controllers.

    Args:
        group: Name of the group; by default the first that moves a tip.
        tool: Link that poses are about, or the tool's pose in the frame of the group's tip, as of
            `Arm`.
        srdf: SRDF file; by default ``/robot_description_semantic``, or what the description
            suggests.
        namespace: Namespace of the robot; that of the node if one is given.
        direct: Whether to plan in this process even if a move_group runs.
        node: Node to use, which something else spins; by default one of its own.

    Attributes:
        arm: The arm's kinematics at the measured positions.
        warnings: Repairs and faults of the description, one sentence each.

    Raises:
        NotFoundError: No robot runs, or several; or there is no such group or tool.
        UnavailableError: The robot's topics are silent.

    Example:
        >>> with RunningArm() as arm:  # of ``teleopctl launch sim.yaml``
        ...     reached = arm.move(to=[0.3, 0.9, 1.4])
        ...     lower = arm.move(to=[0, 0, -0.05], frame="claw_support", linear=True, speed=0.5)
        ...     home = arm.move(named="home")
        ...     open_ = arm.gripper("open")
        >>> reached.position_error_m < 0.001
        True
    """

    def __init__(
        self,
        group: str = "",
        tool: str | Sequence[float] | npt.NDArray[np.float64] | None = None,
        *,
        srdf: str | Path | None = None,
        namespace: str = "",
        direct: bool = False,
        node: Node | None = None,
    ) -> None:
        self._exit = contextlib.ExitStack()
        if node is None:
            node = self._exit.enter_context(open_node("arm_commander", namespace=namespace))
        else:
            namespace = node.get_namespace()
        self._node = node
        try:
            robot = receive_robot(node, namespace, srdf, needs_state=True)
            found, warnings = robot.arm(group, tool)
        except BaseException:
            self._exit.close()
            raise
        self.arm: Arm = found
        self.warnings = tuple(warnings)
        self._measured: dict[str, float] = dict(robot.positions or {})
        states = node.create_subscription(
            get_message("sensor_msgs/msg/JointState"),
            f"{'/' + namespace.strip('/') if namespace.strip('/') else ''}/joint_states",
            self._take_state,
            qos_profile_sensor_data,
            immediate=True,
        )
        self._exit.callback(node.destroy_subscription, states)
        self._is_held = threading.Event()
        self._stops = StopHolders(node, self._hold)
        self._exit.callback(self._stops.close)
        self._controllers = Controllers(node)
        self._grippers = GripperCommander(node, self._controllers, found.model.joints)
        self._planner: MoveGroupPlanner | None = None
        above = node.get_namespace().rstrip("/")
        if not direct and node.graph().action_servers(f"{above}/{MOVE_ACTION}"):
            self._planner = MoveGroupPlanner(node)
        self._running: RunningMotion | None = None
        self._stop_count = 0
        self._lock = threading.Lock()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Destroy the endpoints, and the node if it is its own; a running motion continues."""
        self._exit.close()

    # --- state ------------------------------------------------------------------------------------

    @property
    def positions(self) -> dict[str, float]:
        """Measured positions of the group's independent joints, rad or m, by name."""
        measured = self._measured
        return {name: measured[name] for name in self.arm.names}

    def pose(self, frame: str | None = None) -> npt.NDArray[np.float64]:
        """Return the measured pose of the tool, (4, 4).

        Args:
            frame: Link, or frame of ``/tf``, in which it is; None for the root link.

        Raises:
            NotFoundError: There is no such frame.
        """
        self._measure()
        T_root_tool = self.arm.kinematics.pose()
        _, T_frame_root = frame_transform(self.arm, frame, self._lookup)
        return np.asarray(T_frame_root @ T_root_tool)

    # --- the arm ----------------------------------------------------------------------------------

    def plan(
        self,
        *,
        to: Numbers | None = None,
        rpy: Numbers | None = None,
        quat: Numbers | None = None,
        frame: str | None = None,
        linear: bool = False,
        joints: Mapping[str, float] | Numbers | None = None,
        named: str | None = None,
        speed: float = 1.0,
        acceleration: float = 1.0,
        planner: str = "",
        timeout_s: float = 5.0,
    ) -> PlannedMotion:
        """Return a planned motion from the present positions; `execute` executes it.

        Args:
            to: Position of the tool, (3,), m, or its pose, (4, 4).
            rpy: Rotation of the tool: roll, pitch, yaw, rad. Without one any is allowed, with
                ``linear`` the present one is kept.
            quat: Rotation of the tool as a quaternion x, y, z, w.
            frame: Link, or frame of ``/tf``, in which the pose is; None for the root link.
            linear: Whether the tool moves on a straight line.
            joints: Positions of joints, rad or m, in the group's order or by name.
            named: Name of a state of the group.
            speed: Part of the velocity limits, above 0 to 1.
            acceleration: Part of the acceleration limits, above 0 to 1.
            planner: Planner by OMPL's names, such as ``RRTstar``; empty for RRTConnect.
            timeout_s: Longest time to plan, s.

        Raises:
            NotFoundError: There is no such frame, joint or state.
            PlanningError: There is no such motion, or none was found in time.
            UnavailableError: move_group does not answer.
            UsageError: There is no goal, or several, or a value that is none.
        """
        goal = MotionGoal(
            to=to,
            rpy=rpy,
            quat=quat,
            frame=frame,
            linear=linear,
            joints=joints,
            named=named,
            speed=speed,
            acceleration=acceleration,
            planner=planner,
            timeout_s=timeout_s,
        )
        stop_count = self._stop_count
        self._measure()
        target = target_of(goal, self.arm, self._lookup)
        plan = plan_here if self._planner is None else self._planner.plan
        return plan(self.arm, goal, target, lambda: self._stop_count != stop_count)

    def execute(
        self, motion: PlannedMotion, on_progress: Callable[[float], object] | None = None
    ) -> MotionResult:
        """Execute a motion that `plan` returned, and wait for its end.

        Args:
            motion: The motion, which begins where the arm is.
            on_progress: Called with the part of the way that is done, 0 to 1, while it moves.

        Raises:
            ExecutionError: It did not reach its end; the error has the arm's positions.
            KeyboardInterrupt: Ctrl-C; the arm has been stopped.
            NotFoundError: No active controller moves a joint.
            UnavailableError: move_group does not answer.
        """
        return self._execute(motion, on_progress, self._stop_count)

    def _execute(
        self,
        motion: PlannedMotion,
        on_progress: Callable[[float], object] | None,
        stop_count: int,
    ) -> MotionResult:
        if motion.duration_s <= 0.0:
            # Controllers reject a trajectory that takes no time.
            return self._arrived(motion.target, {}, 0.0)
        trajectory = motion.trajectory
        end = dict(
            zip(trajectory.joint_names, map(float, trajectory.points[-1].positions), strict=True)
        )
        begin_s = time.monotonic()
        running = self._send(motion)
        self._follow(running, end, on_progress, begin_s, stop_count)
        return self._arrived(motion.target, end, time.monotonic() - begin_s)

    def move(
        self,
        *,
        to: Numbers | None = None,
        rpy: Numbers | None = None,
        quat: Numbers | None = None,
        frame: str | None = None,
        linear: bool = False,
        joints: Mapping[str, float] | Numbers | None = None,
        named: str | None = None,
        speed: float = 1.0,
        acceleration: float = 1.0,
        planner: str = "",
        timeout_s: float = 5.0,
    ) -> MotionResult:
        """Plan a motion from the present positions, and execute it; see `plan` and `execute`."""
        stop_count = self._stop_count
        planned = self.plan(
            to=to,
            rpy=rpy,
            quat=quat,
            frame=frame,
            linear=linear,
            joints=joints,
            named=named,
            speed=speed,
            acceleration=acceleration,
            planner=planner,
            timeout_s=timeout_s,
        )
        return self._execute(planned, None, stop_count)

    def gripper(self, opening: str | float) -> MotionResult:
        """Move the gripper, and wait for its end; fingers that hold something end earlier.

        Args:
            opening: ``open``, ``close``, or a number from 0 (closed) to 1 (open).

        Raises:
            ExecutionError: The motion did not reach its end.
            KeyboardInterrupt: Ctrl-C; the gripper has been stopped.
            NotFoundError: The arm has no gripper, or no active controller moves it.
            UsageError: The opening is none of these.
        """
        positions = gripper_positions(
            self.arm.model, self.arm.groups, self.arm.group.name, opening_part(opening)
        )
        begin_s, stop_count = time.monotonic(), self._stop_count
        start, available = dict(self._measured), self._controllers.available()
        running = self._grippers.move(positions, start, available)
        self._follow(running, positions, None, begin_s, stop_count)
        if not running.goals:
            self._wait_for_begin(start, positions)
        self._wait_for_rest(_REST_S if running.goals else _GRIPPER_S)
        at = {name: self._measured.get(name, math.nan) for name in positions}
        where = ", ".join(f"'{name}' is at {value:.4g}" for name, value in at.items())
        return MotionResult(f"Gripper: {where}", at, time.monotonic() - begin_s)

    def stop(self) -> None:
        """Stop a plan or motion of another thread, which raises an error there."""
        with self._lock:
            self._stop_count += 1
            running = self._running
        if running is not None:
            running.cancel()

    # --- execution --------------------------------------------------------------------------------

    def _send(self, motion: PlannedMotion) -> RunningMotion:
        running = RunningMotion()
        if self._planner is not None and motion.robot_trajectory is not None:
            kind: Any = get_action("moveit_msgs/action/ExecuteTrajectory")
            client = ActionClient(self._node, kind, EXECUTE_TRAJECTORY)
            if not client.wait_for_server(_ANSWER_S):
                raise UnavailableError(f"move_group does not offer the action {client.action_name}")
            running.add(client, kind.Goal(trajectory=motion.robot_trajectory), "move_group")
            return running
        available = self._controllers.available()
        names = list(motion.trajectory.joint_names)
        chosen, left = choose_controllers(names, available)
        if left:
            raise NotFoundError(
                f"No active controller takes trajectories of {', '.join(left)}",
                hint=f"Active: {listed(available)}. `teleopctl control list_controllers` lists "
                "all, `teleopctl control doctor` says what keeps them from activation.",
            )
        for one in chosen:
            client = self._controllers.client(one)
            if not client.wait_for_server(_ANSWER_S):
                raise UnavailableError(f"{one.name} does not offer the action {client.action_name}")
        return RunningMotion.of(self._controllers, chosen, motion.trajectory, dict(self._measured))

    def _follow(
        self,
        running: RunningMotion,
        end: Mapping[str, float],
        on_progress: Callable[[float], object] | None,
        begin_s: float,
        stop_count: int,
    ) -> None:
        """Wait for the end of a motion.

        Args:
            running: The motion.
            end: Positions at its end, by joint.
            on_progress: Called with the part of the way that is done.
            begin_s: Time of its begin, s.
            stop_count: Number of stops before it was planned: with more it is stopped.

        Raises:
            ExecutionError: The motion failed, or was stopped.
            KeyboardInterrupt: Ctrl-C; the joints have been stopped.
        """
        start = dict(self._measured)
        way = max((abs(at - start.get(name, at)) for name, at in end.items()), default=0.0)
        with self._lock:
            self._running = running
            is_late = self._stop_count != stop_count
        if is_late:
            running.cancel()
        look_s = time.monotonic() + _LOOK_S
        try:
            while not running.ended and running.failed is None:
                running.wait(_PERIOD_S)
                if on_progress is not None and way > 0.0:
                    left = max(abs(at - self._measured.get(name, at)) for name, at in end.items())
                    on_progress(max(0.0, 1.0 - left / way))
                if time.monotonic() >= look_s:
                    look_s += _LOOK_S
                    for goal in running.goals:
                        goal.check_server()
        except BaseException as error:
            if late := running.cancel():
                error.add_note(f"{', '.join(late)} did not confirm the stop")
            raise
        finally:
            with self._lock:
                self._running = None
        failed = running.failed
        if failed is not None:
            running.cancel()
            text = failed.problem
        elif any(goal.canceled for goal in running.goals):
            who = next(goal.who for goal in running.goals if goal.canceled)
            text = (
                "The motion was stopped"
                if self._stop_count != stop_count
                else f"{who} ended the motion: it was canceled by another command"
            )
        else:
            return
        # A robot that was stopped before this node came rejects a goal sooner than it says why.
        self._is_held.wait(_STOP_NEWS_S)
        if holders := self._stops.names:
            text += (
                f"; the robot is stopped by {', '.join(holders)} (teleopctl stop --robot --release)"
            )
        at = {name: self._measured[name] for name in end if name in self._measured}
        result = MotionResult(text, at, time.monotonic() - begin_s)
        raise ExecutionError(text, result, failed.code if failed is not None else 0)

    def _hold(self, names: tuple[str, ...]) -> None:
        (self._is_held.set if names else self._is_held.clear)()

    def _arrived(
        self, target: MotionTarget, end: Mapping[str, float], spent_s: float
    ) -> MotionResult:
        """Return the result of a motion that the controllers report as done.

        Args:
            target: The goal.
            end: Positions at the end of the trajectory, by joint.
            spent_s: Time that the motion took, s.

        Raises:
            ExecutionError: A joint is not where the trajectory ended.
        """
        arm = self.arm
        self._wait_for_rest(_REST_S)
        arm.model.set_positions(self._measured)
        measured, pose = arm.kinematics.present(), arm.kinematics.pose()
        x, y, z = (float(value) + 0.0 for value in pose[:3, 3])
        text = f"'{arm.tool_name}' is at [{x:.3f}, {y:.3f}, {z:.3f}] after {spent_s:.1f} s"
        away_m = turned_rad = off = None
        if target.pose is not None:
            away_m = float(np.linalg.norm(target.pose[:3, 3] - pose[:3, 3]))
            text += f", {1e3 * away_m:.1f} mm from the goal"
            if not target.is_position:
                turn = rotation_vector(target.pose[:3, :3] @ pose[:3, :3].T)
                turned_rad = float(np.linalg.norm(turn))
                text += f" and {math.degrees(turned_rad):.1f} degrees"
        elif target.positions is not None:
            joints = zip(arm.kinematics.limits, measured, target.positions, strict=True)
            errors = np.abs([limits.offset(at, goal) for limits, at, goal in joints])
            off = float(errors.max())
            name = arm.names[int(errors.argmax())]
            text += f"; '{name}' is farthest from its goal, by {off:.4f}"
        short = self._short_of(end)
        if short:
            text = f"{short}: {text}"
        by_name = arm.kinematics.by_name(measured)
        result = MotionResult(text, by_name, spent_s, (x, y, z), away_m, turned_rad, off)
        if short:
            raise ExecutionError(text, result)
        return result

    def _short_of(self, end: Mapping[str, float]) -> str:
        """Return which joint is not at the motion's end; controllers may have no tolerances."""
        for name, at in end.items():
            joint = self.arm.model.joints[name]
            off = joint.limits.offset(self._measured.get(name, at), at)
            is_linear = joint.joint.type == "prismatic"
            if abs(off) > (_SHORT_M if is_linear else _SHORT_RAD):
                return (
                    f"Joint '{name}' stays {abs(off):.3g} {'m' if is_linear else 'rad'} from the "
                    "end of its trajectory; something holds it"
                )
        return ""

    def _wait_for_rest(self, longest_s: float) -> None:
        """Wait until the measured positions stay constant, or until a timeout."""
        end_s, before = time.monotonic() + longest_s, dict[str, float]()
        while time.monotonic() < end_s:
            measured = self._measured
            if before and all(abs(at - before.get(n, at)) < _RESTS for n, at in measured.items()):
                return
            before = measured
            time.sleep(_PERIOD_S)

    def _wait_for_begin(self, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        """Wait until joints that are not at their goal begin to move, or until a timeout."""
        end_s = time.monotonic() + _REST_S
        while time.monotonic() < end_s:
            measured = self._measured
            for name, at in end.items():
                begun = start.get(name, at)
                if abs(at - begun) < _RESTS or abs(measured.get(name, begun) - begun) > _RESTS:
                    return
            time.sleep(_PERIOD_S)

    def _measure(self) -> None:
        """Set the model to the measured positions."""
        self.arm.model.set_positions(self._measured)
        self.arm.positions = self.arm.kinematics.clamp(self.arm.kinematics.present())

    def _lookup(self, frame: str, root: str) -> npt.NDArray[np.float64] | None:
        return lookup_frame(self._node, frame, root)

    def _take_state(self, message: Any) -> None:
        found = dict(zip(message.name, map(float, message.position), strict=False))
        self._measured = {**self._measured, **found}
