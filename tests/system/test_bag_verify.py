"""A recorded session is run once more, and all that the run determines is compared to the bit."""

from __future__ import annotations

import json
import re
from collections import defaultdict

import pytest
from control_msgs.msg import DynamicJointState
from mujoco_ros2_control_msgs.msg import FreeJointStateArray
from rcl_interfaces.msg import Log
from ros_gz_interfaces.msg import Contacts
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from tf2_msgs.msg import TFMessage

from teleopctl.bag import BagWriter, DifferenceKind, open_bag
from teleopctl.interfaces import deserialize, get_message, serialize
from teleopctl.nodes.bag_verification.verification import verify_bag
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

    # Some commands come while nothing moves; a test takes one of them out.
    ros.wait_for_message(Clock, "/clock", lambda time: time.clock.sec >= 1)
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
    assert len(printed) >= 4, output
    with open_bag(session) as bag:
        said = [deserialize(m.data, Log).msg for m in bag.messages(["/rosout"])]
    # The recorder logs its own first line before it subscribes: that line comes from what /rosout
    # keeps, and is not there each time on a busy machine.
    printed.pop("recorder")
    for process, texts in printed.items():
        assert texts[0] in said, f"{process}: {texts[0]}"
    done = shared_ros.run(["bag", "check", str(session)])
    assert (done.returncode, done.stdout) == (0, f"{session}: nothing is wrong\n")


def test_a_session_is_simulated_once_more_to_the_bit(
    shared_ros, recorded, ros_bag_repeats, tmp_path
):
    ros, (session, _) = shared_ros, recorded
    with open_bag(session) as bag:
        records = dict(bag.records())
        assert bag.remarks == []
    assert records["teleopctl.launch"]["argument.camera"] == "false"
    done = ros.run(["bag", "verify", str(session)])
    assert (done.returncode, done.stderr) == (0, "")
    first, *lines = done.stdout.splitlines()
    assert re.fullmatch(
        r"\d+ messages on 10 topics compared, up to \d+\.\d{3} s: the same bits\.", first
    )
    for topic in COMPARED:
        assert any(line.startswith(f"  {topic}") and "messages" in line for line in lines), topic
    assert any(re.match("  .*/rosout.*: depends on wall time$", line) for line in lines)
    assert ros_bag_repeats(session).verdict.messages > 100

    changed = rewritten(session, tmp_path, "command", a_command_changed)
    done = ros.run(["bag", "verify", str(changed), "-o", "difference.svg"])
    assert done.returncode == 1
    assert re.search(r"First differences:\n  /\S+ \d+\.\d{3} s: \S+ was", done.stdout)
    assert ros.run(["bag", "verify", str(changed), "--tolerance", "1.0"]).returncode == 0
    drawn = (ros.folder / "difference.svg").read_text(encoding="utf-8")
    assert re.search(r'id="/\S+ \S+, recorded"', drawn)

    with pytest.raises(AssertionError, match=r"first differences:\n  /\S+ "):
        ros_bag_repeats(changed)

    document = json.loads(ros.run(["bag", "verify", str(changed), "--json"]).stdout)
    assert document["same"] is False
    assert document["first"][0]["topic"].startswith("/")


@pytest.mark.nightly
def test_what_is_otherwise_in_any_topic_is_found_with_its_time_and_both_values(recorded, tmp_path):
    session, _ = recorded
    for kind, change in (
        (DifferenceKind.VALUE, values_changed),
        (DifferenceKind.MISSING, one_taken_out),
        (DifferenceKind.EXTRA, one_put_in_twice),
        (DifferenceKind.ORDER, two_swapped),
    ):
        changed = rewritten(session, tmp_path, kind.value, change)
        found = verify_bag(changed).verdict
        differences = {each.name: each.differences for each in found.streams}
        assert {name.split()[0] for name, each in differences.items() if each} == {*COMPARED} | (
            set() if kind is DifferenceKind.VALUE else {COMMANDS}
        )
        for name in filter(differences.get, differences):
            # A clock has nothing but its time.
            is_time = kind is DifferenceKind.VALUE and name == "/clock"
            kinds = {DifferenceKind.MISSING, DifferenceKind.EXTRA} if is_time else {kind}
            assert {each.kind for each in differences[name]} == kinds, name
            assert differences[name][0].time_ns > 0
        if kind is DifferenceKind.VALUE:
            (position,) = differences["/joint_states"]
            assert position.field == "position[joint_1]"
            assert position.size == pytest.approx(0.1)


@pytest.mark.nightly
def test_a_bag_without_the_states_that_controllers_answer_is_compared_by_the_others(
    recorded, tmp_path
):
    session, _ = recorded
    other = rewritten(
        session, tmp_path, "no_states", lambda ms: [m for m in ms if m.topic != STATES]
    )
    found = verify_bag(other).verdict
    # The topic stands in the bag: that nothing came on it is a loss.
    assert [(each.topic, each.kind) for each in found.first_differences] == [
        (STATES, DifferenceKind.MISSING)
    ]
    without = rewritten(
        session, tmp_path, "bare", lambda ms: [m for m in ms if m.topic != STATES], {STATES}
    )
    found = verify_bag(without).verdict
    assert found.is_same
    assert found.not_compared[STATES] == "was not recorded"
    changed = rewritten(without, tmp_path, "changed", joint_states_changed)
    (difference,) = verify_bag(changed).verdict.first_differences
    assert (difference.topic, difference.field) == ("/joint_states", "position[joint_1]")


@pytest.mark.nightly
@pytest.mark.timeout(120)
def test_sensors_and_what_moves_freely_are_compared(ros, tmp_path):
    (tmp_path / "arm.urdf").write_text(TOUCHING_ARM)
    (tmp_path / "world.yaml").write_text(THINGS)
    arm = ros.launch(
        *("sim.yaml", f"model:={tmp_path}/arm.urdf", f"world:={tmp_path}/world.yaml"),
        *("real_time_factor:=0", "record:=session"),
    )
    ros.wait_for_message(Contacts, "/touch", lambda message: len(message.contacts) > 0)
    arm.stop()
    found = verify_bag(ros.folder / "session").verdict
    assert found.is_same, found.first_differences
    compared = {each.topic: each.compared for each in found.streams}
    assert min(compared[t] for t in ("/touch", "/imu", "/tf", "/joint_states", FREE)) > 3


COMMANDS, STATES = "/robot_joint_commands", "/robot_joint_states"
FREE = "/mujoco_sim/free_joint_states"
COMPARED = [
    *("/clock", "/joint_states", "/dynamic_joint_states", STATES, FREE),
    *("/mujoco_sim/joint_states", "/mujoco_sim/contacts", "/tf"),
]
"""Topics of the arm's launch that have a time and are determined by the run."""

TOUCHING_ARM = """<robot name="arm">
  <link name="world"/>
  <joint name="foot" type="fixed"><parent link="world"/><child link="base"/></joint>
  <link name="base"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="5"/></joint>
  <link name="arm">
    <collision><origin xyz="0.3 0 0"/><geometry><box size="0.6 0.1 0.05"/></geometry></collision>
    <inertial><origin xyz="0.3 0 0"/><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <gazebo reference="arm">
    <sensor name="touch" type="contact"><update_rate>50</update_rate><topic>touch</topic>
      <contact><collision>arm_collision</collision></contact></sensor>
    <sensor name="imu" type="imu"><update_rate>30</update_rate><topic>imu</topic>
      <imu><angular_velocity><x><noise type="gaussian"><stddev>0.01</stddev></noise></x>
      </angular_velocity></imu></sensor>
  </gazebo>
  <ros2_control name="arm" type="system">
    <hardware><plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>
    <joint name="j1"><command_interface name="position"/>
      <state_interface name="position"/><state_interface name="velocity"/></joint>
  </ros2_control>
</robot>"""
THINGS = """things:
  cube: {shape: box, size: [0.1, 0.1, 0.1], at: [0.35, 0, 0.5], mass: 0.1}
  ball: {shape: sphere, radius: 0.1, at: [2, 0, 1.2], mass: 0.5, bounce: 0.5}
"""


# --- bags that are otherwise ----------------------------------------------------------------


def rewritten(session, folder, name, change, left_out=frozenset()):
    """Write a bag with other messages, and without some topics."""
    folder = folder / name
    with open_bag(session) as bag, BagWriter(folder) as writer:
        for topic, _ in bag.metadata.topics:
            if topic.name not in left_out:
                writer.add_topic(topic)
        for attachment in bag.attachments():
            writer.attach(attachment)
        for message in change(list(bag.messages())):
            writer.write(message)
    return folder


def middle(messages, topic):
    """Where in the bag a message of a topic stands, and the one before it, not at its ends."""
    places = [index for index, message in enumerate(messages) if message.topic == topic]
    if topic == "/tf":
        # The frames of the joints, not of the cube.
        places = [index for index in places if b"gripper_left" in messages[index].data]
    if topic == COMMANDS:
        # While controllers hold the robot still: what lacks a command in a motion, or the first one
        # of a controller, goes on otherwise, and rightly so.
        sent = [deserialize(messages[place].data, JointState) for place in places]
        held = [(list(each.name), list(each.position)) for each in sent]
        at = next(
            k
            for k in range(1, len(held) - 1)
            if held[k][0] and held[k - 1] == held[k] == held[k + 1]
        )
        return places[at], places[at - 1]
    return places[len(places) // 2], places[len(places) // 2 - 1]


def values_changed(messages):
    for topic in COMPARED:
        index, _ = middle(messages, topic)
        change_a_number(messages, index)
    return messages


def joint_states_changed(messages):
    change_a_number(messages, middle(messages, "/joint_states")[0])
    return messages


def one_taken_out(messages):
    places = {middle(messages, topic)[0] for topic in (*COMPARED, COMMANDS)}
    return [message for index, message in enumerate(messages) if index not in places]


def one_put_in_twice(messages):
    places = {middle(messages, topic)[0] for topic in (*COMPARED, COMMANDS)}
    return [
        message
        for index, each in enumerate(messages)
        for message in ([each, each] if index in places else [each])
    ]


def two_swapped(messages):
    for topic in (*COMPARED, COMMANDS):
        one, other = middle(messages, topic)
        first, second = messages[one], messages[other]
        messages[one] = second._replace(log_time_ns=first.log_time_ns)
        messages[other] = first._replace(log_time_ns=second.log_time_ns)
    return messages


def a_command_changed(messages):
    moving = [
        index
        for index, each in enumerate(messages)
        if each.topic == COMMANDS and deserialize(each.data, JointState).position
    ]
    change_a_number(messages, moving[len(moving) // 2], 1e-6)
    return messages


def change_a_number(messages, index, by=0.1):
    """Add to the first real number of a message; a time of the clock is a nanosecond later."""
    message = deserialize(messages[index].data, get_message(TYPES[messages[index].topic]))
    if isinstance(message, Clock):
        message.clock.nanosec += 1
    elif isinstance(message, JointState):
        message.position = [message.position[0] + by, *message.position[1:]]
    elif isinstance(message, DynamicJointState):
        message.interface_values[0].values = [message.interface_values[0].values[0] + by]
    elif isinstance(message, Contacts):
        message.contacts[0].depths[0] += by
    elif isinstance(message, FreeJointStateArray):
        message.free_joints[0].pose.pose.position.x += by
    else:
        message.transforms[0].transform.translation.x += by
    messages[index] = messages[index]._replace(data=bytes(serialize(message)))


TYPES = {
    "/clock": Clock.TYPE_NAME,
    "/tf": TFMessage.TYPE_NAME,
    "/dynamic_joint_states": DynamicJointState.TYPE_NAME,
    "/mujoco_sim/contacts": Contacts.TYPE_NAME,
    FREE: FreeJointStateArray.TYPE_NAME,
    **dict.fromkeys(
        ("/joint_states", STATES, COMMANDS, "/mujoco_sim/joint_states"), JointState.TYPE_NAME
    ),
}
