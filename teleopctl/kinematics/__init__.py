"""Kinematics of robots: groups of joints, poses, inverse kinematics, clearance, servo.

Numbers in, numbers out: no node and no topic.

May import `mujoco_model`, `robot` and `tf`, and what every package may: `base`, `errors`,
`packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.kinematics.arm import (
        Arm as Arm,
        arm_clearance as arm_clearance,
        load_description as load_description,
        moved_links as moved_links,
    )
    from teleopctl.kinematics.clearance import (
        Approach as Approach,
        ClearanceChecker as ClearanceChecker,
    )
    from teleopctl.kinematics.efforts import (
        joint_efforts as joint_efforts,
        overload_note as overload_note,
    )
    from teleopctl.kinematics.error_codes import (
        MoveItErrorCode as MoveItErrorCode,
        PlanningError as PlanningError,
    )
    from teleopctl.kinematics.gripper import (
        GripperRange as GripperRange,
        gripper_ranges as gripper_ranges,
    )
    from teleopctl.kinematics.group_kinematics import GroupKinematics as GroupKinematics
    from teleopctl.kinematics.groups import (
        EndEffector as EndEffector,
        JointGroup as JointGroup,
        RobotGroups as RobotGroups,
        find_groups as find_groups,
        with_tip as with_tip,
    )
    from teleopctl.kinematics.model import KinematicModel as KinematicModel
    from teleopctl.kinematics.motion.constraint_planner import (
        PathConstraint as PathConstraint,
    )
    from teleopctl.kinematics.motion.limits import MotionLimits as MotionLimits
    from teleopctl.kinematics.motion.plan import (
        MotionPlan as MotionPlan,
        MotionSettings as MotionSettings,
        plan_line as plan_line,
        plan_to_joints as plan_to_joints,
        plan_to_pose as plan_to_pose,
    )
    from teleopctl.kinematics.motion.planner_names import (
        has_ompl as has_ompl,
        planner_names as planner_names,
        planner_parameters as planner_parameters,
    )
    from teleopctl.kinematics.poses import (
        invert_pose as invert_pose,
        pose_matrix as pose_matrix,
        pose_transform as pose_transform,
        rotation_matrix as rotation_matrix,
        rotation_vector as rotation_vector,
    )
    from teleopctl.kinematics.scene.allowed_collisions import (
        AllowedCollisions as AllowedCollisions,
    )
    from teleopctl.kinematics.scene.planning_scene import (
        AttachedBody as AttachedBody,
        CollisionBody as CollisionBody,
        CollisionScene as CollisionScene,
        CompiledScene as CompiledScene,
    )
    from teleopctl.kinematics.scene.shapes import (
        CollisionShape as CollisionShape,
        ShapeKind as ShapeKind,
    )
    from teleopctl.kinematics.self_collisions import (
        allowed_by_sampling as allowed_by_sampling,
    )
    from teleopctl.kinematics.servo.core import (
        ServoCore as ServoCore,
        ServoSettings as ServoSettings,
    )
    from teleopctl.kinematics.servo.singularity import Thresholds as Thresholds
    from teleopctl.kinematics.servo.status import (
        FOLDED as FOLDED,
        STRETCHED as STRETCHED,
        Reason as Reason,
        ServoStep as ServoStep,
        StatusCode as StatusCode,
    )
    from teleopctl.kinematics.solver import (
        IkSolution as IkSolution,
        IkSolver as IkSolver,
        PoseTask as PoseTask,
        Tolerance as Tolerance,
        served_task as served_task,
    )
    from teleopctl.kinematics.srdf import (
        parse_srdf as parse_srdf,
        read_srdf as read_srdf,
        write_srdf as write_srdf,
    )
    from teleopctl.kinematics.workspace import (
        Workspace as Workspace,
        sample_workspace as sample_workspace,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
