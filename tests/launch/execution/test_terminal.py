"""How a launch's output looks on a terminal."""

import os
import subprocess
import sys

import pytest

from teleopctl.launch.execution.terminal import Terminal
from teleopctl.testing import LONGEST_WAIT_S

LINE = b"[WARN] [1795251189.877707557] [head]: too hot\n"


def test_a_log_line_loses_process_and_time_and_a_warning_is_coloured():
    terminal = Terminal(["head-1"], coloured=True)
    assert terminal.relayed("head-1", LINE) == b"\x1b[33m[WARN] [head]: too hot\x1b[0m\n"
    assert terminal.relayed("head-1", LINE.replace(b"WARN", b"INFO")) == b"[INFO] [head]: too hot\n"
    assert terminal.own("ERROR", "head-1", "died") == b"\x1b[31m[ERROR] [head]: died\x1b[0m\n"


def test_nothing_is_coloured_where_it_is_not_wanted():
    assert Terminal(["head-1"], coloured=False).relayed("head-1", LINE) == (
        b"[WARN] [head]: too hot\n"
    )


def test_other_lines_say_which_process_wrote_them_with_its_number_where_two_are_alike():
    terminal = Terminal(["talker-1", "talker-2", "joint-state-3"], coloured=True)
    assert terminal.relayed("talker-2", b"hello\n") == b"[talker-2] hello\n"
    assert terminal.relayed("joint-state-3", b"no newline") == b"[joint-state] no newline\n"


def test_on_a_terminal_it_is_said_what_is_up_and_what_may_come_next(ros):
    (ros.folder / "one.yaml").write_text(
        "launch:\n- node: {pkg: teleop_py_pkg, exec: simple_publisher, name: mouth}\n"
    )
    pty = pytest.importorskip("pty", reason="Windows has no pseudo terminals of this kind")
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "teleopctl", "launch", "one.yaml"]
    env = {**ros.env, "TERM": "xterm"}
    up = (
        b"[INFO] [launch]: Up: /mouth",
        b"  Ctrl-C ends everything. Next, in another terminal:",
        b"    teleopctl node list",
        b"    teleopctl topic list",
        b"    teleopctl topic hz --all",
    )
    with subprocess.Popen(command, env=env, cwd=ros.folder, stdout=theirs) as launch:
        os.close(theirs)
        with os.fdopen(ours, "rb") as screen:
            lines: set[bytes] = set()
            while not {*up, b"[INFO] [mouth]: Publishing at 1.0 Hz"} <= lines:
                lines.add(screen.readline().rstrip())
            launch.terminate()
            assert launch.wait(LONGEST_WAIT_S) == 1  # as `ros2 launch` at SIGTERM


def test_our_own_configuration_warns_of_nothing(ros):
    launch = ros.spawn("launch sim.yaml camera:=false")
    launch.wait_for_line(r"\[spawner-\d\]: process has finished cleanly")
    launch.interrupt()
    launch.wait()
    lines = launch.stdout.splitlines()
    assert [line for line in lines if "[WARN]" in line or "[ERROR]" in line] == []
