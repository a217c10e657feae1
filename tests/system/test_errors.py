"""Mistakes: one clear message on stderr, nothing on stdout, and the right exit status."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from teleopctl.testing import LONGEST_WAIT_S
from tests.samples import sample


@pytest.fixture(scope="module")
def graph(shared_ros):
    node = shared_ros.spawn_module("teleopctl.nodes", "teleop_robot_py_pkg simple_parameter")
    done = shared_ros.run(
        "service call /simple_parameter/list_parameters rcl_interfaces/srv/ListParameters"
    )
    assert done.returncode == 0, done.stderr
    talker = shared_ros.spawn("topic pub -r 20 /chatter std_msgs/msg/String")
    talker.wait_for_line("publishing #1")
    assert node.returncode is None
    return shared_ros


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    sample(
        [
            ("topic info /chater", "Unknown topic '/chater'", "/chatter"),
            ("topic type /chater", "Unknown topic '/chater'", "/chatter"),
            ("topic echo /chater", "Could not determine the type for the passed topic", "/chatter"),
            ("node info /simple_paramter", "Unable to find node", "/simple_parameter"),
            (
                "param get /simple_paramter x",
                "Node not found: '/simple_paramter'",
                "/simple_parameter",
            ),
            ("param list /nowhere", "Node not found: '/nowhere'", "/simple_parameter"),
            ("param set /simple_paramter x 1", "Node not found", "/simple_parameter"),
            ("param get /simple_parameter simple_int", "Parameter not set", "simple_int_param"),
            ("param set /simple_parameter simple_int 1", "simple_int was not", "simple_int_param"),
            ("service type /simple_parameter/get_params", "Unknown service", "get_parameters"),
            (
                "service call /simple_parameter/get_parameters std_srvs/srv/Empty",
                "has the type rcl_interfaces/srv/GetParameters, not std_srvs/srv/Empty",
                "teleopctl service call /simple_parameter/get_parameters rcl_interfaces/srv/Get",
            ),
            (
                "service call /bad//name std_srvs/srv/Empty",
                "Invalid service name: topic name must not contain repeated '/'",
                "'/bad//name'",
            ),
            (
                "topic echo bad//name",
                "Invalid topic name: topic name must not contain repeated '/'",
                "'/bad//name'",
            ),
        ],
        2,
    ),
)
def test_an_unknown_name_fails_and_suggests_one(graph, line, message, hint):
    done = graph.run(line)
    assert (done.stdout, done.returncode) == ("", 1)
    assert message in done.stderr
    assert hint in done.stderr
    assert "Traceback" not in done.stderr


def test_echo_of_an_unpublished_topic_has_ros2s_warning(graph):
    done = graph.run("topic echo /nothing")
    assert done.stderr.splitlines()[0] == (
        "WARNING: topic [/nothing] does not appear to be published yet"
    )
    assert "Give the type" in done.stderr


@pytest.mark.parametrize(
    ("kind", "values", "fragments"),
    sample(
        [
            ("std_msgs/msg/String", "{date: 1}", ["Failed to populate field: ", "date", "data"]),
            ("std_msgs/msg/String", "{data: [1]}", ["data", "string"]),
            (
                "std_msgs/msg/String",
                "data:x",
                ["The passed value needs to be a dictionary in YAML"],
            ),
            ("std_msgs/msg/Int8", "{data: 300}", ["data", "300"]),
            ("geometry_msgs/msg/Twist", "{linear: {x: fast}}", ["linear.x", "fast"]),
            ("std_msgs/msg/String", "{data: ", ["The passed value needs to be in YAML string"]),
            (
                "std_msgs/msg/Int8MultiArray",
                "{data:[-1]}",
                ["line 1, column 6", "A blank must follow"],
            ),
            (
                "std_msgs/msg/String",
                "data:\n\t- x",
                ["in line 2, column 1", "YAML allows no tab there"],
            ),
            (
                "std_msgs/msg/Strin",
                "{}",
                ["The passed message type is invalid", "std_msgs/msg/String"],
            ),
        ],
        3,
    ),
)
def test_a_message_that_does_not_fit_its_type_names_the_field(graph, kind, values, fragments):
    done = graph.run(["topic", "pub", "--once", "-w", "0", "/x", kind, values])
    assert (done.stdout, done.returncode) == ("", 1)
    for fragment in fragments:
        assert fragment in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "line",
    sample(
        [
            "topc list",
            "topic lst",
            "topic list --colour",
            "topic info",
            "topic pub /x",
            "topic pub -r fast /x std_msgs/msg/String",
            "topic pub -r 0 /x std_msgs/msg/String",
            "topic pub -w -1 /x std_msgs/msg/String",
            "topic pub -t -1 /x std_msgs/msg/String",
            "topic pub --once -t 2 /x std_msgs/msg/String",
            "topic pub --stdin /x std_msgs/msg/String {}",
            "topic echo -l -1 /chatter",
            "topic echo --timeout 0 /chatter",
            "topic echo --qos-depth -1 /chatter",
            "topic echo --qos-reliability maybe /chatter",
            "topic echo --filter 'm.data >' /chatter",
            "topic echo --csv --json /chatter",
            "topic hz",
            "topic hz -w 0 /chatter",
            "topic bw -w 0 /chatter",
            "param get /simple_parameter",
        ],
        3,
    ),
)
def test_wrong_usage_ends_with_2(graph, line):
    done = graph.run(line)
    assert (done.stdout, done.returncode) == ("", 2)
    assert done.stderr.startswith("teleopctl: ")


@pytest.mark.parametrize("line", ["topic list", "node list", "param list", "topic info /x"])
def test_without_a_router_a_query_says_so_and_what_to_do(ros_without_router, line):
    done = ros_without_router.run(line)
    assert (done.stdout, done.returncode) == ("", 1)
    assert ros_without_router.router in done.stderr
    assert "teleopctl daemon start" in done.stderr


def test_a_publisher_starts_the_router_itself(ros_without_router):
    done = ros_without_router.run("topic pub --once -w 0 /x std_msgs/msg/String")
    assert done.returncode == 0
    assert ros_without_router.run("topic list").returncode == 0


def test_debug_shows_where_an_error_comes_from(graph):
    done = graph.run("--debug topic info /nothing")
    assert done.returncode == 1
    assert "Traceback" in done.stderr
    assert "Unknown topic '/nothing'" in done.stderr


def test_a_typed_listener_is_told_that_the_topic_has_another_type(graph):
    done = graph.run("topic echo --timeout 0.1 /chatter std_msgs/msg/Int8")
    assert done.stderr.splitlines()[0] == (
        "WARNING: topic [/chatter] has the type std_msgs/msg/String: "
        "only messages of the type std_msgs/msg/Int8 are received"
    )


def test_a_misspelt_program_without_its_package_is_suggested(graph):
    done = graph.run("run simple_publsher")
    assert done.returncode == 1
    assert "Did you mean simple_publisher" in done.stderr


def test_a_prefix_that_no_shell_would_take_is_wrong_usage(graph):
    done = graph.run(["run", "--prefix", 'nice "', "simple_publisher"])
    assert done.returncode == 2
    assert done.stderr.startswith("teleopctl: --prefix")


def test_a_wrong_domain_is_said_once_and_nothing_is_started(graph, monkeypatch):
    monkeypatch.setitem(graph.env, "ROS_DOMAIN_ID", "abc")
    done = graph.run("launch display.yaml")
    assert (done.stdout, done.returncode) == ("", 2)
    assert done.stderr == "teleopctl: ROS_DOMAIN_ID is 'abc', but a domain is a number from 0.\n"


@pytest.mark.skipif(os.name == "nt", reason="a POSIX shell")
@pytest.mark.parametrize("redirection", [">&-", ">&- 2>&-"])
def test_a_stream_that_is_closed_from_the_start_is_no_error(graph, redirection):
    command = f"{shlex.quote(sys.executable)} -m teleopctl topic list {redirection}"
    done = subprocess.run(
        command, shell=True, env=graph.env, capture_output=True, timeout=LONGEST_WAIT_S
    )
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the device that is always full")
def test_a_full_disk_is_one_message(graph):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "teleopctl", "topic", "list"],
            env=graph.env,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=LONGEST_WAIT_S,
        )
    assert done.returncode == 1
    assert done.stderr == "teleopctl: Cannot write: No space left on device\n"


@pytest.mark.skipif(os.name == "nt", reason="arguments are text there")
def test_bytes_that_are_no_text_are_wrong_usage(graph):
    done = graph.run(
        ["topic", "pub", "--once", "-w", "0", "/x", "std_msgs/msg/String", "{data: '\udcff'}"]
    )
    assert done.returncode == 2
    assert "is not text in this encoding" in done.stderr


def test_a_reader_that_goes_away_ends_a_stream_quietly(graph):
    echo = subprocess.Popen(
        [sys.executable, "-m", "teleopctl", "topic", "echo", "/chatter"],
        env=graph.env,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert echo.stdout is not None
    assert echo.stderr is not None
    with echo:
        assert echo.stdout.readline() == "data: ''\n"
        echo.stdout.close()
        assert echo.wait(LONGEST_WAIT_S) == 0
        assert echo.stderr.read() == ""


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "topic pub --once /parameter_event std_msgs/msg/Empty",
            r"^No subscription to '/parameter_event' yet\. There are .*",
        ),
        (
            "tf echo map odom",
            r"^No frame 'map' and 'odom' yet\. There are no frames\.$",
        ),
        (
            "service call /simple_parameter/get_paramters rcl_interfaces/srv/GetParameters",
            r"^No service '/simple_parameter/get_paramters' of "
            r"rcl_interfaces/srv/GetParameters yet\. "
            r"There is /simple_parameter/get_parameters\. "
            r"Did you mean /simple_parameter/get_parameters",
        ),
        (
            "tf echo wrold cup",
            r"^No frame 'wrold' yet\. There are cup, world\. Did you mean world\?$",
        ),
    ],
)
def test_waiting_for_a_name_that_nobody_has_tells_after_a_second_what_there_is(graph, line, told):
    others = []
    if "wrold" in line:
        words = "--frame-id world --child-frame-id cup"
        others = [graph.spawn(f"run tf2_ros static_transform_publisher {words}")]
        others[0].wait_for_line("Spinning")
    waiting = graph.spawn(line)
    waiting.wait_for_line(told, stream="stderr")
    assert waiting.returncode is None  # as ros2, it goes on
    # The graph is that of other tests, too.
    for process in (waiting, *others):
        process.interrupt()
        process.wait()
    assert "Traceback" not in waiting.stderr


def test_a_service_that_comes_late_is_called(graph):
    call = graph.spawn("service call /late/list_parameters rcl_interfaces/srv/ListParameters")
    call.wait_for_line("^No service '/late/list_parameters' of", stream="stderr")
    late = graph.spawn("run teleop_py_pkg simple_parameter --ros-args -r __node:=late")
    call.wait_for_line("simple_int_param", stream="stdout")
    assert call.wait() == 0
    late.interrupt()
    late.wait()
