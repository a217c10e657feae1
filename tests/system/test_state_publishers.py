"""``robot_state_publisher`` and ``joint_state_publisher`` as real processes."""

import queue
from typing import Any

import pytest
import yaml

from teleopctl.interfaces.store import get_message
from teleopctl.node import (
    Context,
    Node,
    QoSProfile,
    qos_profile_latched,
)
from teleopctl.packages import package_share
from teleopctl.robot.xacro.expansion import expand_xacro
from tests.robot.independent import link_frames

MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
WAIT_S = 20.0

STATES = "robot_state_publisher robot_state_publisher"
JOINTS = "joint_state_publisher joint_state_publisher"


@pytest.fixture(scope="module")
def urdf():
    return expand_xacro(MODEL)


@pytest.fixture
def observer(ros):
    """A node in this process, in the same graph as the processes."""
    context = Context()
    context.init([])
    node = Node("observer", context=context, enable_rosout=False, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.try_shutdown()


def listen(observer, kind, topic, qos=10):
    """A queue of the messages of a topic."""
    messages: queue.Queue[Any] = queue.Queue()
    observer.create_subscription(get_message(kind), topic, messages.put, qos, immediate=True)
    return messages


def parameter_file(ros, urdf, **more):
    path = ros.folder / "parameters.yaml"
    path.write_text(
        yaml.safe_dump({"/**": {"ros__parameters": {"robot_description": urdf, **more}}})
    )
    return path


def start_states(ros, urdf, **more):
    arguments = f"{STATES} --ros-args --params-file {parameter_file(ros, urdf, **more)}"
    process = ros.spawn_module("teleopctl.nodes", arguments)
    process.wait_for_line("Robot initialized")
    return process


def publish_joints(observer, positions, sec, nanosec=0):
    kind = get_message("sensor_msgs/msg/JointState")
    publisher = observer.create_publisher(kind, "joint_states", 10)
    assert observer.wait_for_subscribers("/joint_states", 1, WAIT_S)
    message = kind(name=list(positions), position=list(positions.values()))
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    publisher.publish(message)
    return publisher


def translations(message):
    return {t.child_frame_id: t.transform.translation for t in message.transforms}


def test_it_names_the_nine_segments_and_publishes_the_description_latched(ros, observer, urdf):
    process = start_states(ros, urdf)
    segments = [line for line in process.stderr.splitlines() if "got segment" in line]
    assert [line.split()[-1] for line in segments] == [
        "base_link",
        "base_plate",
        "claw_support",
        "forward_drive_arm",
        "gripper_left",
        "gripper_right",
        "horizontal_arm",
        "rgb_camera",
        "world",
    ]
    assert "[robot_state_publisher]: got segment base_link" in segments[0]
    late = listen(observer, "std_msgs/msg/String", "/robot_description", qos_profile_latched)
    assert late.get(timeout=WAIT_S).data == urdf
    process.interrupt()
    assert process.wait() == 0
    assert "Traceback" not in process.stderr


def test_what_stands_still_is_latched_on_tf_static(ros, observer, urdf):
    start_states(ros, urdf)
    late = listen(observer, "tf2_msgs/msg/TFMessage", "/tf_static", qos_profile_latched)
    message = late.get(timeout=WAIT_S)
    assert {(t.header.frame_id, t.child_frame_id) for t in message.transforms} == {
        ("world", "base_link"),
        ("horizontal_arm", "claw_support"),
        ("base_link", "rgb_camera"),
    }
    assert translations(message)["claw_support"].y == 0.82


def test_each_joint_state_becomes_transforms_with_its_stamp(ros, observer, urdf):
    start_states(ros, urdf)
    received = listen(observer, "tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100))
    publish_joints(observer, {"joint_1": 0.5, "joint_4": -1.0}, 7, 5)
    message = received.get(timeout=WAIT_S)
    assert {t.child_frame_id for t in message.transforms} == {
        "base_plate",
        "gripper_right",
        "gripper_left",
    }
    assert {(t.header.stamp.sec, t.header.stamp.nanosec) for t in message.transforms} == {(7, 5)}
    turns = {t.child_frame_id: t.transform.rotation.z for t in message.transforms}
    assert turns["gripper_left"] == pytest.approx(-turns["gripper_right"])


def test_a_joint_that_follows_a_follower_moves_with_the_first_joint(ros, observer):
    joints = "".join(
        f'<link name="{name}_link"/><joint name="{name}" type="prismatic"><parent link="base"/>'
        f'<child link="{name}_link"/><limit lower="-1" upper="1"/>{mimic}</joint>'
        for name, mimic in (
            ("c", '<mimic joint="b" multiplier="3"/>'),
            ("b", '<mimic joint="a" multiplier="-2" offset="0.5"/>'),
            ("a", ""),
        )
    )
    start_states(ros, f'<robot name="chain"><link name="base"/>{joints}</robot>')
    received = listen(observer, "tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100))
    publish_joints(observer, {"a": 0.125}, 1)
    moved = translations(received.get(timeout=WAIT_S))
    assert {link: place.x for link, place in moved.items()} == {
        "a_link": 0.125,
        "b_link": 0.25,
        "c_link": 0.75,
    }


def test_states_that_come_too_fast_are_thinned_to_the_publish_frequency(ros, observer, urdf):
    start_states(ros, urdf, publish_frequency=10.0)
    received = listen(observer, "tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100))
    publisher = publish_joints(observer, {"joint_1": 0.0}, 100)
    assert received.get(timeout=WAIT_S).transforms[0].header.stamp.nanosec == 0
    kind = get_message("sensor_msgs/msg/JointState")
    for milliseconds in (30, 90, 100, 150):
        message = kind(name=["joint_1"], position=[0.0])
        message.header.stamp.sec, message.header.stamp.nanosec = 100, milliseconds * 1_000_000
        publisher.publish(message)
    assert received.get(timeout=WAIT_S).transforms[0].header.stamp.nanosec == 100_000_000


def test_the_queue_of_states_is_a_parameter(ros, observer, urdf):
    name = "qos_overrides./joint_states.subscription.depth"
    start_states(ros, urdf, **{name: 100})
    publish_joints(observer, {}, 1)  # once it listens
    (states,) = observer.get_subscriptions_info_by_topic("/joint_states")
    assert states.qos_profile.depth == 100
    assert "100" in ros.run(["param", "get", "/robot_state_publisher", name]).stdout


def test_when_time_goes_back_transforms_come_again(ros, observer, urdf):
    process = start_states(ros, urdf)
    received = listen(observer, "tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100))
    publish_joints(observer, {"joint_1": 0.0}, 100)
    assert received.get(timeout=WAIT_S).transforms[0].header.stamp.sec == 100
    publish_joints(observer, {"joint_1": 0.0}, 1)
    assert received.get(timeout=WAIT_S).transforms[0].header.stamp.sec == 1
    process.wait_for_line("Moved backwards in time, re-publishing joint transforms!")


def test_frames_get_the_prefix(ros, observer, urdf):
    start_states(ros, urdf, frame_prefix="left/")
    late = listen(observer, "tf2_msgs/msg/TFMessage", "/tf_static", qos_profile_latched)
    names = {t.child_frame_id for t in late.get(timeout=WAIT_S).transforms}
    assert "left/base_link" in names


def test_a_prefix_that_is_set_later_holds_for_frames_that_have_moved(ros, observer, urdf):
    start_states(ros, urdf)
    received = listen(observer, "tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100))
    publisher = publish_joints(observer, {"joint_1": 0.5}, 1)
    first = received.get(timeout=WAIT_S).transforms[0]
    assert (first.header.frame_id, first.child_frame_id) == ("base_link", "base_plate")
    done = ros.run(["param", "set", "/robot_state_publisher", "frame_prefix", "left/"])
    assert done.returncode == 0, done.stderr
    message = publisher.msg_type(name=["joint_1"], position=[-0.5])
    message.header.stamp.sec = 2
    publisher.publish(message)
    moved = received.get(timeout=WAIT_S).transforms[0]
    assert (moved.header.frame_id, moved.child_frame_id) == ("left/base_link", "left/base_plate")
    assert (moved.header.stamp.sec, moved.transform.rotation.z) == (2, -first.transform.rotation.z)


def test_frames_of_a_new_description_stand_in_its_links(ros, observer):
    def robot(base):
        return (
            f"<robot name='r'><link name='{base}'/><link name='tip'/><joint name='j' "
            f"type='prismatic'><parent link='{base}'/><child link='tip'/>"
            "<limit lower='-1' upper='1'/></joint></robot>"
        )

    start_states(ros, robot("old"))
    received = listen(observer, "tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100))
    publisher = publish_joints(observer, {"j": 0.5}, 1)
    assert received.get(timeout=WAIT_S).transforms[0].header.frame_id == "old"
    done = ros.run(["param", "set", "/robot_state_publisher", "robot_description", robot("new")])
    assert done.returncode == 0, done.stderr
    message = publisher.msg_type(name=["j"], position=[0.5])
    message.header.stamp.sec = 2
    publisher.publish(message)
    assert received.get(timeout=WAIT_S).transforms[0].header.frame_id == "new"


def test_a_new_description_replaces_the_old_one_and_a_broken_one_is_refused(ros, observer, urdf):
    process = start_states(ros, urdf)
    refused = ros.run(["param", "set", "/robot_state_publisher", "robot_description", "<robot"])
    assert refused.returncode == 1
    assert "invalid URDF" in refused.stdout + refused.stderr
    late = listen(observer, "std_msgs/msg/String", "/robot_description", qos_profile_latched)
    assert late.get(timeout=WAIT_S).data == urdf
    small = "<robot name='small'><link name='only'/></robot>"
    done = ros.run(["param", "set", "/robot_state_publisher", "robot_description", small])
    assert done.returncode == 0, done.stderr
    process.wait_for_line("got segment only")
    assert late.get(timeout=WAIT_S).data == small


@pytest.mark.parametrize(
    ("urdf_text", "message"),
    [
        ("", "The robot_description parameter must not be empty"),
        ("<robot name='r'><link name='a'/><link name='b'/></robot>", "Two root links found"),
    ],
)
def test_without_a_robot_it_ends_with_one_message(ros, urdf_text, message):
    arguments = f"{STATES} --ros-args --params-file {parameter_file(ros, urdf_text)}"
    done = ros.run_module("teleopctl.nodes", arguments)
    assert done.returncode == 1
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_a_file_on_the_command_line_stands_for_the_parameter(ros):
    file = ros.folder / "two.urdf"
    file.write_text("<robot name='r'><link name='a'/><link name='b'/></robot>", encoding="utf-8")
    done = ros.run_module("teleopctl.nodes", f"{STATES} {file}")
    assert "Assuming argument is name of URDF file" in done.stderr
    assert "Two root links found" in done.stderr


def test_joint_states_come_from_the_description_on_the_topic(ros, observer, urdf):
    received = listen(observer, "sensor_msgs/msg/JointState", "/joint_states")
    joints = ros.spawn_module("teleopctl.nodes", JOINTS)
    joints.wait_for_line("Waiting for robot_description to be published")
    start_states(ros, urdf)
    state = received.get(timeout=WAIT_S)
    assert list(state.name) == [f"joint_{n}" for n in (1, 2, 3, 4, 5)]
    assert list(state.position) == [0.0] * 5
    assert (len(state.velocity), len(state.effort)) == (0, 0)
    assert state.header.stamp.sec > 0
    joints.interrupt()
    assert joints.wait() == 0
    assert "Traceback" not in joints.stderr


def test_zeros_and_other_sources_move_the_joints(ros, observer, urdf):
    received = listen(observer, "sensor_msgs/msg/JointState", "/joint_states")
    kind = get_message("sensor_msgs/msg/JointState")
    source = observer.create_publisher(kind, "/sliders", qos_profile_latched)
    parameters = parameter_file(
        ros, urdf, source_list=["/sliders"], rate=50, **{"zeros.joint_2": 0.25}
    )
    ros.spawn_module("teleopctl.nodes", f"{JOINTS} --ros-args --params-file {parameters}")
    assert list(received.get(timeout=WAIT_S).position) == [0.0, 0.25, 0.0, 0.0, 0.0]
    assert observer.wait_for_subscribers("/sliders", 1, WAIT_S)
    source.publish(kind(name=["joint_4"], position=[-0.5], velocity=[2.0]))
    while (state := received.get(timeout=WAIT_S)).position[3] == 0.0:
        pass
    assert list(state.position) == [0.0, 0.25, 0.0, -0.5, 0.5]
    assert list(state.velocity) == [0.0, 0.0, 0.0, 2.0, -2.0]


def test_a_file_can_be_given_instead_of_the_topic(ros, observer):
    received = listen(observer, "sensor_msgs/msg/JointState", "/joint_states")
    ros.spawn_module("teleopctl.nodes", f"{JOINTS} {MODEL}")
    assert len(received.get(timeout=WAIT_S).name) == 5


def test_tf_echo_shows_the_claw_where_forward_kinematics_puts_it(ros, observer, urdf):
    start_states(ros, urdf)
    positions = {"joint_1": 0.4, "joint_2": -0.7, "joint_3": 0.3, "joint_4": -1.0}
    echo = ros.spawn("tf echo world claw_support 50")
    echo.wait_for_line("Waiting for transform", stream="stderr")
    publish_joints(observer, positions, 3)
    printed = echo.wait_for_line(r"- Translation: \[(.*)\]", stream="stdout").group(1)
    expected = link_frames(urdf, positions)["claw_support"][:3, 3]
    assert [float(text) for text in printed.split(",")] == pytest.approx(list(expected), abs=1e-3)
