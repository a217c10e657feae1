"""Plans of motions to goals, in this process or by a running ``move_group``."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.commander.messages import write_joint_trajectory, write_pose
from teleopctl.commander.targets import Array, MotionGoal, MotionTarget
from teleopctl.errors import UnavailableError, UsageError
from teleopctl.interfaces import get_action, get_message, get_service, to_nanoseconds
from teleopctl.kinematics import MoveItErrorCode, PlanningError, PoseTask, served_task
from teleopctl.node import ActionClient

if TYPE_CHECKING:
    from teleopctl.kinematics import Arm
    from teleopctl.node import Future, Node

MOVE_ACTION, EXECUTE_TRAJECTORY = "move_action", "execute_trajectory"
_CARTESIAN_PATH = "compute_cartesian_path"
# Tolerances of goals that are sent to move_group: m and rad, as of our inverse kinematics.
_POSITION_M, _ROTATION_RAD, _JOINT = 1e-4, 1e-3, 1e-4
# Distance between two points of a line, m.
_STEP_M = 0.005
# Timeout for the result beyond the planning time, and polling period of the result, s.
_ANSWER_S, _LOOK_S = 5.0, 0.05
_SPHERE = 2
# Distance, m, from the goal at which a motion that move_group planned is not executed.
_END_M = 0.005

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True, slots=True)
class PlannedMotion:
    """Motion that is planned and has not been executed.

    Attributes:
        trajectory: The motion as a ``trajectory_msgs/msg/JointTrajectory``.
        target: Goal of the plan.
        planner: Library and name of the planner, or ``move_group``.
        computing_s: Time that planning took, s.
        notes: Notes for the user, one sentence each.
        robot_trajectory: Answer of move_group, which executes it; None if planned here.
    """

    trajectory: Any
    target: MotionTarget
    planner: str
    computing_s: float
    notes: Sequence[str] = field(default=())
    robot_trajectory: Any = None

    @property
    def duration_s(self) -> float:
        """Duration of the motion, s."""
        points = self.trajectory.points
        return 1e-9 * to_nanoseconds(points[-1].time_from_start) if len(points) else 0.0

    @property
    def summary(self) -> str:
        """One sentence about the plan: duration, computing time, planner."""
        return (
            f"Planned a motion of {self.duration_s:.2f} s in {self.computing_s:.2f} s "
            f"({self.planner}, {len(self.trajectory.points)} points)"
        )


# --- in this process -----------------------------------------------------------------------------


def plan_here(
    arm: Arm, goal: MotionGoal, target: MotionTarget, is_canceled: Callable[[], bool]
) -> PlannedMotion:
    """Plan a motion in this process.

    Raises:
        PlanningError: There is no plan, or planning is canceled.
    """
    settings = replace(goal.settings, is_canceled=is_canceled)
    if target.positions is not None:
        plan = arm.plan(target.positions, settings=settings)
    else:
        assert target.pose is not None
        if goal.linear:
            plan = arm.line(target.pose, settings=settings)
        else:
            plan = arm.plan(target.pose, settings=settings, is_position=target.is_position)
    trajectory = write_joint_trajectory(plan, arm.model.description.root)
    return PlannedMotion(trajectory, target, plan.planner, plan.computing_s, plan.notes)


# --- move_group ---------------------------------------------------------------------------------


class MoveGroupPlanner:
    """Client of a running ``move_group`` that plans motions.

    Args:
        node: Node of the clients, which something else spins.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._action: Any = get_action("moveit_msgs/action/MoveGroup")
        self._line: Any = get_service("moveit_msgs/srv/GetCartesianPath")
        self._move = ActionClient(node, self._action, MOVE_ACTION)
        self._path = node.create_client(self._line, _CARTESIAN_PATH)

    def plan(
        self, arm: Arm, goal: MotionGoal, target: MotionTarget, is_canceled: Callable[[], bool]
    ) -> PlannedMotion:
        """Plan a motion by move_group; Ctrl-C cancels the request.

        Raises:
            PlanningError: There is no plan, with the code of move_group; or planning is canceled.
            UnavailableError: move_group does not answer.
        """
        trajectory, computing_s, notes = (
            self._cartesian_path(arm, goal, target.pose, is_canceled)
            if goal.linear and target.pose is not None
            else self._motion_plan(arm, goal, target, is_canceled)
        )
        _check_end(arm, target, trajectory.joint_trajectory)
        return PlannedMotion(
            trajectory.joint_trajectory,
            target,
            f"move_group{' ' if goal.planner else ''}{goal.planner}",
            computing_s,
            [notes] if notes else [],
            robot_trajectory=trajectory,
        )

    def _motion_plan(
        self, arm: Arm, goal: MotionGoal, target: MotionTarget, is_canceled: Callable[[], bool]
    ) -> tuple[Any, float, str]:
        message = self._action.Goal()
        request = message.request
        request.group_name, request.planner_id = arm.group.name, goal.planner
        request.num_planning_attempts = 1
        request.allowed_planning_time = goal.timeout_s
        request.max_velocity_scaling_factor = goal.speed
        request.max_acceleration_scaling_factor = goal.acceleration
        request.start_state.is_diff = True
        request.goal_constraints = [_constraints(arm, target)]
        message.planning_options.plan_only = True
        message.planning_options.planning_scene_diff.is_diff = True
        message.planning_options.planning_scene_diff.robot_state.is_diff = True
        handle = _answer(self._move.send_goal_async(message), _ANSWER_S, is_canceled)
        if not handle.accepted:
            raise UnavailableError("move_group rejected the goal")
        try:
            response = _answer(handle.get_result_async(), goal.timeout_s + _ANSWER_S, is_canceled)
        except BaseException:
            handle.cancel_goal_async()
            raise
        result = response.result
        _check_code(result.error_code)
        notes = getattr(result.error_code, "message", "")
        return result.planned_trajectory, float(result.planning_time), notes

    def _cartesian_path(
        self, arm: Arm, goal: MotionGoal, pose: Array, is_canceled: Callable[[], bool]
    ) -> tuple[Any, float, str]:
        kinematics = arm.kinematics
        if kinematics.T_tip_tool[:3, 3].any() and served_task(kinematics) is not PoseTask.POSE:
            raise UsageError(
                "move_group plans lines of links, and the joints do not hold the rotation that "
                f"would carry a tool beside '{arm.group.tip}' along",
                hint="With --direct (direct=True) the line is planned here, without the scene of "
                "move_group.",
            )
        request = self._line.Request(
            group_name=arm.group.name,
            link_name=arm.group.tip,
            max_step=_STEP_M,
            avoid_collisions=True,
            max_velocity_scaling_factor=goal.speed,
            max_acceleration_scaling_factor=goal.acceleration,
        )
        request.header.frame_id = arm.model.description.root
        request.start_state.is_diff = True
        request.waypoints = [write_pose(kinematics.tip_pose(pose))]
        begin = time.monotonic()
        response = _answer(self._path.call_async(request), goal.timeout_s + _ANSWER_S, is_canceled)
        if response.fraction < 1.0:
            why = getattr(response.error_code, "message", "")
            raise PlanningError(
                f"Only {100.0 * max(response.fraction, 0.0):.0f} % of the line can be followed"
                f"{f': {why}' if why else ''}",
                MoveItErrorCode.PLANNING_FAILED,
            )
        _check_code(response.error_code)
        notes = getattr(response.error_code, "message", "")
        return response.solution, time.monotonic() - begin, notes


def _check_end(arm: Arm, target: MotionTarget, trajectory: Any) -> None:
    """Raise a PlanningError if a planned motion does not end at its goal.

    Another move_group may have another tip, or other frames.
    """
    if target.pose is None or not trajectory.points:
        return
    names, end = trajectory.joint_names, trajectory.points[-1].positions
    at = arm.fk(dict(zip(names, map(float, end), strict=True)))[:3, 3]
    away_m = float(np.linalg.norm(at - target.pose[:3, 3]))
    if away_m > _END_M:
        raise PlanningError(
            f"move_group planned a motion that ends {1e3 * away_m:.0f} mm from the goal; "
            "with --direct (direct=True) it is planned here",
            MoveItErrorCode.INVALID_MOTION_PLAN,
        )


def _constraints(arm: Arm, target: MotionTarget) -> Any:
    """Return a target as a ``moveit_msgs/msg/Constraints``."""
    constraints: Any = get_message("moveit_msgs/msg/Constraints")()
    if target.positions is not None:
        constraints.joint_constraints = [
            get_message("moveit_msgs/msg/JointConstraint")(
                joint_name=name,
                position=float(at),
                tolerance_above=_JOINT,
                tolerance_below=_JOINT,
                weight=1.0,
            )
            for name, at in zip(arm.names, target.positions, strict=True)
        ]
        return constraints
    assert target.pose is not None
    root, tip = arm.model.description.root, arm.group.tip
    place: Any = get_message("moveit_msgs/msg/PositionConstraint")(link_name=tip, weight=1.0)
    place.header.frame_id = root
    offset = place.target_point_offset
    offset.x, offset.y, offset.z = map(float, arm.kinematics.T_tip_tool[:3, 3])
    place.constraint_region.primitives = [
        get_message("shape_msgs/msg/SolidPrimitive")(type=_SPHERE, dimensions=[_POSITION_M])
    ]
    centre = np.eye(4)
    centre[:3, 3] = target.pose[:3, 3]
    place.constraint_region.primitive_poses = [write_pose(centre)]
    constraints.position_constraints = [place]
    if not target.is_position:
        turn: Any = get_message("moveit_msgs/msg/OrientationConstraint")(
            link_name=tip,
            absolute_x_axis_tolerance=_ROTATION_RAD,
            absolute_y_axis_tolerance=_ROTATION_RAD,
            absolute_z_axis_tolerance=_ROTATION_RAD,
            weight=1.0,
        )
        turn.header.frame_id = root
        turn.orientation = write_pose(arm.kinematics.tip_pose(target.pose)).orientation
        constraints.orientation_constraints = [turn]
    return constraints


def _check_code(code: Any) -> None:
    """Raise a PlanningError for a ``moveit_msgs/msg/MoveItErrorCodes`` that is no success."""
    if code.val == MoveItErrorCode.SUCCESS:
        return
    try:
        known = MoveItErrorCode(code.val)
    except ValueError:
        known = MoveItErrorCode.FAILURE
    why = getattr(code, "message", "")
    raise PlanningError(f"{known.name} ({code.val}){f': {why}' if why else ''}", known)


# Any: responses of any service.
def _answer(future: Future[Any], longest_s: float, is_canceled: Callable[[], bool]) -> Any:
    """Return the result of a future of move_group.

    Raises:
        PlanningError: Planning is canceled.
        UnavailableError: The result does not arrive in time.
    """
    end_s = time.monotonic() + longest_s
    # In short waits, so that Ctrl-C ends it on Windows too.
    while not future.wait(_LOOK_S) and time.monotonic() < end_s:
        if is_canceled():
            raise PlanningError("The search was canceled", MoveItErrorCode.PREEMPTED)
    if not future.ended() or (result := future.result()) is None:
        raise UnavailableError(f"move_group does not answer within {longest_s:g} s")
    return result
