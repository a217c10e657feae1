"""Joint states to serialized transforms: the same bytes as by messages, without them."""

import math

import pytest
from hypothesis import given, strategies

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import deserialize, get_message, serialize, set_stamp
from teleopctl.nodes.robot_state_publisher import JointStateReader, JointTransforms
from teleopctl.robot import Joints, RobotDescription, SegmentTree

JointState = get_message("sensor_msgs/msg/JointState")
TFMessage = get_message("tf2_msgs/msg/TFMessage")

LINKS = "".join(f'<link name="{name}"/>' for name in ("base", "arm", "finger", "thumb", "slide"))
ROBOT = f"""<robot name="r">{LINKS}
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 1"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="grip" type="revolute"><parent link="arm"/><child link="finger"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="follow" type="revolute"><parent link="arm"/><child link="thumb"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
    <mimic joint="grip" multiplier="-1" offset="0.1"/></joint>
  <joint name="push" type="prismatic"><parent link="base"/><child link="slide"/>
    <origin xyz="0 0 1" rpy="0.5 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"""
NUMBERS = strategies.floats(-10.0, 10.0)
JOINTS = ("turn", "grip", "follow", "push", "no_such_joint")


@pytest.fixture(scope="module")
def transforms() -> JointTransforms:
    description = RobotDescription.from_urdf(ROBOT)
    return JointTransforms(SegmentTree(description, Joints.of(description)), "left/")


def state(names, positions, stamp_ns=0, frame="", **others):
    message = JointState(name=list(names), position=list(positions), **others)
    message.header.frame_id = frame
    set_stamp(message.header.stamp, stamp_ns)
    return bytes(serialize(message))


@given(
    names=strategies.lists(strategies.sampled_from(JOINTS), min_size=1, unique=True),
    data=strategies.data(),
)
def test_the_bytes_are_those_of_a_message_with_the_same_transforms(transforms, names, data):
    prepared = transforms.prepared(names)
    for stamp_ns in (1, 3_000_000_005):
        positions = [data.draw(NUMBERS) for _ in names]
        by_messages = transforms.moving(names, positions, stamp_ns)
        expected = bytes(serialize(TFMessage(transforms=by_messages))) if by_messages else b""
        assert bytes(prepared.serialized(positions, stamp_ns)) == expected


def test_a_mimic_joint_follows_unless_its_position_is_given(transforms):
    def angles(names):
        data = bytes(transforms.prepared(names).serialized([0.5] * len(names), 1))
        return {
            each.child_frame_id: 2
            * math.atan2(each.transform.rotation.z, each.transform.rotation.w)
            for each in deserialize(data, TFMessage).transforms
        }

    assert angles(["grip"]) == pytest.approx({"left/finger": 0.5, "left/thumb": -0.4})
    assert angles(["grip", "follow"]) == pytest.approx({"left/finger": 0.5, "left/thumb": 0.5})


@given(
    states=strategies.lists(
        strategies.tuples(
            strategies.sampled_from([("a",), ("a", "bc"), ("a", "bd"), ("x", "y", "z")]),
            strategies.integers(-(2**31), 2**31 - 1),
            strategies.sampled_from(["", "base"]),
            strategies.booleans(),
        ),
        min_size=1,
        max_size=6,
    )
)
def test_joint_states_are_read_as_their_messages_have_them(states):
    reader = JointStateReader()
    last = None
    for number, (names, second, frame, has_velocities) in enumerate(states):
        positions = [number + place / 3 for place in range(len(names))]
        others = {"velocity": [0.0] * len(names)} if has_velocities else {}
        reader.read(state(names, positions, second * 1_000_000_000 + 7, frame, **others))
        assert (tuple(reader.names), list(reader.positions)) == (names, positions)
        assert reader.stamp_ns == second * 1_000_000_000 + 7
        assert reader.has_same_names is ((names, frame) == last)
        last = (names, frame)


def test_a_joint_state_in_big_endian_is_read_too():
    little = state(["a"], [1.5], 3_000_000_001)
    numbers = (3, 1, 1, 0, 1, 2)
    big = (
        bytes(4)
        + b"".join(number.to_bytes(4, "big") for number in numbers)
        + b"a\0\0\0"
        + (1).to_bytes(4, "big")
        + b"\x3f\xf8\0\0\0\0\0\0"
        + bytes(8)
    )
    reader = JointStateReader()
    for payload in (little, big, big, little):
        reader.read(payload)
        assert (reader.names, list(reader.positions)) == (["a"], [1.5])
        assert reader.stamp_ns == 3_000_000_001


def test_a_joint_state_that_is_cut_off_is_refused_and_the_next_one_is_read():
    reader = JointStateReader()
    whole = state(["a", "b"], [1.0, 2.0])
    reader.read(whole)
    with pytest.raises(TeleopctlError):
        reader.read(whole[:40])
    reader.read(whole)
    assert list(reader.positions) == [1.0, 2.0]


def test_a_joint_state_with_more_names_than_positions_is_never_taken_for_a_known_one():
    reader = JointStateReader()
    for _ in range(2):
        reader.read(state(["a", "b"], [1.0]))
        assert not reader.has_same_names
