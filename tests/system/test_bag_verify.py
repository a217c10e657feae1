"""A recorded session is simulated once more and compared, to the bit."""

from __future__ import annotations

import json
import re
from collections import defaultdict

import pytest
from rcl_interfaces.msg import Log
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from teleopctl.bag import BagWriter, open_bag
from teleopctl.interfaces import deserialize, serialize
from teleopctl.testing import LONGEST_WAIT_S


@pytest.fixture(scope="module")
def recorded(shared_ros):
    """A launch that is recorded from its first message on, in which the gripper is commanded.

    Its bag, and what the launch printed.
    """
    ros = shared_ros
    arm = ros.launch("sim.yaml", "camera:=false", "record:=session")
    assert "recorder" in ros.run("ps").stdout
    publisher = ros.node.create_publisher(Float64MultiArray, "/gripper_controller/commands", 10)
    assert ros.node.wait_for_subscribers(publisher.topic_name, 1, LONGEST_WAIT_S)

    def joint_4(state):
        return dict(zip(state.name, state.position, strict=True))["joint_4"]

    publisher.publish(Float64MultiArray(data=[-0.8]))
    ros.wait_for_message(JointState, "/joint_states", lambda state: joint_4(state) < -0.75)
    publisher.publish(Float64MultiArray(data=[0.0]))
    ros.wait_for_message(JointState, "/joint_states", lambda state: joint_4(state) > -0.05)
    arm.stop()
    return ros.folder / "session", arm.output


def test_a_recorded_launch_has_the_first_line_of_every_node_and_check_misses_nothing(
    shared_ros, recorded
):
    session, output = recorded
    printed = defaultdict(list)
    for process, text in re.findall(r"^\[(\S+)\] \[INFO\] \[[\d.]+\] \[\S+\]: (.*)$", output, re.M):
        printed[process].append(text)
    assert len(printed) >= 5, output
    with open_bag(session) as bag:
        said = [deserialize(m.data, Log).msg for m in bag.messages(["/rosout"])]
    for process, texts in printed.items():
        assert texts[0] in said, f"{process}: {texts[0]}"
    done = shared_ros.run(["bag", "check", str(session)])
    assert (done.returncode, done.stdout) == (0, f"{session}: nothing is wrong\n")


def test_a_session_is_simulated_once_more_to_the_bit(shared_ros, recorded, ros_bag_repeats):
    ros, (session, _) = shared_ros, recorded
    with open_bag(session) as bag:
        recorded = dict(bag.records())
        assert bag.remarks == []
    assert recorded["teleopctl.launch"]["argument.camera"] == "false"
    done = ros.run(["bag", "verify", str(session)])
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(r"\d+ states compared, up to \d+\.\d{3} s: the same bits\.\n", done.stdout)

    with open_bag(session) as bag:
        changed = changed_a_little(bag, session.with_name("changed"))
    done = ros.run(["bag", "verify", str(changed)])
    assert done.returncode == 1
    assert re.search(r"First difference:\n  \d+\.\d{3} s: joint_\d \w+ was", done.stdout)
    assert ros.run(["bag", "verify", str(changed), "--tolerance", "0.1"]).returncode == 0

    done = ros.run(["bag", "verify", str(changed), "-o", "difference.svg"])
    assert done.returncode == 1
    drawn = (ros.folder / "difference.svg").read_text(encoding="utf-8")
    assert re.search(r'id="joint_\d \w+, recorded"', drawn)

    assert ros_bag_repeats(session).verdict.states > 3
    with pytest.raises(AssertionError, match=r"first difference:\n  .* joint_"):
        ros_bag_repeats(changed)

    document = json.loads(ros.run(["bag", "verify", str(changed), "--json"]).stdout)
    assert document["same"] is False
    assert document["first"][0]["joint"].startswith("joint_")


def changed_a_little(bag, folder):
    """Write the bag with one command that is another one."""
    commands = [
        (m, deserialize(m.data, JointState)) for m in bag.messages(["/robot_joint_commands"])
    ]
    moving, message = [(m, command) for m, command in commands if len(command.position)][-3]
    message.position = [position + 1e-6 for position in message.position]
    with BagWriter(folder) as writer:
        for topic_, _ in bag.metadata.topics:
            writer.add_topic(topic_)
        for attachment in bag.attachments():
            writer.attach(attachment)
        for each in bag.messages():
            data = bytes(serialize(message)) if each == moving else each.data
            writer.write(each._replace(data=data))
    return folder
