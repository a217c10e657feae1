"""Goals of ``teleopctl move`` and the motions that are planned for them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.cli.verbs.kinematics.queries import frame_transform, rotation_of, target_pose
from teleopctl.cli.verbs.kinematics.source import numbers, sorted_words
from teleopctl.errors import UnavailableError, UsageError
from teleopctl.interfaces import (
    from_seconds,
    get_action,
    get_message,
    get_service,
    set_stamp,
    to_nanoseconds,
)

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from teleopctl.bag import Curve
    from teleopctl.kinematics import Arm, MotionPlan
    from teleopctl.node import Future, Node

    Array = npt.NDArray[np.float64]

MOVE_ACTION, EXECUTE_TRAJECTORY, CARTESIAN_PATH = (
    "move_action",
    "execute_trajectory",
    "compute_cartesian_path",
)
# Tolerances of goals that are sent to move_group: m and rad, as of our inverse kinematics.
_POSITION_M, _ROTATION_RAD, _JOINT = 1e-4, 1e-3, 1e-4
# Distance between two points of a line, m.
_STEP_M = 0.005
# Time beyond that of planning until an answer must have come, s.
_ANSWER_S = 5.0
_SPHERE = 2
# Distance, m, from the goal at which a motion that move_group planned is not executed.
_END_M = 0.005

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal of the command line, unread; see ``teleopctl move --help``."""

    to: str | None
    rpy: str | None
    quat: str | None
    frame: str | None
    linear: bool
    joints: str | None
    named: str | None
    speed: float
    acceleration: float
    planner: str
    timeout_s: float


class MoveTarget(NamedTuple):
    """A goal in numbers.

    Attributes:
        positions: Positions of the independent joints, (n,); None for a pose.
        pose: Pose of the tool in the root link's frame, (4, 4); None for positions.
        is_position: Whether of the pose only the position counts.
    """

    positions: Array | None
    pose: Array | None
    is_position: bool = False


@dataclass(frozen=True, slots=True)
class PlannedMotion:
    """A planned motion as a ``trajectory_msgs/msg/JointTrajectory``.

    Attributes:
        trajectory: The trajectory.
        target: What it is planned for.
        planner: Who planned it.
        computing_s: Time that planning took, s.
        notes: What the user should know, one sentence each.
        robot_trajectory: The answer of move_group, which executes it; None if planned here.
    """

    trajectory: Any
    target: MoveTarget
    planner: str
    computing_s: float
    notes: Sequence[str] = ()
    robot_trajectory: Any = None

    @property
    def duration_s(self) -> float:
        """Duration of the motion, s."""
        points = self.trajectory.points
        return 1e-9 * to_nanoseconds(points[-1].time_from_start) if len(points) else 0.0

    @property
    def summary(self) -> str:
        """Return one sentence about the plan: duration, computing time, planner."""
        return (
            f"Planned a motion of {self.duration_s:.2f} s in {self.computing_s:.2f} s "
            f"({self.planner}, {len(self.trajectory.points)} points)"
        )

    def curves(self, quantity: str) -> list[Curve]:
        """Return ``positions``, ``velocities`` or ``accelerations`` of each joint over time."""
        from teleopctl.bag import Curve

        points = self.trajectory.points
        times = [1e-9 * to_nanoseconds(point.time_from_start) for point in points]
        found = []
        for place, name in enumerate(self.trajectory.joint_names):
            rows = [getattr(point, quantity) for point in points]
            values = [float(row[place]) if place < len(row) else math.nan for row in rows]
            found.append(Curve(name, times, values))
        return found

    def document(self, *, with_points: bool) -> dict[str, Any]:
        """Return the motion for JSON.

        Args:
            with_points: Whether to add the points of the trajectory.
        """
        points = self.trajectory.points if with_points else ()
        return {
            "planner": self.planner,
            "computing_s": self.computing_s,
            "duration_s": self.duration_s,
            "joint_names": list(self.trajectory.joint_names),
            "notes": list(self.notes),
            **(
                {
                    "points": [
                        {
                            "time_s": 1e-9 * to_nanoseconds(point.time_from_start),
                            "positions": list(map(float, point.positions)),
                            "velocities": list(map(float, point.velocities)),
                            "accelerations": list(map(float, point.accelerations)),
                        }
                        for point in points
                    ]
                }
                if with_points
                else {}
            ),
        }


def target_of(goal: Goal, arm: Arm) -> MoveTarget:
    """Return a goal in numbers.

    Raises:
        NotFoundError: There is no such frame, joint or state.
        UsageError: A number is none, or there is another number of them.
    """
    if goal.named is not None:
        arm.fk(goal.named)
        return MoveTarget(arm.kinematics.present(), None)
    if goal.joints is not None:
        words = sorted_words(goal.joints.replace(",", " ").split())
        if words.names or words.file or (words.numbers and words.joints):
            raise UsageError(
                f"--joints takes numbers or JOINT=POSITION, with commas; got '{goal.joints}'"
            )
        arm.fk(words.joints or words.numbers)
        return MoveTarget(arm.kinematics.present(), None)
    assert goal.to is not None
    rotation = rotation_of(goal.rpy, goal.quat)
    position = numbers(goal.to, 3, "--to", "x,y,z")
    arm.fk()
    _, T_frame_root = frame_transform(arm, goal.frame, is_running=True)
    pose = target_pose(arm, T_frame_root, position, rotation)
    return MoveTarget(None, pose, rotation is None and not goal.linear)


def plan_here(arm: Arm, goal: Goal, target: MoveTarget) -> PlannedMotion:
    """Plan a motion in this process.

    Raises:
        PlanningError: There is none.
    """
    from teleopctl.kinematics import MotionSettings

    settings = MotionSettings(
        planner=goal.planner,
        timeout_s=goal.timeout_s,
        velocity_scaling=goal.speed,
        acceleration_scaling=goal.acceleration,
    )
    if target.positions is not None:
        plan = arm.plan(target.positions, settings=settings)
    elif goal.linear:
        assert target.pose is not None
        plan = arm.line(target.pose, settings=settings)
    else:
        assert target.pose is not None
        plan = arm.plan(target.pose, settings=settings, is_position=target.is_position)
    return PlannedMotion(
        trajectory_of(plan, arm.model.description.root),
        target,
        plan.planner,
        plan.computing_s,
        plan.notes,
    )


def trajectory_of(plan: MotionPlan, frame: str) -> Any:
    """Return a plan as a ``trajectory_msgs/msg/JointTrajectory``."""
    point_type: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    trajectory: Any = get_message("trajectory_msgs/msg/JointTrajectory")()
    trajectory.header.frame_id = frame
    trajectory.joint_names = list(plan.joint_names)
    for time_s, *rows in zip(
        plan.times, plan.positions, plan.velocities, plan.accelerations, strict=True
    ):
        positions, velocities, accelerations = (row.tolist() for row in rows)
        point = point_type(positions=positions, velocities=velocities, accelerations=accelerations)
        set_stamp(point.time_from_start, from_seconds(float(time_s)))
        trajectory.points.append(point)
    return trajectory


# --- move_group ---------------------------------------------------------------------------------


def plan_by_move_group(node: Node, arm: Arm, goal: Goal, target: MoveTarget) -> PlannedMotion:
    """Let the running move_group plan a motion.

    Args:
        node: Node of the clients, which something else spins.
        arm: The arm.
        goal: The goal.
        target: The goal in numbers.

    Raises:
        PlanningError: There is none; with the code of move_group.
        UnavailableError: move_group does not answer.
    """
    response = (
        _cartesian_path(node, arm, goal, target)
        if goal.linear and target.pose is not None
        else _motion_plan(node, arm, goal, target)
    )
    trajectory, computing_s = response
    _check_end(arm, target, trajectory.joint_trajectory)
    return PlannedMotion(
        trajectory.joint_trajectory,
        target,
        f"move_group{' ' if goal.planner else ''}{goal.planner}",
        computing_s,
        robot_trajectory=trajectory,
    )


def _check_end(arm: Arm, target: MoveTarget, trajectory: Any) -> None:
    """Raise a PlanningError if a planned motion does not end where it was asked to.

    Another move_group may know another tip, or other frames.
    """
    import numpy as np

    from teleopctl.kinematics import MoveItErrorCode, PlanningError

    if target.pose is None or not trajectory.points:
        return
    names, end = trajectory.joint_names, trajectory.points[-1].positions
    at = arm.fk(dict(zip(names, map(float, end), strict=True)))[:3, 3]
    away_m = float(np.linalg.norm(at - target.pose[:3, 3]))
    if away_m > _END_M:
        raise PlanningError(
            f"move_group planned a motion that ends {1e3 * away_m:.0f} mm from the goal; "
            "with --direct it is planned here",
            MoveItErrorCode.INVALID_MOTION_PLAN,
        )


def _motion_plan(node: Node, arm: Arm, goal: Goal, target: MoveTarget) -> tuple[Any, float]:
    kind: Any = get_action("moveit_msgs/action/MoveGroup")
    message = kind.Goal()
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
    from teleopctl.node import ActionClient

    client = ActionClient(node, kind, MOVE_ACTION)
    handle = answer(client.send_goal_async(message), _ANSWER_S, "move_group")
    if not handle.accepted:
        raise UnavailableError("move_group rejected the goal")
    response = answer(handle.get_result_async(), goal.timeout_s + _ANSWER_S, "move_group")
    _check_code(response.result.error_code)
    return response.result.planned_trajectory, float(response.result.planning_time)


def _constraints(arm: Arm, target: MoveTarget) -> Any:
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
    from teleopctl.kinematics import pose_transform

    assert target.pose is not None
    root, tip = arm.model.description.root, arm.group.tip
    at = pose_transform(target.pose)
    place: Any = get_message("moveit_msgs/msg/PositionConstraint")(link_name=tip, weight=1.0)
    place.header.frame_id = root
    offset = arm.kinematics.T_tip_tool[:3, 3]
    set_vector(place.target_point_offset, offset)
    place.constraint_region.primitives = [
        get_message("shape_msgs/msg/SolidPrimitive")(type=_SPHERE, dimensions=[_POSITION_M])
    ]
    center: Any = get_message("geometry_msgs/msg/Pose")()
    set_vector(center.position, at.translation)
    place.constraint_region.primitive_poses = [center]
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
        rotation = pose_transform(arm.kinematics.tip_pose(target.pose)).rotation
        set_vector(turn.orientation, rotation)
        constraints.orientation_constraints = [turn]
    return constraints


def _cartesian_path(node: Node, arm: Arm, goal: Goal, target: MoveTarget) -> tuple[Any, float]:
    import time

    from teleopctl.kinematics import (
        MoveItErrorCode,
        PlanningError,
        PoseTask,
        pose_transform,
        served_task,
    )

    if arm.kinematics.T_tip_tool[:3, 3].any() and served_task(arm.kinematics) is not PoseTask.POSE:
        raise UsageError(
            "move_group plans lines of links, and the joints do not hold the rotation that would "
            f"carry a tool beside '{arm.group.tip}' along",
            hint="With --direct the line is planned here, without the scene of move_group.",
        )
    kind: Any = get_service("moveit_msgs/srv/GetCartesianPath")
    request = kind.Request(
        group_name=arm.group.name,
        link_name=arm.group.tip,
        max_step=_STEP_M,
        avoid_collisions=True,
        max_velocity_scaling_factor=goal.speed,
        max_acceleration_scaling_factor=goal.acceleration,
    )
    request.header.frame_id = arm.model.description.root
    request.start_state.is_diff = True
    assert target.pose is not None
    at = pose_transform(arm.kinematics.tip_pose(target.pose))
    waypoint: Any = get_message("geometry_msgs/msg/Pose")()
    set_vector(waypoint.position, at.translation)
    set_vector(waypoint.orientation, at.rotation)
    request.waypoints = [waypoint]
    begin = time.monotonic()
    client = node.create_client(kind, CARTESIAN_PATH)
    response = answer(client.call_async(request), goal.timeout_s + _ANSWER_S, "move_group")
    if response.fraction < 1.0:
        why = getattr(response.error_code, "message", "")
        raise PlanningError(
            f"Only {100.0 * max(response.fraction, 0.0):.0f} % of the line can be followed"
            f"{f': {why}' if why else ''}",
            MoveItErrorCode.PLANNING_FAILED,
        )
    _check_code(response.error_code)
    return response.solution, time.monotonic() - begin


def _check_code(code: Any) -> None:
    """Raise a PlanningError for a ``moveit_msgs/msg/MoveItErrorCodes`` that is no success."""
    from teleopctl.kinematics import MoveItErrorCode, PlanningError

    if code.val == MoveItErrorCode.SUCCESS:
        return
    try:
        known = MoveItErrorCode(code.val)
    except ValueError:
        known = MoveItErrorCode.FAILURE
    why = getattr(code, "message", "")
    raise PlanningError(f"{known.name} ({code.val}){f': {why}' if why else ''}", known)


# Any: a message of geometry.
def set_vector(message: Any, values: Sequence[float] | Array) -> None:
    """Set ``x``, ``y``, ``z`` and, of four values, ``w`` of a message."""
    for name, value in zip("xyzw", values, strict=False):
        setattr(message, name, float(value))


# Any: responses of any service.
def answer(future: Future[Any], longest_s: float, of: str) -> Any:
    """Return the result of a future.

    Raises:
        UnavailableError: It does not come in time.
    """
    if not future.wait(longest_s) or (result := future.result()) is None:
        raise UnavailableError(f"{of} does not answer within {longest_s:g} s")
    return result
