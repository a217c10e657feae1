"""Forward kinematics against yourdfpy, an independent implementation, and against itself."""

import io
import math

import numpy as np
import pytest
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.kinematics import joint_positions, joint_transform, link_transforms
from teleopctl.robot.segments import SegmentTree
from teleopctl.robot.urdf import Joint, Pose
from teleopctl.tf.transforms import matrix_from_quaternion

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


def independent(urdf):
    return yourdfpy.URDF.load(
        io.StringIO(urdf), load_meshes=False, build_collision_scene_graph=False
    )


@pytest.fixture(scope="module")
def odd():
    return RobotDescription.from_urdf(ODD_ROBOT), independent(ODD_ROBOT)


@pytest.fixture(scope="module")
def teleop_twice(teleop, teleop_urdf):
    return teleop, independent(teleop_urdf)


def assert_same(description, other, positions):
    other.update_cfg(positions)
    for link, frame in link_transforms(description, positions).items():
        np.testing.assert_allclose(frame, other.get_transform(link), atol=1e-6, err_msg=link)


@settings(deadline=None, max_examples=50)
@given(st.tuples(angles, angles, angles, angles))
def test_the_teleop_arm_stands_where_an_independent_implementation_puts_it(teleop_twice, values):
    names = ("joint_1", "joint_2", "joint_3", "joint_4")
    assert_same(*teleop_twice, dict(zip(names, values, strict=True)))


@settings(deadline=None, max_examples=50)
@given(st.floats(-1, 1), angles, angles)
def test_every_kind_of_joint_stands_where_an_independent_implementation_puts_it(
    odd, slide, turn, bend
):
    assert_same(*odd, {"slide": slide, "turn": turn, "bend": bend})


@settings(deadline=None, max_examples=50)
@given(st.floats(-1, 1), angles, angles)
def test_segments_in_plain_floats_agree_with_matrices(odd, slide, turn, bend):
    description, _ = odd
    tree = SegmentTree(description)
    positions = tree.with_mimics({"slide": slide, "turn": turn, "bend": bend})
    moving = tree.transforms(positions)
    assert {joint.name for joint, _ in moving} == {"slide", "turn", "bend", "follow"}
    for joint, transform in moving:
        expected = joint_transform(joint, positions[joint.name])
        np.testing.assert_allclose(transform.translation, expected[:3, 3], atol=1e-12)
        rows = matrix_from_quaternion(transform.rotation)
        np.testing.assert_allclose(rows, expected[:3, :3], atol=1e-12)


def test_mimic_joints_follow_and_unnamed_ones_stand_at_zero(odd):
    description, _ = odd
    assert joint_positions(description, {"bend": 1.0}) == {
        "slide": 0.0,
        "turn": 0.0,
        "bend": 1.0,
        "follow": -0.25,
    }


def test_a_measured_follower_is_believed_when_nothing_is_known_of_its_leader(odd):
    description, _ = odd
    assert joint_positions(description, {"follow": 0.7})["follow"] == 0.7


def test_a_measured_follower_keeps_its_position_in_a_state_message(teleop):
    tree = SegmentTree(teleop)
    assert tree.with_mimics({"joint_4": -1.0}) == {"joint_4": -1.0, "joint_5": 1.0}
    assert tree.with_mimics({"joint_4": -1.0, "joint_5": 0.9})["joint_5"] == 0.9
    assert tree.with_mimics({"joint_1": 1.0}) == {"joint_1": 1.0}


def test_segments_are_named_in_alphabetical_order(teleop):
    names = SegmentTree(teleop).names
    assert names == sorted(names)
    assert len(names) == 9


def test_a_fixed_joint_stands_at_its_origin_whatever_its_position():
    joint = Joint("weld", "fixed", "a", "b", Pose((1, 2, 3)))
    np.testing.assert_allclose(joint_transform(joint, 5.0)[:3, 3], (1, 2, 3))
