"""A session is what a bag has of a simulation from its first state on, without a gap."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from teleopctl.bag import BagWriter, open_bag
from teleopctl.bag.verify.session import read_session
from teleopctl.errors import InvalidFileError
from tests.bag.bags import LATCHED, message, topic

JOINT_STATE = "sensor_msgs/msg/JointState"
PERIOD_NS = 10_000_000


def write(folder, states_ns, commands_ns=(), description="<robot/>", namespace=""):
    described = f"{namespace}/robot_description"
    with BagWriter(folder) as writer:
        writer.add_topic(topic(described, qos=LATCHED))
        for name in ("/robot_joint_states", "/robot_joint_commands"):
            writer.add_topic(topic(name, JOINT_STATE))
        if description:
            writer.write(message(described, 0, data=description))
        for name, times_ns in (
            ("/robot_joint_states", states_ns),
            ("/robot_joint_commands", commands_ns),
        ):
            for number, time_ns in enumerate(times_ns):
                stamp = Time(sec=time_ns // 10**9, nanosec=time_ns % 10**9)
                fields = {"header": Header(stamp=stamp), "name": ["a"], "position": [1.0 * number]}
                writer.write(message(name, number + 1, JOINT_STATE, **fields))
    return open_bag(folder)


def test_states_and_their_answers_are_found_by_their_stamps(tmp_path):
    times_ns = [number * PERIOD_NS for number in range(5)]
    answers_ns = [*times_ns[1:4], times_ns[3], 77]
    with write(tmp_path / "bag", times_ns, answers_ns) as bag:
        session = read_session(bag)
    assert session.robot_description == "<robot/>"
    assert session.period_ns == PERIOD_NS
    assert list(session.states) == times_ns
    assert {time_ns: c.position[0] for time_ns, c in session.commands.items()} == {
        times_ns[1]: 0.0,
        times_ns[2]: 1.0,
        times_ns[3]: 2.0,  # the first answer counts
    }
    assert session.other_commands == 1


@pytest.mark.parametrize(
    ("states_ns", "why"),
    [
        ([], "has 0 messages on /robot_joint_states"),
        (
            [PERIOD_NS, 2 * PERIOD_NS],
            "begins at 0.010 s of simulated time: what had happened before",
        ),
        ([0, PERIOD_NS, 3 * PERIOD_NS], "lacks the state of 0.020 s on /robot_joint_states"),
        ([0, PERIOD_NS, 0], "has the time 0.000 s twice"),
    ],
)
def test_what_is_no_whole_session_is_told(tmp_path, states_ns, why):
    with write(tmp_path / "bag", states_ns) as bag, pytest.raises(InvalidFileError, match=why):
        read_session(bag)


def test_a_robot_in_a_namespace_is_found(tmp_path):
    with write(tmp_path / "bag", [0, PERIOD_NS], namespace="/left") as bag:
        assert read_session(bag).robot_description == "<robot/>"


def test_a_bag_without_a_robot_is_told(tmp_path):
    with (
        write(tmp_path / "bag", [0, PERIOD_NS], description="") as bag,
        pytest.raises(InvalidFileError, match="no robot description"),
    ):
        read_session(bag)
