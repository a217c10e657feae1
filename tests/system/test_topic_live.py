"""Figures of many topics as a table, and fields drawn in the terminal, between real processes."""

import json
import sys

import pytest

from teleopctl.testing import eventually

if sys.platform == "win32":
    pytest.skip("needs a terminal of POSIX", allow_module_level=True)
from tests.samples import sample
from tests.system.terminal import Terminal

STRING = "std_msgs/msg/String"
TWIST = "geometry_msgs/msg/Twist"


@pytest.fixture
def terminal(ros):
    opened = []

    def open_terminal(line):
        argv = [sys.executable, "-m", "teleopctl", *line.split()]
        opened.append(Terminal(argv, ros.env))
        return opened[-1]

    yield open_terminal
    for one in opened:
        one.close()


def two_talkers(ros):
    for topic, rate in (("/fast", "20"), ("/slow", "4")):
        ros.spawn(["topic", "pub", "-r", rate, topic, STRING, "{data: hello}"]).wait_for_line("#1")


def test_bw_of_many_topics_is_a_table(ros):
    two_talkers(ros)
    meter = ros.spawn("topic bw --all")
    meter.wait_for_line(r"^Subscribing to all [34] available topics\.\.\.$")
    meter.wait_for_line(r"^topic +bandwidth +window +mean +min +max *$")
    meter.wait_for_line(r"^/fast +\d+ B/s +\d+ +14 B +14 B +14 B *$")


def test_bw_of_many_topics_as_json(ros):
    two_talkers(ros)
    meter = ros.spawn("topic bw --json /fast /slow")
    report = json.loads(meter.wait_for_line(r"^\{.*/fast.*/slow.*$")[0])
    assert report["/fast"]["mean"] == 14
    assert report["/fast"]["bytes_per_s"] > report["/slow"]["bytes_per_s"]


@pytest.mark.parametrize(("verb", "unit"), [("hz", r"\d\.\d{3}"), ("bw", r"\d+ B/s")])
def test_on_a_terminal_the_table_stands_still(ros, terminal, verb, unit):
    two_talkers(ros)
    screen = terminal(f"topic {verb} --all")
    screen.until(rf"/fast +\d*{unit}")
    before = len(screen.text)
    # The next one begins by going up the lines of this one.
    screen.until(rf"(?s).{{{before}}}.*\x1b\[1A.*/fast +\d*{unit}.*/slow +\d*{unit}")
    assert "/parameter_events" in screen.text


def test_fields_are_drawn_on_a_terminal(ros, terminal):
    ros.spawn(["topic", "pub", "-r", "20", "/cmd_vel", TWIST, "{linear: {x: 1.5}}"]).wait_for_line(
        "#1"
    )
    screen = terminal("topic echo /cmd_vel --plot linear.x,angular.z --window 5")
    screen.until(r"-5 s.*linear\.x.*angular\.z")
    screen.until(r"\x1b\[1A.*-5 s")


def test_each_field_has_a_colour_on_a_terminal(ros, terminal):
    ros.env.pop("NO_COLOR", None)
    ros.spawn(["topic", "pub", "-r", "20", "/cmd_vel", TWIST, "{linear: {x: 1.5}}"]).wait_for_line(
        "#1"
    )
    screen = terminal("topic echo /cmd_vel --plot linear.x,angular.z --window 5")
    screen.until(r"\x1b\[3\dm.*linear\.x.*\x1b\[3\dm.*angular\.z")


def test_in_a_pipe_there_is_one_drawing_at_the_end(ros):
    ros.spawn(["topic", "pub", "-r", "20", "/cmd_vel", TWIST, "{linear: {x: 1.5}}"]).wait_for_line(
        "#1"
    )
    done = ros.run("topic echo /cmd_vel --plot linear.x --timeout 1")
    assert done.returncode == 0
    assert done.stdout.count("-10 s") == 1
    assert "linear.x" in done.stdout
    assert "\x1b" not in done.stdout


@pytest.mark.parametrize(
    ("options", "text"),
    sample(
        [
            ("--plot data", "'data' is not a number"),
            ("--plot nothing", "no field 'nothing'"),
            ("--plot data --window 0", "window must be positive"),
            ("--plot [", "Invalid field"),
        ],
        2,
    ),
)
def test_what_cannot_be_drawn_is_told(ros, options, text):
    ros.spawn(["topic", "pub", "-r", "20", "/chatter", STRING, "{data: hello}"]).wait_for_line("#1")
    done = ros.run(f"topic echo /chatter {options}")
    assert done.returncode != 0
    assert text in done.stderr


def test_a_topic_that_says_nothing_is_told(ros):
    ros.spawn("run teleop_py_pkg simple_subscriber")
    ros.wait_for_nodes("/simple_subscriber")
    done = ros.run("topic echo /parameter_events --plot stamp.sec --timeout 0.3")
    assert done.returncode == 1
    assert "No message on '/parameter_events'" in done.stderr


def test_an_interrupt_before_the_first_message_of_a_plot_is_one(ros):
    plot = ros.spawn(f"topic echo --plot data /unheard {STRING}")
    ros.wait_for_nodes(f"/_ros2cli_{plot.pid}")
    plot.interrupt()
    assert plot.wait() == 130


def test_a_rate_is_of_what_comes_and_not_of_what_was_kept(ros):
    ros.spawn(
        ["topic", "pub", "/kept", "std_msgs/msg/Empty", "--qos-durability", "transient_local"]
    )
    eventually(lambda: "/kept" in ros.run("topic list").stdout)
    ros.spawn("topic hz /kept")

    def subscription():
        return ros.run("topic info -v /kept").stdout.partition("Subscription count: 1")[2]

    eventually(subscription)
    assert "Durability: VOLATILE" in subscription()
