"""Forward kinematics against yourdfpy, an independent implementation."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joints import Joints
from teleopctl.robot.kinematics import SegmentTree
from teleopctl.tf.transforms import IDENTITY, matrix_from_quaternion
from tests.robot import independent

ODD_ROBOT = """
<robot name="odd">
  <link name="base"/> <link name="slider"/> <link name="wheel"/> <link name="tip"/>
  <link name="follower"/> <link name="tool"/>
  <joint name="slide" type="prismatic">
    <origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/>
    <parent link="base"/> <child link="slider"/> <axis xyz="0.6 0 -0.8"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="turn" type="continuous">
    <origin xyz="0 0.5 0" rpy="-1.2 0.1 2.5"/>
    <parent link="slider"/> <child link="wheel"/> <axis xyz="0.3 0.4 -0.5"/>
  </joint>
  <joint name="bend" type="revolute">
    <origin xyz="1 0 0" rpy="0 1.5 0"/>
    <parent link="wheel"/> <child link="tip"/> <axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="follow" type="revolute">
    <parent link="wheel"/> <child link="follower"/> <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
    <mimic joint="bend" multiplier="-0.5" offset="0.25"/>
  </joint>
  <joint name="weld" type="fixed">
    <origin rpy="3 0 -1"/> <parent link="tip"/> <child link="tool"/>
  </joint>
</robot>
"""

angles = st.floats(-math.pi, math.pi)


@pytest.fixture(scope="module")
def odd():
    return RobotDescription.from_urdf(ODD_ROBOT), independent.read(ODD_ROBOT)


@pytest.fixture(scope="module")
def teleop_twice(teleop, teleop_urdf):
    return teleop, independent.read(teleop_urdf)


def segments(description):
    return SegmentTree(description, Joints.of(description))


def link_frames(description, positions):
    """Each link's frame in the root's, by the segments from there to it."""
    tree = segments(description)
    steps = {segment.joint.child: segment.origin for segment in tree.fixed}
    steps.update((joint.child, step) for joint, step in tree.transforms(positions))
    frames = {description.root: IDENTITY}
    for joint in description.tree:
        frames[joint.child] = frames[joint.parent] @ steps[joint.child]
    return frames


def assert_same(description, other, positions):
    other.update_cfg(positions)
    for link, frame in link_frames(description, positions).items():
        expected = other.get_transform(link)
        np.testing.assert_allclose(frame.translation, expected[:3, 3], atol=1e-6, err_msg=link)
        rows = matrix_from_quaternion(frame.rotation)
        np.testing.assert_allclose(rows, expected[:3, :3], atol=1e-6, err_msg=link)


@given(st.tuples(angles, angles, angles, angles))
def test_the_teleop_arm_stands_where_an_independent_implementation_puts_it(teleop_twice, values):
    names = ("joint_1", "joint_2", "joint_3", "joint_4")
    description, other = teleop_twice
    assert_same(description, other, dict(zip(names, values, strict=True)))


@given(st.floats(-1, 1), angles, angles)
def test_every_kind_of_joint_stands_where_an_independent_implementation_puts_it(
    odd, slide, turn, bend
):
    description, other = odd
    assert_same(description, other, {"slide": slide, "turn": turn, "bend": bend})


def moved(tree, positions):
    return {joint.name for joint, _ in tree.transforms(positions)}


def test_joints_that_follow_move_with_the_joint_that_they_follow(teleop):
    tree = segments(teleop)
    assert moved(tree, {"joint_4": -1.0}) == {"joint_4", "joint_5"}
    assert moved(tree, {"joint_1": 1.0}) == {"joint_1"}
    assert moved(tree, {"wheel_of_another_robot": 1.0}) == set()


def test_segments_are_named_in_alphabetical_order(teleop):
    names = segments(teleop).names
    assert names == sorted(names)
    assert len(names) == 9
