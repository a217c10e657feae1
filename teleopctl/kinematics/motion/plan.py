"""Plans of motion from a start to a joint goal, to a pose, or along a straight line of the tool."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.motion.limits import MotionLimits
from teleopctl.kinematics.poses import Array

if TYPE_CHECKING:
    from teleopctl.kinematics.clearance import ClearanceChecker
    from teleopctl.kinematics.solver import Task, Tolerance

StateCondition = Callable[[Array], bool]
"""Further condition on positions of the independent joints, (n,): whether they are allowed."""


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """Settings of a plan.

    Attributes:
        planner: Name of the planner, as OMPL names it (``RRTConnect``, ``RRTstar``, ``PRM``, …);
            empty for RRTConnect.
        library: ``ompl``, ``teleopctl`` for the planner of our own, or empty for OMPL where it is
            installed.
        timeout_s: Time for the search of a path, MoveIt's ``allowed_planning_time``, s.
        velocity_scaling: Part of the velocity limits that is used, above 0 to 1.
        acceleration_scaling: Part of the acceleration and jerk limits that is used, above 0 to 1.
        limits: Limits of the joints before scaling; None for those of the robot's description.
        path_tolerance: Largest distance from the path at its rounded corners, rad or m of each
            joint; 0 to stop at each waypoint.
        period_s: Time between the points of the plan, s.
        seed: Start of the random numbers; the same seed gives the same path.
    """

    planner: str = ""
    library: str = ""
    timeout_s: float = 5.0
    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    limits: MotionLimits | None = None
    path_tolerance: float = 0.02
    period_s: float = 0.01
    seed: int = 0


@dataclass(frozen=True, slots=True)
class MotionPlan:
    """Timed motion of a group's independent joints, as points of a ``JointTrajectory``.

    Attributes:
        joint_names: Names of the independent joints, n of them; mimic joints follow by themselves.
        times: Time of each point from the start, (k,), s; the first is 0.
        positions: Positions at the points, (k, n), rad or m.
        velocities: Velocities at the points, (k, n), rad/s or m/s; 0 at the first and the last.
        accelerations: Accelerations at the points, (k, n), rad/s² or m/s².
        planner: Library and name of the planner, such as ``OMPL RRTConnect``.
        computing_s: Time that planning took, s.
        duration_before_jerk_s: Duration under the limits of velocity and acceleration alone, s.
        waypoints: The path that is followed: corners, or points of the line, (m, n).
        fraction: Part of a line that is reached, 0 to 1; 1 for other motions.
        notes: What the caller should know, one sentence each, such as a start that was left.
    """

    joint_names: tuple[str, ...]
    times: Array
    positions: Array
    velocities: Array
    accelerations: Array
    planner: str
    computing_s: float
    duration_before_jerk_s: float
    waypoints: Array
    fraction: float = 1.0
    notes: tuple[str, ...] = field(default=())

    @property
    def duration_s(self) -> float:
        """Duration of the motion, s."""
        return float(self.times[-1])


def plan_to_joints(
    kinematics: GroupKinematics,
    start: Array,
    goals: Array | Sequence[Array],
    *,
    clearance: ClearanceChecker | None = None,
    condition: StateCondition | None = None,
    settings: MotionSettings | None = None,
) -> MotionPlan:
    """Plan a motion to positions of the joints.

    The model's other joints stay as they are; the model is at the start again afterwards.

    Args:
        kinematics: Kinematics of the group.
        start: Present positions of the independent joints, (n,), rad or m.
        goals: Positions to reach, (n,), or several of them, of which any will do.
        clearance: Checker of collisions; None to check none.
        condition: Condition on all positions of the path, such as an orientation to be kept.
        settings: Settings.

    Raises:
        PlanningError: There is no such motion, or none was found in time; with MoveIt's code.
        UsageError: A setting is invalid.
    """
    raise NotImplementedError


def plan_to_pose(
    kinematics: GroupKinematics,
    start: Array,
    T_root_tool: Array,
    *,
    task: Task | None = None,
    tolerance: Tolerance | None = None,
    clearance: ClearanceChecker | None = None,
    condition: StateCondition | None = None,
    settings: MotionSettings | None = None,
) -> MotionPlan:
    """Plan a motion to a pose of the tool.

    Args:
        kinematics: Kinematics of the group.
        start: Present positions of the independent joints, (n,), rad or m.
        T_root_tool: Pose to reach in the root link's frame, (4, 4).
        task: What of the pose is served; None for what the joints allow.
        tolerance: Errors at which the pose counts as reached.
        clearance: Checker of collisions; None to check none.
        condition: Condition on all positions of the path.
        settings: Settings.

    Raises:
        PlanningError: As `plan_to_joints`; without a solution, code -31 and what binds.
        UsageError: A setting or the pose is invalid.
    """
    raise NotImplementedError


def plan_line(
    kinematics: GroupKinematics,
    start: Array,
    poses: Sequence[Array],
    *,
    max_step_m: float = 0.01,
    jump_factor: float = 0.0,
    jump_rad: float = 0.0,
    jump_m: float = 0.0,
    task: Task | None = None,
    clearance: ClearanceChecker | None = None,
    condition: StateCondition | None = None,
    settings: MotionSettings | None = None,
    least_fraction: float = 1.0,
) -> MotionPlan:
    """Plan a motion of the tool on straight lines through poses.

    Args:
        kinematics: Kinematics of the group.
        start: Present positions of the independent joints, (n,), rad or m.
        poses: Poses of the tool in the root link's frame, (4, 4) each.
        max_step_m: Largest distance between two solutions of inverse kinematics, m.
        jump_factor: Step of the joints that counts as a jump, in average steps; 0 to allow all.
        jump_rad: Step of a revolute joint that counts as a jump, rad; 0 to allow all.
        jump_m: Step of a prismatic joint that counts as a jump, m; 0 to allow all.
        task: What of the poses is served; None for what the joints allow.
        clearance: Checker of collisions; None to check none.
        condition: Condition on all positions of the path.
        settings: Settings.
        least_fraction: Part of the lines that must be reached, 0 to 1.

    Raises:
        PlanningError: Less than that part can be followed; with MoveIt's code and what ended it.
        UsageError: A setting or a pose is invalid.
    """
    raise NotImplementedError
