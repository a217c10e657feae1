"""The robot description: xacro, URDF, ``<ros2_control>``, ``<gazebo>`` and forward kinematics."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription as RobotDescription
    from teleopctl.robot.free_joints import JointSet as JointSet
    from teleopctl.robot.gazebo_tag import Sensor as Sensor
    from teleopctl.robot.joint_rules import JointLimits as JointLimits
    from teleopctl.robot.joints import JointModel as JointModel, Joints as Joints
    from teleopctl.robot.kinematics import SegmentTree as SegmentTree
    from teleopctl.robot.ros2_control_tag import (
        ComponentInfo as ComponentInfo,
        HardwareInfo as HardwareInfo,
        InterfaceInfo as InterfaceInfo,
    )
    from teleopctl.robot.urdf import Joint as Joint, Link as Link, Mimic as Mimic, Pose as Pose
    from teleopctl.robot.xacro_file import expand_xacro as expand_xacro
else:
    from teleopctl.lazy import attach

    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "description": "RobotDescription",
            "free_joints": "JointSet",
            "gazebo_tag": "Sensor",
            "joint_rules": "JointLimits",
            "joints": "JointModel Joints",
            "kinematics": "SegmentTree",
            "ros2_control_tag": "ComponentInfo HardwareInfo InterfaceInfo",
            "urdf": "Joint Link Mimic Pose",
            "xacro_file": "expand_xacro",
        },
    )
