"""Commands to a running robot: its controllers, streams and goals, grippers, and its arms.

The place of MoveIt's ``moveit_commander``: below the nodes and verbs that move a robot.

May import `interfaces`, `kinematics`, `node`, `robot` and `tf`, and what every package may: `base`,
`errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.commander.commands import (
        CommandPublisher as CommandPublisher,
        RunningGoal as RunningGoal,
        RunningMotion as RunningMotion,
        goal_for as goal_for,
    )
    from teleopctl.commander.controllers import (
        ActionKind as ActionKind,
        CommandTopic as CommandTopic,
        Controller as Controller,
        Controllers as Controllers,
        StreamKind as StreamKind,
        active_controllers as active_controllers,
        choose_controllers as choose_controllers,
        choose_streams as choose_streams,
        listed as listed,
    )
    from teleopctl.commander.gripper import (
        GripperCommander as GripperCommander,
        gripper_positions as gripper_positions,
        opening_part as opening_part,
    )
    from teleopctl.commander.messages import (
        read_pose as read_pose,
        write_joint_trajectory as write_joint_trajectory,
        write_pose as write_pose,
    )
    from teleopctl.commander.planning import PlannedMotion as PlannedMotion
    from teleopctl.commander.running_arm import (
        ExecutionError as ExecutionError,
        MotionResult as MotionResult,
        RunningArm as RunningArm,
    )
    from teleopctl.commander.running_robot import (
        RunningRobot as RunningRobot,
        lookup_frame as lookup_frame,
        receive_robot as receive_robot,
    )
    from teleopctl.commander.targets import (
        MotionGoal as MotionGoal,
        frame_transform as frame_transform,
        rotation_of as rotation_of,
        target_pose as target_pose,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
