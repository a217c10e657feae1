"""What verbs say and ask only where a person sits at a terminal."""

import os
import sys

import pytest

from tests.system.terminal import Terminal

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a terminal of POSIX")


def typed(ros, line: str) -> Terminal:
    """A command on a terminal of its own."""
    return Terminal([sys.executable, "-m", "teleopctl", *line.split()], ros.env, ros.folder)


def test_stop_without_a_name_asks_on_a_terminal_and_refuses_elsewhere(ros):
    assert "No background processes" in ros.run("stop").stderr
    ros.run("run --detach teleop_py_pkg simple_publisher")
    refused = ros.run("stop")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr.startswith("teleopctl: Name what to stop: simple_publisher\n")
    for answer, said, status in (
        ("\r", "Nothing has been stopped", 1),
        ("y\r", "simple_publisher has been stopped", 0),
    ):
        terminal = typed(ros, "stop")
        terminal.until(r"Stop simple_publisher\? \[y/N\] ")
        terminal.press(answer)
        assert terminal.wait() == status
        assert said in terminal.text


def test_what_d_means_in_launch_is_said_once_and_to_people_only(ros, tmp_path):
    ros.env["XDG_STATE_HOME"] = str(tmp_path / "state")
    (ros.folder / "short.yaml").write_text("launch:\n- executable: {cmd: 'true'}\n")
    assert "--debug" not in ros.run("launch -d short.yaml").stderr
    for count in (1, 0):
        terminal = typed(ros, "launch -d short.yaml")
        assert terminal.wait() == 0
        assert terminal.text.count("-d means --detach here; ROS 2's -d") == count


def test_a_name_that_was_left_out_is_offered_on_a_terminal_only(ros):
    ros.spawn("run teleop_py_pkg simple_publisher").wait_for_line("Publishing")
    assert "/chatter" not in ros.run("topic info").stderr
    terminal = typed(ros, "topic info")
    assert terminal.wait() == 2
    assert "There are /chatter, /parameter_events, /rosout." in terminal.text
    assert "See `teleopctl topic info --help`." in terminal.text
