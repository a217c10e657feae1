"""A recorded session is simulated once more and compared, to the bit."""

from __future__ import annotations

import json
import re

import pytest
from mujoco_ros2_control_msgs.srv import SetPause
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

from teleopctl.bag import BagAttachment, BagMessage, BagWriter, open_bag
from teleopctl.interfaces import deserialize, serialize
from teleopctl.node import qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.testing import LONGEST_WAIT_S
from tests.bag.bags import LATCHED, START_NS, topic

TYPES = {
    "/robot_description": "std_msgs/msg/String",
    "/robot_joint_states": "sensor_msgs/msg/JointState",
    "/robot_joint_commands": "sensor_msgs/msg/JointState",
}
TOPICS = {
    "/robot_description": String,
    "/robot_joint_states": JointState,
    "/robot_joint_commands": JointState,
}


def call_pause(node, paused):
    client = node.create_client(SetPause, "/mujoco_sim/set_pause")
    assert client.wait_for_service(timeout_sec=LONGEST_WAIT_S)
    answer = client.call_async(SetPause.Request(paused=paused)).wait_for_response(LONGEST_WAIT_S)
    assert answer.success, answer.message


@pytest.fixture
def session(ros, tmp_path):
    """A bag of the arm from its first state on: controllers come, and the gripper is commanded."""
    ros.launch("sim.yaml", "camera:=false", "paused:=true", "start_controllers:=false")
    messages: list[BagMessage] = []

    def listener(name):
        def receive(data: bytes) -> None:
            messages.append(BagMessage(name, START_NS + len(messages), START_NS, data))

        return receive

    for name, type_ in TOPICS.items():
        qos = qos_profile_latched if type_ is String else 1000
        ros.node.create_subscription(type_, name, listener(name), qos, raw=True, immediate=True)
    call_pause(ros.node, paused=False)
    ros.launch("controller.yaml")
    publisher = ros.node.create_publisher(Float64MultiArray, "/gripper_controller/commands", 10)
    assert ros.node.wait_for_subscribers(publisher.topic_name, 1, LONGEST_WAIT_S)
    publisher.publish(Float64MultiArray(data=[-0.8]))

    def is_open(state):
        return dict(zip(state.name, state.position, strict=True))["joint_4"] < -0.75

    ros.wait_for_message(JointState, "/joint_states", is_open)
    call_pause(ros.node, paused=True)
    with BagWriter(tmp_path / "session") as writer:
        for name, type_ in TOPICS.items():
            writer.add_topic(topic(name, TYPES[name], LATCHED if type_ is String else None))
        writer.attach(parameters())
        for message in sorted(messages):
            writer.write(message)
    return tmp_path / "session"


def parameters():
    table = package_share("teleopctl") / "worlds" / "table.urdf"
    text = json.dumps({"/mujoco_sim": {"ros__parameters": {"world": str(table), "timestep": 1e-3}}})
    return BagAttachment("parameters.yaml", "application/yaml", text.encode())


def test_a_session_is_simulated_once_more_to_the_bit(ros, session):
    done = ros.run(["bag", "verify", str(session)])
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(
        r"\d{2,} states compared, up to \d+\.\d{3} s: the same bits\.\n", done.stdout
    )

    with open_bag(session) as bag:
        changed = changed_a_little(bag, session.with_name("changed"))
    done = ros.run(["bag", "verify", str(changed)])
    assert done.returncode == 1
    assert re.search(r"First difference:\n  \d+\.\d{3} s: joint_\d \w+ was", done.stdout)
    assert ros.run(["bag", "verify", str(changed), "--tolerance", "0.1"]).returncode == 0

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
