"""Execution of ``teleopctl move``: by move_group, or by the active trajectory controllers."""

from __future__ import annotations

import contextlib
import math
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.kinematics.queries import tool_name
from teleopctl.cli.verbs.kinematics.source import RobotOptions, running_robot
from teleopctl.cli.verbs.move.planning import (
    EXECUTE_TRAJECTORY,
    MOVE_ACTION,
    Goal,
    MoveTarget,
    PlannedMotion,
    answer,
    plan_by_move_group,
    plan_here,
    target_of,
)
from teleopctl.errors import NotFoundError, UnavailableError, UsageError
from teleopctl.interfaces import from_seconds, get_action, get_message, set_stamp
from teleopctl.node import (
    ActionClient,
    GoalState,
    Node,
    SingleThreadedExecutor,
    StopHolders,
    qos_profile_sensor_data,
)

if TYPE_CHECKING:
    from teleopctl.kinematics import Arm, GripperRange
    from teleopctl.nodes.moveit.move_group.controllers import Controller

_INTERRUPTED = 130
# Time between two looks at the goals, and until a controller must have answered or stopped, s.
_PERIOD_S, _ANSWER_S, _STOP_S = 0.05, 5.0, 10.0
# Time in which a gone controller is noticed, s.
_LOOK_S = 1.0
# Longest time, s, until the joints are at rest after a motion: change in a period, rad or m.
_REST_S, _RESTS = 0.5, 1e-4
# Part of the velocity limit with which grippers move, their speed without one, shortest motion.
_GRIPPER_SPEED, _DEFAULT_SPEED, _SHORTEST_S = 0.5, 1.0, 0.2
_OPENINGS = {"open": 1.0, "close": 0.0, "closed": 0.0}

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True, slots=True)
class MotionOutcome:
    """End of a motion.

    Attributes:
        text: What happened, in words.
        status: Exit status.
        result: ``succeeded``, ``failed`` or ``stopped``.
        facts: Further facts for JSON.
    """

    text: str
    status: int
    result: str
    facts: Mapping[str, Any]

    @property
    def succeeded(self) -> bool:
        """Whether the goal was reached."""
        return self.status == 0

    def document(self) -> dict[str, Any]:
        """Return the end for JSON."""
        return {"result": self.result, "message": self.text, **self.facts}


class MotionRun:
    """The running robot, and motions of it.

    Args:
        node: Node of the clients, which is being spun.
        options: Options that choose group, tool and files.
        direct: Whether to plan here even if a move_group runs.
    """

    def __init__(self, node: Node, options: RobotOptions, *, direct: bool) -> None:
        self._node = node
        robot = running_robot(node, options, needs_state=True)
        self.arm: Arm = robot.arm(options)
        self._measured: dict[str, float] = dict(robot.positions or {})
        node.create_subscription(
            get_message("sensor_msgs/msg/JointState"),
            "joint_states",
            self._take_state,
            qos_profile_sensor_data,
            immediate=True,
        )
        self._stops = StopHolders(node, lambda _names: None)
        namespace = node.get_namespace().rstrip("/")
        has_move_group = bool(node.graph().action_servers(f"{namespace}/{MOVE_ACTION}"))
        self._by_move_group = has_move_group and not direct

    @classmethod
    @contextlib.contextmanager
    def of(cls, options: RobotOptions, *, direct: bool) -> Iterator[MotionRun]:
        """Yield a run with a node of its own."""
        namespace = options.namespace.strip("/")
        ros_args = ["-r", f"__ns:=/{namespace}"] if namespace else []
        with command_node(ros_args=ros_args) as node:
            executor = SingleThreadedExecutor(context=node.context)
            executor.add_node(node)
            thread = threading.Thread(target=executor.spin, daemon=True)
            thread.start()
            try:
                yield cls(node, options, direct=direct)
            finally:
                executor.shutdown()
                thread.join(_LOOK_S)

    def plan(self, goal: Goal) -> PlannedMotion:
        """Plan a motion of the arm from where it is.

        Raises:
            PlanningError: There is none.
        """
        target = target_of(goal, self.arm)
        if self._by_move_group:
            return plan_by_move_group(self._node, self.arm, goal, target)
        return plan_here(self.arm, goal, target)

    # --- the arm --------------------------------------------------------------------------------

    def execute(self, planned: PlannedMotion, *, shows_progress: bool) -> MotionOutcome:
        """Execute a motion, and wait for its end; Ctrl-C stops it.

        Args:
            planned: The motion.
            shows_progress: Whether to show it on a terminal.

        Raises:
            NotFoundError: No active controller moves a joint.
            UnavailableError: A controller does not answer.
        """
        if planned.duration_s <= 0.0:
            # Controllers reject a trajectory that takes no time.
            return self._arrived(planned.target, {}, 0.0)
        if self._by_move_group and planned.robot_trajectory is not None:
            kind: Any = get_action("moveit_msgs/action/ExecuteTrajectory")
            goal = kind.Goal(trajectory=planned.robot_trajectory)
            running = [
                _Running(ActionClient(self._node, kind, EXECUTE_TRAJECTORY), goal, "move_group")
            ]
        else:
            running = self._controllers_goals(planned.trajectory)
        names = list(planned.trajectory.joint_names)
        points = planned.trajectory.points
        end = dict(zip(names, map(float, points[-1].positions), strict=True)) if points else {}
        begin_s = time.monotonic()
        outcome = self._follow(running, end if shows_progress else {})
        spent_s = time.monotonic() - begin_s
        if outcome is not None:
            return outcome
        return self._arrived(planned.target, end, spent_s)

    def _controllers_goals(self, trajectory: Any) -> list[_Running]:
        from teleopctl.nodes.moveit.move_group.controllers import (
            Controllers,
            choose_controllers,
            goal_for,
        )

        controllers = Controllers(self._node)
        available = controllers.available()
        chosen, left = choose_controllers(list(trajectory.joint_names), available)
        if left:
            raise NotFoundError(
                f"No active controller takes trajectories of {', '.join(left)}",
                hint=f"Active: {_listed(available)}. `teleopctl control list_controllers` lists "
                "all, `teleopctl control doctor` says what keeps them from activation.",
            )
        measured = dict(self._measured)
        return [
            _Running(controllers.client(one), goal_for(one, trajectory, measured), one.name)
            for one in chosen
        ]

    def _follow(self, running: list[_Running], end: Mapping[str, float]) -> MotionOutcome | None:
        """Wait for the end of goals; return what went wrong, or None."""
        start = dict(self._measured)
        progress = _Progress(start, end)
        try:
            look_s = time.monotonic() + _LOOK_S
            while not all(each.is_ended for each in running):
                if any(each.problem for each in running):
                    break
                _Running.changed.wait(_PERIOD_S)
                _Running.changed.clear()
                progress.show(self._measured)
                if time.monotonic() >= look_s:
                    look_s += _LOOK_S
                    for each in running:
                        each.check_server()
        except KeyboardInterrupt:
            progress.clear()
            _cancel(running)
            late = [each.name for each in running if not each.is_ended]
            text = "Stopped by Ctrl-C"
            if late:
                text += f"; {', '.join(late)} did not confirm within {_STOP_S:g} s"
            return MotionOutcome(text, _INTERRUPTED, "stopped", {"joints": dict(self._measured)})
        progress.clear()
        failed = next((each for each in running if each.problem), None)
        if failed is None:
            return None
        _cancel(running)
        text = failed.problem
        if holders := self._stops.names:
            text += (
                f"; the robot is stopped by {', '.join(holders)} (teleopctl stop --robot --release)"
            )
        return MotionOutcome(text, 1, "failed", {"joints": dict(self._measured), **failed.facts})

    def _arrived(
        self, target: MoveTarget, end: Mapping[str, float], spent_s: float
    ) -> MotionOutcome:
        """Return the end of a motion that controllers report, by the measured positions.

        Args:
            target: The goal.
            end: Positions at the end of the trajectory, by joint.
            spent_s: Time that the motion took, s.
        """
        import numpy as np

        arm = self.arm
        self._wait_for_rest()
        arm.model.set_positions(self._measured)
        measured = arm.kinematics.present()
        pose = arm.kinematics.pose()
        x, y, z = (float(value) + 0.0 for value in pose[:3, 3])
        facts: dict[str, Any] = {
            "time_s": spent_s,
            "joints": arm.kinematics.by_name(measured),
            "position": {"x": x, "y": y, "z": z},
        }
        text = f"'{tool_name(arm)}' is at [{x:.3f}, {y:.3f}, {z:.3f}] after {spent_s:.1f} s"
        if target.pose is not None:
            away_m = float(np.linalg.norm(target.pose[:3, 3] - pose[:3, 3]))
            facts["position_error_m"] = away_m
            text += f", {1e3 * away_m:.1f} mm from the goal"
            if not target.is_position:
                from teleopctl.kinematics import rotation_vector

                turn = rotation_vector(target.pose[:3, :3] @ pose[:3, :3].T)
                facts["rotation_error_rad"] = float(np.linalg.norm(turn))
                text += f" and {math.degrees(facts['rotation_error_rad']):.1f} degrees"
        elif target.positions is not None:
            off = np.abs(target.positions - measured)
            facts["largest_joint_error"] = float(off.max())
            name = arm.names[int(off.argmax())]
            text += f"; '{name}' is farthest from its goal, by {float(off.max()):.4f}"
        if short := self._short_of(end):
            return MotionOutcome(f"{short}: {text}", 1, "failed", facts)
        return MotionOutcome(text, 0, "succeeded", facts)

    def _short_of(self, end: Mapping[str, float]) -> str:
        """Return which joint is not where a motion ended, as controllers need no tolerances."""
        for name, at in end.items():
            joint = self.arm.model.joints[name]
            off = at - self._measured.get(name, at)
            if joint.limits.angle_wraparound:
                off = math.remainder(off, 2.0 * math.pi)
            most, unit = (0.01, "m") if joint.joint.type == "prismatic" else (0.05, "rad")
            if abs(off) > most:
                return (
                    f"Joint '{name}' stays {abs(off):.3g} {unit} from the end of its trajectory; "
                    "something holds it"
                )
        return ""

    def _wait_for_rest(self) -> None:
        """Wait until the measured positions stay, at most for a short time."""
        end_s, before = time.monotonic() + _REST_S, dict[str, float]()
        while time.monotonic() < end_s:
            measured = self._measured
            if before and all(abs(at - before.get(n, at)) < _RESTS for n, at in measured.items()):
                return
            before = measured
            time.sleep(_PERIOD_S)

    # --- the gripper ----------------------------------------------------------------------------

    def opening(self, text: str) -> list[tuple[GripperRange, float]]:
        """Return the positions of the gripper's joints for ``open``, ``close`` or 0 to 1.

        Raises:
            NotFoundError: The robot has no gripper that is known.
            UsageError: The text is none of these.
        """
        from teleopctl.kinematics import gripper_ranges

        try:
            part = _OPENINGS[text] if text in _OPENINGS else float(text)
        except ValueError:
            part = math.nan
        if not 0.0 <= part <= 1.0:
            raise UsageError(
                f"--gripper is open, close or a number from 0 (closed) to 1 (open), not '{text}'"
            )
        groups = self.arm.groups
        gripper = groups.gripper_of(self.arm.group.name)
        if gripper is None:
            raise NotFoundError(
                f"The group '{self.arm.group.name}' has no gripper",
                hint="An SRDF names it as <end_effector>: teleopctl kinematics srdf --help",
            )
        ranges = gripper_ranges(self.arm.model, gripper)
        return [(one, one.position(part)) for one in ranges]

    def move_gripper(self, opening: list[tuple[GripperRange, float]]) -> MotionOutcome:
        """Move the gripper's joints, and wait for the end; Ctrl-C stops it.

        Raises:
            NotFoundError: No active controller moves a joint.
        """
        names = [one.joint for one, _ in opening]
        joints = self.arm.model.joints
        duration_s = _SHORTEST_S
        for one, position in opening:
            speed = joints[one.joint].limits.velocity
            speed = _GRIPPER_SPEED * speed if math.isfinite(speed) else _DEFAULT_SPEED
            way = abs(position - self._measured.get(one.joint, one.closed))
            duration_s = max(duration_s, way / speed)
        point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")(
            positions=[position for _, position in opening]
        )
        set_stamp(point.time_from_start, from_seconds(duration_s))
        trajectory: Any = get_message("trajectory_msgs/msg/JointTrajectory")(
            joint_names=names, points=[point]
        )
        outcome = self._follow(self._controllers_goals(trajectory), {})
        if outcome is not None:
            return outcome
        self._wait_for_rest()
        at = {name: self._measured.get(name, math.nan) for name in names}
        listed = ", ".join(f"'{name}' is at {value:.4g}" for name, value in at.items())
        return MotionOutcome(f"Gripper: {listed}", 0, "succeeded", {"joints": at})

    def _take_state(self, message: Any) -> None:
        found = dict(zip(message.name, map(float, message.position), strict=False))
        self._measured = {**self._measured, **found}


class _Running:
    """Goal of an action that was sent.

    Args:
        client: Client of the action.
        goal: The goal.
        name: Who executes it, for messages.

    Attributes:
        problem: Why it failed, as a sentence; empty if it did not.
        facts: Facts on the failure, for JSON.
        is_ended: Whether it has ended.
    """

    changed = threading.Event()

    def __init__(self, client: ActionClient[Any, Any, Any], goal: Any, name: str) -> None:
        self.name = name
        self.problem = ""
        self.facts: dict[str, Any] = {}
        self.is_ended = False
        self._client, self._handle = client, None
        if not client.wait_for_server(_ANSWER_S):
            raise UnavailableError(f"{name} does not offer the action {client.action_name}")
        self._handle = answer(client.send_goal_async(goal), _ANSWER_S, name)
        if not self._handle.accepted:
            self._end(f"{name} rejected the trajectory")
            return
        self._handle.get_result_async().add_done_callback(self._finished)

    def cancel(self) -> None:
        """Let the goal end, and the joints stop."""
        if self._handle is not None and not self.is_ended:
            self._handle.cancel_goal_async()

    def check_server(self) -> None:
        """Note the problem that the action's server is gone."""
        if not self.is_ended and not self._client.server_is_ready():
            self._end(f"{self.name} has gone while it was moving the robot")

    def _finished(self, future: Any) -> None:
        response = future.result()
        if response is None:
            self._end(f"{self.name} did not say how the motion ended")
            return
        result = response.result
        # Controllers have numbers, move_group a message with one.
        code = getattr(result, "error_code", 0)
        number, text = getattr(code, "val", code), getattr(code, "message", "")
        text = getattr(result, "error_string", "") or text
        is_good = number in (0, 1) if hasattr(code, "val") else number == 0
        if response.status == GoalState.SUCCEEDED and is_good:
            self._end("")
        elif response.status == GoalState.CANCELED:
            self._end(f"{self.name} ended the motion: it was canceled by another command")
        else:
            self.facts = {"error_code": int(number)}
            self._end(f"{self.name} failed: {text or f'error code {number}'}")

    def _end(self, problem: str) -> None:
        self.problem, self.is_ended = problem, True
        self.changed.set()


def _cancel(running: list[_Running]) -> None:
    """Stop the joints, and wait until the controllers say that they have ended."""
    for each in running:
        each.cancel()
    end_s = time.monotonic() + _STOP_S
    while not all(each.is_ended for each in running) and time.monotonic() < end_s:
        time.sleep(_PERIOD_S)


class _Progress:
    """Line on the terminal with the part of the way that is done.

    Args:
        start: Positions at the start.
        end: Positions at the end; empty to show nothing.
    """

    def __init__(self, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        self._end = end if sys.stderr.isatty() else {}
        self._way = max((abs(at - start.get(name, at)) for name, at in end.items()), default=0.0)
        self._shown = ""

    def show(self, measured: Mapping[str, float]) -> None:
        """Show how far the joints are."""
        if not self._end or self._way <= 0.0:
            return
        left = max(abs(at - measured.get(name, at)) for name, at in self._end.items())
        text = f"Moving: {100.0 * max(0.0, 1.0 - left / self._way):.0f} %"
        if text != self._shown:
            self._shown = text
            sys.stderr.write(f"\r{text:14}")
            sys.stderr.flush()

    def clear(self) -> None:
        """Remove the line."""
        if self._shown:
            sys.stderr.write(f"\r{'':14}\r")
            sys.stderr.flush()
            self._shown = ""


def _listed(controllers: list[Controller]) -> str:
    return "; ".join(f"{one.name} ({', '.join(one.joints)})" for one in controllers) or "none"
