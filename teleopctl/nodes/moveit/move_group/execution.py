"""Execution of trajectories by the robot's controllers, one at a time."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from teleopctl.commander import (
    ActionKind,
    Controllers,
    RunningMotion,
    choose_controllers,
    listed,
)
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.kinematics import MoveItErrorCode
from teleopctl.node import StopHolders
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.parameters import configured_controllers, setting

# Polling period of the scene, of cancel requests and of the clock during execution, s.
_PERIOD_S = 0.02
# Time to wait until the joints are at rest, s.
_STOP_S = 10.0
# Further time for a gripper's action, s.
_GRIPPER_S = 10.0
# Joints that move less than this (rad or m) in this time (s) are at rest.
_STILL, _LOOK_S = 5e-4, 0.1
_EVENT_DEPTH = 100

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True)
class Outcome:
    """End of an execution: MoveIt's code, and what happened as a sentence."""

    code: MoveItErrorCode
    text: str = ""


class Execution:
    """Executor of trajectories, with the topic ``trajectory_execution_event``.

    A new trajectory replaces the one that is being executed, as in MoveIt.

    Args:
        context: Robot, state and scene.
    """

    def __init__(self, context: MoveGroupContext) -> None:
        self._context, self._node = context, context.node
        self._log = context.node.get_logger()
        self._controllers = Controllers(self._node, configured=configured_controllers(self._node))
        self._executing = threading.Lock()
        self._stop_count = 0
        self._stops = StopHolders(self._node, self._on_stop)
        self._node.create_subscription(
            get_message("std_msgs/msg/String"),
            "trajectory_execution_event",
            self._on_event,
            _EVENT_DEPTH,
        )

    def is_allowed(self) -> bool:
        """Return the parameter ``allow_trajectory_execution``."""
        return bool(self._setting("allow_trajectory_execution", default=True))

    def execute(
        self,
        trajectory: Any,
        *,
        named: list[str] | None = None,
        is_canceled: Callable[[], bool],
        is_valid: Callable[[float], str] | None = None,
    ) -> Outcome:
        """Execute a RobotTrajectory, and block until its end.

        Args:
            trajectory: A ``moveit_msgs/msg/RobotTrajectory``.
            named: Names of the controllers that may execute it; None or empty for any.
            is_canceled: Whether the execution shall end.
            is_valid: Function of the time since the begin, s, that returns why the rest of the
                trajectory must not be executed; empty if it may.
        """
        joints = trajectory.joint_trajectory
        if len(trajectory.multi_dof_joint_trajectory.points):
            return Outcome(
                MoveItErrorCode.CONTROL_FAILED,
                "Trajectories of joints with several degrees of freedom are not supported",
            )
        if not len(joints.points):
            return Outcome(MoveItErrorCode.SUCCESS)
        if problem := self._problem(joints):
            return Outcome(MoveItErrorCode.CONTROL_FAILED, problem)
        # The one before ends first.
        self._stop_count += 1
        with self._executing:
            count = self._stop_count

            def is_stopped() -> bool:
                return is_canceled() or self._stop_count != count

            return self._run(joints, list(named or ()), is_stopped, is_valid)

    def stop(self) -> None:
        """Stop the trajectory that is being executed."""
        self._stop_count += 1

    def end_present(self) -> None:
        """Stop what is being executed, and block until the joints are at rest."""
        if not self._executing.locked():
            return
        self.stop()
        with self._executing:
            end_s = time.monotonic() + _STOP_S
            before: dict[str, float] = {}
            while time.monotonic() < end_s:
                now = self._context.measured()
                if before and all(abs(at - before[name]) < _STILL for name, at in now.items()):
                    return
                before = now
                time.sleep(_LOOK_S)

    def _run(
        self,
        joints: Any,
        named: list[str],
        is_stopped: Callable[[], bool],
        is_valid: Callable[[float], str] | None,
    ) -> Outcome:
        available = self._controllers.available()
        names = list(joints.joint_names)
        chosen, left = choose_controllers(names, available, named)
        if left:
            return Outcome(
                MoveItErrorCode.CONTROL_FAILED,
                "Unable to identify any set of controllers that can actuate the specified joints: "
                f"{', '.join(left)}. Active controllers: {listed(available)}",
            )
        if problem := self._start_problem(joints):
            return Outcome(MoveItErrorCode.CONTROL_FAILED, problem)
        measured = self._context.measured()
        duration_s = 1e-9 * to_nanoseconds(joints.points[-1].time_from_start)
        has_trajectory = any(one.kind is ActionKind.TRAJECTORY for one in chosen)
        motion = RunningMotion.of(self._controllers, chosen, joints, measured)
        begin_s = self._now_s()
        version = self._context.scene.version
        while not motion.ended:
            motion.wait(_PERIOD_S)
            spent_s = self._now_s() - begin_s
            if failed := motion.failed:
                motion.cancel(self._now_s)
                return Outcome(MoveItErrorCode.CONTROL_FAILED, failed.problem)
            if is_stopped():
                motion.cancel(self._now_s)
                held = ", ".join(self._stops.names)
                return Outcome(
                    MoveItErrorCode.PREEMPTED,
                    f"The robot was stopped by {held}" if held else "The execution was stopped",
                )
            if is_valid is not None and self._context.scene.version != version:
                version = self._context.scene.version
                if why := is_valid(spent_s):
                    motion.cancel(self._now_s)
                    return Outcome(
                        MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE, why
                    )
            longest_s = self._longest_s(duration_s)
            if not has_trajectory:
                # A gripper closes at a speed of its own.
                longest_s += _GRIPPER_S
            if spent_s > longest_s:
                motion.cancel(self._now_s)
                return Outcome(
                    MoveItErrorCode.TIMED_OUT,
                    f"The controllers take longer than {longest_s:.1f} s for a "
                    f"trajectory of {duration_s:.1f} s "
                    "(trajectory_execution.allowed_execution_duration_scaling)",
                )
        if failed := motion.failed:
            return Outcome(MoveItErrorCode.CONTROL_FAILED, failed.problem)
        if any(goal.canceled for goal in motion.goals):
            held = ", ".join(self._stops.names)
            return Outcome(
                MoveItErrorCode.PREEMPTED,
                f"The robot was stopped by {held}"
                if held
                else "A controller ended the trajectory for another one",
            )
        return Outcome(MoveItErrorCode.SUCCESS)

    def _problem(self, joints: Any) -> str:
        """Return why a JointTrajectory cannot be executed, as a sentence; empty if it can."""
        if not self.is_allowed():
            return "Cannot execute trajectory since ~allow_trajectory_execution was set to false"
        if self._stops.names:
            return f"The robot is stopped by {', '.join(self._stops.names)}"
        count = len(joints.joint_names)
        known = self._context.scene.model.joints
        if unknown := [name for name in joints.joint_names if name not in known]:
            return f"The trajectory moves joints that the robot has not: {', '.join(unknown)}"
        before = -1
        for number, point in enumerate(joints.points, 1):
            for quantity in ("positions", "velocities", "accelerations"):
                values = np.asarray(getattr(point, quantity), np.float64)
                if len(values) not in ({count} if quantity == "positions" else {0, count}):
                    return (
                        f"Point {number} of the trajectory has {len(values)} {quantity} for "
                        f"{count} joints"
                    )
                if not np.isfinite(values).all():
                    return f"Point {number} of the trajectory has {quantity} that are not finite"
            at = to_nanoseconds(point.time_from_start)
            if at < before or (at == before and number > 1):
                return f"The times of the trajectory do not increase at point {number}"
            before = at
        return ""

    def _start_problem(self, joints: Any) -> str:
        """Return why the robot is not at the start of a trajectory; empty if it is."""
        names = tuple(joints.joint_names)
        if problem := self._context.state_problem(names):
            return problem
        most = float(self._setting("trajectory_execution.allowed_start_tolerance", 0.01))
        if most <= 0.0:
            return ""
        measured = self._context.measured()
        known = self._context.scene.model.joints
        for name, at in zip(names, joints.points[0].positions, strict=True):
            away = known[name].limits.offset(float(at), measured[name])
            own = self._setting(f"trajectory_execution.allowed_start_tolerance_joints.{name}", most)
            if abs(away) > float(own) > 0.0:
                return (
                    f"Invalid Trajectory: start point deviates from current robot state more than "
                    f"{float(own):g} at joint '{name}': {float(at):.4g} instead of "
                    f"{measured[name]:.4g}"
                )
        return ""

    def _longest_s(self, duration_s: float) -> float:
        if not self._setting("trajectory_execution.execution_duration_monitoring", default=True):
            return math.inf
        scaling = float(
            self._setting("trajectory_execution.allowed_execution_duration_scaling", 1.1)
        )
        margin_s = float(self._setting("trajectory_execution.allowed_goal_duration_margin", 0.5))
        return max(duration_s * scaling, duration_s) + margin_s

    # Any: the value of a parameter.
    def _setting(self, name: str, default: float) -> Any:
        return setting(self._node, name, default)

    def _now_s(self) -> float:
        return 1e-9 * float(self._node.get_clock().now().nanoseconds)

    def _on_event(self, message: Any) -> None:
        if message.data == "stop":
            self._log.info("Received event 'stop'")
            self.stop()
        else:
            self._log.warning(f"Unknown event type: '{message.data}'")

    def _on_stop(self, names: tuple[str, ...]) -> None:
        if names:
            self.stop()
