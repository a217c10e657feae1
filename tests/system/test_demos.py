"""The programs of ROS 2's tutorials under their names, in the words that the tutorials show."""

import re

import pytest

from teleopctl.interfaces import get_message
from teleopctl.testing import LONGEST_WAIT_S, eventually


def said(process):
    """What a program has logged, without the time."""
    return re.findall(r"^\[\w+\] \[[\d.]+\] \[\w+\]: (.*)", process.stderr, re.MULTILINE)


def hears(process, line):
    process.wait_for_line(f"{re.escape(line)}$", stream="stderr")


@pytest.mark.parametrize(
    ("talker", "listener", "first"),
    [
        ("demo_nodes_py talker", "demo_nodes_cpp listener", 'Publishing: "Hello World: 0"'),
        pytest.param(
            *("demo_nodes_cpp talker", "demo_nodes_py listener", "Publishing: 'Hello World: 1'"),
            marks=pytest.mark.nightly,
        ),
    ],
)
def test_a_talker_is_heard(shared_ros, talker, listener, first):
    topic = f"--ros-args -r chatter:=/{talker.partition(' ')[0]}"
    listening = shared_ros.spawn(f"run {listener} {topic}")
    bytes_ = shared_ros.spawn(f"run demo_nodes_py listener_serialized {topic}")
    shared_ros.wait_for_nodes("/listener", "/serialized_subscriber")
    talking = shared_ros.spawn(f"run {talker} {topic}")
    hears(talking, first)
    listening.wait_for_line(r"\[listener\]: I heard: \[Hello World: \d+\]$")
    bytes_.wait_for_line(r"""I heard: "b'\\x00\\x01.*Hello World: \d+\\x00'"$""")
    for process in (talking, listening, bytes_):
        process.interrupt()
    assert [process.wait() for process in (talking, listening, bytes_)] == [0, 0, 0]


def test_talkers_and_listeners_choose_their_reliability_and_end_by_themselves(shared_ros):
    topic = "--ros-args -r chatter:=/qos"
    talker = shared_ros.run(f"run demo_nodes_py talker_qos -n 1 {topic}")
    assert said(talker) == ["Best effort talker", 'Publishing: "Hello World: 0"']
    listener = shared_ros.run(f"run demo_nodes_py listener_qos --reliable -n 0 {topic}")
    assert said(listener) == ["Reliable listener"]
    assert (talker.returncode, listener.returncode) == (0, 0)


@pytest.mark.nightly
def test_the_sum_of_two_integers_is_asked_for(shared_ros):
    waiting = shared_ros.spawn("run demo_nodes_py add_two_ints_client")
    waiting.wait_for_line("service not available, waiting again...", stream="stdout")
    server = shared_ros.spawn("run demo_nodes_py add_two_ints_server")
    assert waiting.wait() == 0
    assert said(waiting) == ["Result of add_two_ints: 5"]
    server.wait_for_line("a: 2 b: 3")
    done = shared_ros.run("run demo_nodes_py add_two_ints_client_async")
    assert said(done) == ["Result of add_two_ints: 5"]
    server.interrupt()
    assert server.wait() == 0
    launched = shared_ros.run(
        "launch demo_nodes_cpp add_two_ints_launch.py", timeout=LONGEST_WAIT_S
    )
    assert "[add_two_ints_client]: Result of add_two_ints: 5" in launched.stdout


def test_parameters_of_the_blackboard_are_set_listed_read_loaded_and_deleted(shared_ros):
    board = shared_ros.spawn("run demo_nodes_cpp parameter_blackboard")
    hears(
        board,
        "Parameter blackboard node named '/parameter_blackboard' ready, and serving "
        "'2' parameters already!",
    )
    done = shared_ros.run("run demo_nodes_py async_param_client")
    assert done.returncode == 0, done.stderr
    lines = said(done)
    assert lines[:4] == [
        "Setting parameters:",
        "    int_parameter:",
        "        successful: True",
        "    bool_parameter:",
    ]
    assert "    - string_parameter: Fee Fi Fo Fum" in lines
    assert "        value: loaded from a file" in lines
    assert lines[-3:] == [
        "    string_parameter:",
        "        successful: True",
        "        reason: ",
    ]
    assert shared_ros.run("param get /parameter_blackboard int_parameter").stdout == (
        "Integer value is: 12\n"
    )
    board.interrupt()


def test_one_parameter_sets_another(shared_ros):
    node = shared_ros.spawn("run demo_nodes_py set_parameters_callback")
    shared_ros.wait_for_nodes("/set_parameters_callback")
    done = shared_ros.run("param set /set_parameters_callback param1 1.0")
    assert done.returncode == 0, done.stderr
    done = shared_ros.run("param get /set_parameters_callback param2")
    assert done.stdout == "Double value is: 4.0\n"
    node.interrupt()


def test_a_service_is_introspected_while_a_parameter_says_so(shared_ros):
    nodes = shared_ros.spawn("run demo_nodes_py introspection")
    hears(nodes, "Result of add_two_ints: 5")
    switch = "/introspection_client client_configure_introspection"
    refused = shared_ros.run(f"param set {switch} some")
    assert "must be one of 'disabled', 'metadata', or 'contents" in refused.stderr
    assert shared_ros.run(f"param set {switch} contents").returncode == 0
    event = shared_ros.run("topic echo --once /add_two_ints/_service_event --field request")
    assert event.returncode == 0, event.stderr
    nodes.interrupt()
    assert nodes.wait() == 0


def test_connections_are_counted(shared_ros):
    done = shared_ros.run("run demo_nodes_py matched_event_detect")
    assert done.returncode == 0
    expected = []
    for what in ("subscription", "publisher"):
        changed = f"The changed number of connected {what} is"
        number = f"and current number of connected {what} is"
        expected += [
            f"Create a new {what}.",
            f"First {what} is connected.",
            f"Create a new {what}.",
            f"{changed} 1 {number} 2",
            f"Destroy a {what}.",
            f"{changed} -1 {number} 1",
            f"Destroy a {what}.",
            f"Last {what} is disconnected.",
        ]
    assert said(done) == expected


def test_a_log_level_is_changed_by_a_service(shared_ros):
    done = shared_ros.run("run demo_nodes_py use_logger_service")
    assert done.returncode == 0, done.stderr
    lines = said(done)
    assert [line for line in lines if line.startswith("Current")] == [
        f"Current logger level: {level}" for level in (0, 10, 30, 40)
    ]
    received = [line for line in lines if line.startswith("Output 2")]
    assert received == [
        f"Output 2 with {level} logger level." for level in ("DEBUG", "INFO", "WARN", "ERROR")
    ]
    assert [line for line in lines if line.startswith("Output 4")] == [
        "Output 4 with ERROR logger level."
    ]


@pytest.mark.nightly
def test_the_managed_talker_publishes_while_it_is_active(shared_ros):
    talker = shared_ros.spawn("run lifecycle_py lifecycle_talker")
    listener = shared_ros.spawn("run lifecycle lifecycle_listener")
    shared_ros.wait_for_nodes("/lc_talker", "/lc_listener")
    for transition, line in (
        ("configure", "on_configure() is called."),
        ("activate", "on_activate() is called."),
    ):
        done = shared_ros.run(f"lifecycle set /lc_talker {transition}")
        assert done.stdout == "Transitioning successful\n", done.stderr
        hears(talker, line)
    talker.wait_for_line(
        r"Lifecycle publisher is active. Publishing: \[Lifecycle HelloWorld #\d+\]"
    )
    listener.wait_for_line(r"data_callback: Lifecycle HelloWorld #\d+")
    for transition in ("deactivate", "cleanup", "shutdown"):
        done = shared_ros.run(f"lifecycle set /lc_talker {transition}")
        assert done.stdout == "Transitioning successful\n", done.stderr
    hears(talker, "on_shutdown() is called.")
    for program in (talker, listener):
        program.interrupt()
        assert program.wait() == 0


def test_fibonacci_numbers_are_asked_for_by_an_action(shared_ros):
    client = shared_ros.spawn("run action_tutorials_py fibonacci_action_client")
    server = shared_ros.spawn("run action_tutorials_py fibonacci_action_server")
    hears(server, "Executing goal...")
    hears(server, "Feedback: array('i', [0, 1, 1])")
    hears(client, "Goal accepted :)")
    hears(client, "Received feedback: array('i', [0, 1, 1])")
    client.interrupt()
    server.interrupt()
    assert client.wait() == 0


GOALS = """
publisher_forward_position_controller:
  ros__parameters:
    wait_sec_between_publish: 1
    publish_topic: /forward_position_controller/commands
    goal_names: [there, back]
    there: [0.7, 0.8]
    back: [0.0, 0.0]
publisher_joint_trajectory_controller:
  ros__parameters:
    controller_name: arm
    wait_sec_between_publish: 1
    goal_names: [wrong, right]
    wrong: {positions: [1.0]}
    right: {positions: [0.1, 0.2], velocities: [0.0, 0.0]}
    joints: [joint1, joint2]
    check_starting_point: true
    starting_point_limits: {joint1: [-0.1, 0.1]}
"""


def test_goals_are_sent_to_controllers_in_turn(shared_ros):
    path = shared_ros.folder / "goals.yaml"
    path.write_text(GOALS)

    def start(program):
        return shared_ros.spawn(
            f"run ros2_controllers_test_nodes {program} --ros-args -r __node:={program} "
            f"--params-file {path}"
        )

    forward = start("publisher_forward_position_controller")
    hears(forward, "Publishing: \"array('d', [0.7, 0.8])\"")
    hears(forward, "Publishing: \"array('d', [0.0, 0.0])\"")
    trajectory = start("publisher_joint_trajectory_controller")
    hears(
        trajectory,
        'Goal "wrong" definition is wrong. This goal will not be used. It needs one of positions, '
        "velocities, accelerations, effort: a list of 2 numbers",
    )
    hears(trajectory, 'Start configuration could not be checked! Check "joint_state" topic!')
    state = get_message("sensor_msgs/msg/JointState")
    states = shared_ros.node.create_publisher(state, "/joint_states", 10)
    eventually(states.get_subscription_count)
    states.publish(state(name=["joint1", "other"], position=[0.05, 9.0]))
    sent = shared_ros.wait_for_message(
        get_message("trajectory_msgs/msg/JointTrajectory"), "/arm/joint_trajectory"
    )
    assert (sent.joint_names, list(sent.points[0].positions)) == (["joint1", "joint2"], [0.1, 0.2])
    assert sent.points[0].time_from_start.sec == 4
    done = shared_ros.run("run ros2_controllers_test_nodes publisher_forward_position_controller")
    assert done.returncode == 1
    assert "Values for goal 'pos1' not set!" in done.stderr
    for program in (forward, trajectory):
        program.interrupt()
        assert program.wait() == 0
