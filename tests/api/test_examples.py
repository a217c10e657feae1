"""The programs of ``docs/examples`` run as they are, and are short."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import LEAN_PYTEST

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
MOST_LINES = 31


def run(folder, *words):
    return subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=folder,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


@pytest.mark.parametrize("name", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_an_example_fits_on_a_screen(name):
    assert len((EXAMPLES / name).read_text().splitlines()) <= MOST_LINES


def test_a_joint_is_simulated_and_plotted(tmp_path):
    done = run(tmp_path, EXAMPLES / "simulate.py", "joint.png")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("joint_1 followed to within 0.0")
    assert (tmp_path / "joint.png").stat().st_size > 1000


def test_a_controller_of_ones_own_moves_a_joint(tmp_path):
    done = run(tmp_path, EXAMPLES / "controller.py")
    assert done.returncode == 0, done.stderr
    assert "joint1 is at +0.500 rad" in done.stdout


def test_a_robot_is_checked_by_pytest(tmp_path):
    words = ["-m", "pytest", *LEAN_PYTEST, "-q", "-p", "no:cacheprovider", "-c", os.devnull]
    done = run(tmp_path, *words, EXAMPLES / "test_robot.py")
    assert done.returncode == 0, done.stdout
    assert "4 passed" in done.stdout


def test_a_bag_becomes_arrays(ros, tmp_path):
    recorder = ros.spawn("bag record -o session --topics /joint_states")
    message = "{name: [a, b], position: [0.1, 0.2]}"
    type_ = "sensor_msgs/msg/JointState"
    ros.run(["topic", "pub", "-w", "1", "-t", "5", "-r", "50", "/joint_states", type_, message])
    recorder.interrupt()
    assert recorder.wait() == 0
    done = run(ros.folder, EXAMPLES / "read_bag.py", ros.folder / "session")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("5 messages of 2 joints over 0.")
    assert "[0.1 0.2]" in done.stdout


def test_nodes_are_printed_as_they_come_and_go(ros):
    watcher = ros.spawn_command([sys.executable, str(EXAMPLES / "watch_graph.py")])
    talker = ros.spawn("run teleop_py_pkg simple_publisher")
    watcher.wait_for_line(r"\+ /simple_publisher")
    talker.interrupt()
    watcher.wait_for_line("- /simple_publisher")
