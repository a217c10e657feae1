"""A session is what a bag has of a simulation from its start on."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from teleopctl.bag import BagWriter, open_bag
from teleopctl.bag.verify.session import end_of_run_ns, read_commands, read_session, read_topics
from teleopctl.errors import InvalidFileError
from tests.bag.bags import LATCHED, message, topic

JOINT_STATE = "sensor_msgs/msg/JointState"
STATES, COMMANDS = "/robot_joint_states", "/robot_joint_commands"
PERIOD_NS = 10_000_000


def write(folder, states_ns, commands_ns=(), description="<robot/>", namespace=""):
    described = f"{namespace}/robot_description"
    with BagWriter(folder) as writer:
        writer.add_topic(topic(described, qos=LATCHED))
        for name in (STATES, COMMANDS):
            writer.add_topic(topic(name, JOINT_STATE))
        if description:
            writer.write(message(described, 0, data=description))
        for name, times_ns in ((STATES, states_ns), (COMMANDS, commands_ns)):
            for number, time_ns in enumerate(times_ns):
                stamp = Time(sec=time_ns // 10**9, nanosec=time_ns % 10**9)
                fields = {"header": Header(stamp=stamp), "name": ["a"], "position": [1.0 * number]}
                writer.write(message(name, number + 1, JOINT_STATE, **fields))
    return open_bag(folder)


def end_of(bag):
    return end_of_run_ns(read_topics(bag, {STATES, COMMANDS}).values())


def test_commands_are_found_by_the_states_that_they_answer(tmp_path):
    times_ns = [number * PERIOD_NS for number in range(5)]
    with write(tmp_path / "bag", times_ns, [*times_ns[:4], times_ns[3], 0]) as bag:
        commands = read_commands(read_topics(bag, {COMMANDS})[COMMANDS], PERIOD_NS)
        assert read_session(bag).robot_description == "<robot/>"
        assert end_of(bag) == 4 * PERIOD_NS
    # Of two answers the first counts.
    assert {t: c.position[0] for t, c in commands.by_time.items()} == {
        times_ns[number]: float(number) for number in range(4)
    }
    assert (commands.unstamped, list(commands.late_ns)) == (1, [])


def test_a_command_that_came_when_the_simulator_had_gone_on_was_not_taken(tmp_path):
    times_ns = [number * PERIOD_NS for number in range(5)]
    with write(tmp_path / "bag", times_ns, times_ns) as bag:
        topics = read_topics(bag, {STATES, COMMANDS})
    commands, states = topics[COMMANDS], topics[STATES].messages
    late = [
        each._replace(publish_time_ns=states[4].publish_time_ns)
        if each.time_ns == times_ns[2]
        else each
        for each in commands.messages
    ]
    found = read_commands(commands._replace(messages=late), PERIOD_NS, states)
    assert list(found.by_time) == [times_ns[0], times_ns[1], times_ns[3], times_ns[4]]
    assert list(found.late_ns) == [times_ns[2]]


@pytest.mark.parametrize(
    ("states_ns", "why"),
    [
        ([], "has no simulated run"),
        ([PERIOD_NS, 2 * PERIOD_NS], "begins at 0.010 s of simulated time: earlier events"),
        (
            [PERIOD_NS * number for number in (0, 1, 2, 3, 4, 0, 1, 2, 3)],
            "Simulated time jumps back from 0.040 s in the bag",
        ),
    ],
)
def test_what_is_no_whole_run_is_refused(tmp_path, states_ns, why):
    with write(tmp_path / "bag", states_ns) as bag, pytest.raises(InvalidFileError, match=why):
        end_of(bag)


def test_a_stamp_of_another_age_makes_no_run_of_years(tmp_path):
    with write(tmp_path / "bag", [0, PERIOD_NS, 10**9 * 10**9, 2 * PERIOD_NS]) as bag:
        assert end_of(bag) == 2 * PERIOD_NS


def test_a_robot_in_a_namespace_is_found(tmp_path):
    with write(tmp_path / "bag", [0, PERIOD_NS], namespace="/left") as bag:
        assert read_session(bag).robot_description == "<robot/>"


def test_a_bag_without_a_robot_is_refused(tmp_path):
    with (
        write(tmp_path / "bag", [0, PERIOD_NS], description="") as bag,
        pytest.raises(InvalidFileError, match="no robot description"),
    ):
        read_session(bag)
