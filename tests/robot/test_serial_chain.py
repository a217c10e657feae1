"""Serial chains: poses against the tree of segments, Jacobians against differences of poses."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joints import Joints
from teleopctl.robot.kinematics import SegmentTree
from teleopctl.robot.serial_chain import SerialChain
from teleopctl.tf.transforms import conjugate, multiply


def chain_robot(joints, *, extra=""):
    """A robot whose link ``l0`` is 0.5 m above ``root``, and whose joints follow each other."""
    links = "".join(f'<link name="l{number}"/>' for number in range(len(joints) + 1))
    tags = "".join(
        f'<joint name="j{number}" type="{kind}"><parent link="l{number}"/>'
        f'<child link="l{number + 1}"/><origin xyz="0.3 {number / 10} 0.1" rpy="0.2 {number} 0.1"/>'
        f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        for number, (kind, axis) in enumerate(joints)
    )
    return RobotDescription.from_urdf(
        f'<robot name="chain"><link name="root"/>{links}<joint name="stand" type="fixed">'
        '<parent link="root"/><child link="l0"/><origin xyz="0 0 0.5" rpy="0 0 1.5"/></joint>'
        f"{tags}{extra}</robot>"
    )


MIXED = [
    ("revolute", "0 0 1"),
    ("prismatic", "0 1 0"),
    ("fixed", "1 0 0"),
    ("continuous", "0.6 0 0.8"),
]
HAND = (
    '<link name="eye"/><joint name="mount" type="fixed"><parent link="l2"/><child link="eye"/>'
    '<origin xyz="0 0.2 0" rpy="1 0 0"/></joint><link name="flap"/>'
    '<joint name="hinge" type="continuous"><parent link="l1"/><child link="flap"/></joint>'
)


def pose_in(chain, frame, positions):
    return chain.joint_poses(positions)[frame.joints] @ frame.offset


@pytest.mark.parametrize("link", ["l0", "l2", "l4", "eye", "root"])
def test_links_of_a_chain_are_where_the_tree_has_them(link):
    robot = chain_robot(MIXED, extra=HAND)
    chain = SerialChain(robot, "l0", "l4")
    assert chain.joints == ("j0", "j1", "j3")
    positions = (0.3, -0.7, 1.1)
    names = dict(zip(chain.joints, positions, strict=True))
    segments = SegmentTree(robot, Joints.of(robot))
    tree = segments.link_poses(names)
    assert segments.link_pose(link, names) == tree[link]
    expected = tree["l0"].inverse() @ tree[link]
    found = pose_in(chain, chain.frame(link), positions)
    assert found.translation == pytest.approx(expected.translation)
    assert found.rotation == pytest.approx(expected.rotation)


@given(positions=st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_the_jacobian_is_the_derivative_of_the_pose(positions):
    chain = SerialChain(chain_robot(MIXED, extra=HAND), "l0", "l4")
    for link in ("l4", "eye"):
        frame = chain.frame(link)
        columns = chain.jacobian(frame, chain.joint_poses(positions))
        here = pose_in(chain, frame, positions)
        for number, column in enumerate(columns):
            step = 1e-6
            moved = list(positions)
            moved[number] += step
            there = pose_in(chain, frame, moved)
            slide = [
                (b - a) / step for a, b in zip(here.translation, there.translation, strict=True)
            ]
            turn = multiply(there.rotation, conjugate(here.rotation))
            # For a small angle the vector of the quaternion is half the rotation.
            sign = 2.0 if turn[3] > 0.0 else -2.0
            rate = [sign * part / step for part in turn[:3]]
            assert column == pytest.approx((*slide, *rate), abs=1e-4)


@pytest.mark.parametrize(
    ("base", "tip", "text"),
    [
        ("l0", "nowhere", "The robot has no link 'nowhere'"),
        ("l1", "l0", "failed to find chain from robot root l1 to end effector l0"),
        ("l2", "flap", "failed to find chain from robot root l2 to end effector flap"),
    ],
)
def test_a_chain_goes_down_from_its_base(base, tip, text):
    with pytest.raises(InvalidDescriptionError, match=text):
        SerialChain(chain_robot(MIXED, extra=HAND), base, tip)


def test_a_frame_that_other_joints_move_is_refused():
    chain = SerialChain(chain_robot(MIXED, extra=HAND), "l0", "l4")
    with pytest.raises(InvalidDescriptionError, match="flap was not found in the robot chain"):
        chain.frame("flap")
    chain = SerialChain(chain_robot(MIXED, extra=HAND), "l1", "l4")
    with pytest.raises(InvalidDescriptionError, match="root was not found in the robot chain"):
        chain.frame("root")
