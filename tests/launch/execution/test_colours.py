"""The colours of a launch's output on a terminal."""

import os
import re
import subprocess
import sys

import pytest

from teleopctl.launch.execution.screen import QuietLines, launch_line, process_line
from teleopctl.testing import LONGEST_WAIT_S

LINE = b"[WARN] [1795251189.877707557] [head]: too hot\n"
TEAL, ORCHID = b"\x1b[38;5;30m", b"\x1b[38;5;133m"
YELLOW, RED, RESET = b"\x1b[33m", b"\x1b[31m", b"\x1b[0m"


def test_a_warning_is_coloured_whole_and_the_name_like_its_process():
    prefix = TEAL + b"[head-1]" + RESET + b" "
    warning = prefix + YELLOW + LINE.rstrip() + RESET + b"\n"
    assert process_line("head-1", LINE) == warning
    in_colour_already = YELLOW + LINE.rstrip() + RESET + b"\n"
    assert process_line("head-1", in_colour_already) == warning
    info = LINE.replace(b"WARN", b"INFO")
    assert process_line("head-1", info) == prefix + info
    died = RED + b"[ERROR] " + RESET + ORCHID + b"[arm-2]" + RESET + RED + b": died" + RESET
    assert launch_line("ERROR", "arm-2", "died") == died + b"\n"


def test_an_address_that_the_launch_says_is_marked():
    marked = b"\x1b[1;4mhttp://localhost:8080/\x1b[0m"
    assert marked in launch_line("INFO", "launch", "Up: /a\n  The robot: http://localhost:8080/")


def test_a_quiet_process_hides_what_it_logs_below_warn_and_nothing_that_it_prints():
    hidden = QuietLines().hides
    lines = [
        (b"[INFO] [1.0] [head]: Loading\n", True),
        (b"\tposition\n", True),
        (b"Traceback (most recent call last):\n", False),
        (b'  File "x"\n', False),
        (b"[DEBUG] [1.0] [head]: detail\n", True),
        (LINE, False),
        (b"  by 3 K\n", False),
    ]
    for line, is_hidden in lines:
        assert hidden(line) is is_hidden, line


def test_a_colour_that_a_process_leaves_on_ends_with_its_line():
    assert process_line("talker-1", b"\x1b[35mmine\n").endswith(b" \x1b[35mmine\x1b[0m\n")


def luminance(colour: int) -> float:
    """Of one of the 256 colours of terminals, as WCAG 2.2 defines it."""
    steps = (0, 95, 135, 175, 215, 255)
    cube = colour - 16
    parts = [steps[cube // 36] / 255, steps[cube // 6 % 6] / 255, steps[cube % 6] / 255]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_the_colours_of_processes_can_be_read_on_black_and_on_white():
    shown = {process_line(f"talker-{number}", b"\n") for number in range(1, 30)}
    colours = {int(line.partition(b";5;")[2].partition(b"m")[0]) for line in shown}
    assert len(colours) == 10
    for colour in colours:
        assert 1.05 / (luminance(colour) + 0.05) > 3.9
        assert (luminance(colour) + 0.05) / 0.05 > 3.9


class Screen:
    """A launch whose output is a terminal."""

    def __init__(self, ros, words, **env):
        pty = pytest.importorskip("pty", reason="Windows has no pseudo terminals of this kind")
        ours, theirs = pty.openpty()
        self.launch = subprocess.Popen(
            [sys.executable, "-m", "teleopctl", "launch", *words.split()],
            env={**ros.env, "TERM": "xterm", **env},
            cwd=ros.folder,
            stdout=theirs,
        )
        os.close(theirs)
        self._screen = os.fdopen(ours, "rb")

    def line(self) -> bytes:
        """The next line; empty at the end."""
        try:
            return self._screen.readline().replace(b"\r\n", b"\n")
        except OSError:  # nobody writes to the terminal any more
            return b""

    def end(self, status: int) -> list[bytes]:
        """All lines that are left."""
        lines = list(iter(self.line, b""))
        self._screen.close()
        assert self.launch.wait(LONGEST_WAIT_S) == status
        return lines


TWO = """launch:
- executable: {cmd: "sh -c 'echo hello'", output: screen}
- executable: {cmd: "sh -c 'exit 3'", output: screen}
"""


@pytest.mark.parametrize("no_colour", ["", "1"])
def test_each_process_has_its_colour_on_a_terminal_unless_colours_are_off(ros, no_colour):
    (ros.folder / "two.yaml").write_text(TWO)
    lines = Screen(ros, "two.yaml", NO_COLOR=no_colour).end(0)
    expected = [
        b"[INFO] " + TEAL + b"[sh-1]" + RESET + b": process started with pid [N]\n",
        b"[INFO] " + ORCHID + b"[sh-2]" + RESET + b": process started with pid [N]\n",
        TEAL + b"[sh-1]" + RESET + b" hello\n",
        b"[INFO] " + TEAL + b"[sh-1]" + RESET + b": process has finished cleanly [pid N]\n",
        RED + b"[ERROR] " + RESET + ORCHID + b"[sh-2]" + RESET + RED
        + b": process has died [pid N, exit code 3, cmd 'sh -c exit 3']." + RESET + b"\n",
    ]  # fmt: skip
    if no_colour:
        expected = [re.sub(rb"\x1b\[[\d;]*m", b"", line) for line in expected]
    shown = [re.sub(rb"(pid \[?)\d+", rb"\1N", line) for line in lines if b"[sh-" in line]
    assert sorted(shown) == sorted(expected)


def test_on_a_terminal_it_is_said_what_is_up_and_what_may_come_next(ros):
    (ros.folder / "one.yaml").write_text(
        "launch:\n- node: {pkg: teleop_py_pkg, exec: simple_publisher, name: mouth}\n"
    )
    up = {
        b"[INFO] [launch]: Up: /mouth\n",
        b"  Ctrl-C ends everything. Next, in another terminal: "
        b"`teleopctl node list`, `teleopctl topic list`\n",
    }
    spoken = False
    screen = Screen(ros, "one.yaml", NO_COLOR="1")
    while up or not spoken:
        line = screen.line()
        if re.fullmatch(
            rb"\[simple_publisher-1\] \[INFO\] \[[\d.]+\] \[mouth\]: Publishing at .*\n", line
        ):
            spoken = True
        assert line, f"the launch ended without {up}"
        up.discard(line)
    screen.launch.terminate()
    screen.end(1)  # as `ros2 launch` does at SIGTERM


def test_a_terminal_gets_what_is_up_of_a_builtin_launch_and_the_log_the_rest(ros):
    screen = Screen(ros, "display.yaml viewer:=false", NO_COLOR="1")
    lines: list[bytes] = []
    while not lines or b"Ctrl-C" not in lines[-1]:
        lines.append(screen.line())
        assert lines[-1], lines
    screen.launch.terminate()
    screen.end(1)
    assert [re.sub(rb"\d+|/.*", b"N", line) for line in lines] == [
        b"[INFO] [launch]: All log files can be found below N\n",
        *(
            b"[INFO] [%s-N]: process started with pid [N]\n" % name
            for name in (b"robot_state_publisher", b"joint_state_publisher")
        ),
        b"[INFO] [launch]: Up: N\n",
        b"  Ctrl-C ends everything. Next, in another terminal: "
        b"`teleopctl node list`, `teleopctl topic list`\n",
    ]
    (log,) = ros.folder.rglob("launch.log")
    assert "got segment base_link" in log.read_text()


@pytest.mark.nightly
def test_our_own_configuration_warns_of_nothing(ros):
    launch = ros.spawn("launch sim.yaml camera:=false")
    launch.wait_for_line(r"\[spawner-\d\]: process has finished cleanly")
    launch.interrupt()
    launch.wait()
    lines = launch.stdout.splitlines()
    assert [line for line in lines if "[WARN]" in line or "[ERROR]" in line] == []
