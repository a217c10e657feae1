"""Parameters of MoveIt's configurations: limits that hold, and what is said to have no effect."""

import math

import pytest

from teleopctl.commander import ActionKind
from teleopctl.errors import UsageError
from teleopctl.node import Parameter
from teleopctl.nodes.moveit.move_group.parameters import (
    configured_controllers,
    limited_joints,
    mention_unused,
)
from teleopctl.robot import Joints, RobotDescription

from ...kinematics.arms import THREE, arm_urdf


class Log:
    def __init__(self):
        self.lines: list[str] = []
        self.info = self.warning = self.error = self.lines.append


class Node:
    """What is read of a node: its parameters."""

    def __init__(self, **parameters):
        self._parameters = parameters
        self.log = Log()

    def get_parameter_or(self, name, alternative_value):
        if name in self._parameters:
            return Parameter(name, value=self._parameters[name])
        return alternative_value

    def get_parameter_overrides(self):
        return {name: Parameter(name, value=value) for name, value in self._parameters.items()}

    def get_logger(self):
        return self.log


LIMITS = "robot_description_planning.joint_limits.joint_1"


@pytest.fixture(scope="module")
def joints() -> Joints:
    return Joints.of(RobotDescription.from_urdf(arm_urdf(THREE)))


def test_the_narrower_limit_of_a_joint_holds(joints):
    node = Node(
        **{
            f"{LIMITS}.has_velocity_limits": True,
            f"{LIMITS}.max_velocity": 0.5,
            f"{LIMITS}.has_acceleration_limits": True,
            f"{LIMITS}.max_acceleration": 3.0,
            f"{LIMITS}.has_position_limits": True,
            f"{LIMITS}.min_position": -9.0,
            f"{LIMITS}.max_position": 1.0,
        }
    )
    found = limited_joints(node, joints)  # type: ignore[arg-type]
    first, second = found["joint_1"].limits, found["joint_2"].limits
    assert (first.velocity, first.acceleration, first.deceleration) == (0.5, 3.0, 3.0)
    assert (first.lower, first.upper) == (-2.6, 1.0)
    assert second == joints["joint_2"].limits


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"has_velocity_limits": True, "max_velocity": -1.0}, "max_velocity' must be above 0"),
        ({"has_velocity_limits": True, "max_velocity": math.nan}, "must be above 0, got nan"),
        ({"has_acceleration_limits": True}, "max_acceleration' must be above 0, got None"),
        (
            {"has_position_limits": True, "min_position": 1.0, "max_position": 0.0},
            "are no range: 1.0 and 0.0",
        ),
    ],
)
def test_limits_that_are_none_are_refused(joints, parameters, problem):
    node = Node(**{f"{LIMITS}.{name}": value for name, value in parameters.items()})
    with pytest.raises(UsageError, match=problem):
        limited_joints(node, joints)  # type: ignore[arg-type]


def test_parameters_without_effect_are_named_once_for_each_file_with_the_reason():
    node = Node(
        **{
            "robot_description_kinematics.arm.kinematics_solver": "kdl",
            "robot_description_kinematics.arm.kinematics_solver_timeout": 0.1,
            "ompl.planner_configs.A.range": 0.1,
            "ompl.planner_configs.B.range": 0.1,
            "ompl.projection_evaluator": "",
            "allow_trajectory_execution": True,
            "something_else": 1,
        }
    )
    mention_unused(node)  # type: ignore[arg-type]
    kinematics, ompl, unknown = node.log.lines
    assert "kinematics_solver_timeout' of kinematics.yaml have no effect" in kinematics
    assert "and 1 more of ompl_planning.yaml have no effect" in ompl
    assert unknown == "Unknown parameters, which have no effect: something_else"


def test_controllers_of_moveit_s_file_are_used_and_wrong_ones_named():
    prefix = "moveit_simple_controller_manager"
    node = Node(
        **{
            f"{prefix}.controller_names": ["arm", "hand", "odd"],
            f"{prefix}.arm.type": "FollowJointTrajectory",
            f"{prefix}.arm.action_ns": "follow_joint_trajectory",
            f"{prefix}.arm.joints": ["a", "b"],
            f"{prefix}.arm.default": True,
            f"{prefix}.hand.type": "GripperCommand",
            f"{prefix}.hand.action_ns": "gripper_cmd",
            f"{prefix}.hand.joints": ["f", "g"],
            f"{prefix}.hand.command_joint": "g",
            f"{prefix}.hand.max_effort": 7.0,
            f"{prefix}.odd.type": "Wheel",
        }
    )
    arm, hand = configured_controllers(node)  # type: ignore[arg-type]
    assert (arm.action, arm.joints, arm.is_default) == (
        "arm/follow_joint_trajectory",
        ("a", "b"),
        True,
    )
    assert (hand.kind, hand.joints, hand.max_effort) == (ActionKind.GRIPPER, ("g", "f"), 7.0)
    assert "Controller 'odd'" in node.log.lines[0]
