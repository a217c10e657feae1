"""Programs as ROS 2 users write them, run unchanged in processes of their own."""

import os
from pathlib import Path

import pytest

from tests.samples import sample

PROGRAMS = Path(__file__).parent / "programs"


@pytest.mark.parametrize(
    ("program", "args"),
    sample(
        [
            ("talk_and_listen", []),
            ("services", []),
            ("actions", []),
            ("parameters", ["--ros-args", "-p", "my_parameter:=from outside"]),
            ("clocks", []),
            ("waiting_by_hand", []),
            ("beside_rclpy", []),
            (
                "graph",
                [
                    "mine",
                    "--ros-args",
                    "-r",
                    "chatter:=spoken",
                    "-r",
                    "__node:=renamed",
                    "-r",
                    "__ns:=/other",
                ],
            ),
        ],
        2,
    ),
)
def test_a_program_runs_to_its_end_and_leaves_quietly(shared_ros, program, args):
    ended = shared_ros.run_module(
        "teleopctl.nodes", [str(PROGRAMS / f"{program}.py"), *args], timeout=60
    )
    assert (ended.returncode, ended.stdout) == (0, "done\n"), ended.stderr
    assert "Traceback" not in ended.stderr
    assert "Exception" not in ended.stderr


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM to react to")
@pytest.mark.parametrize(
    "state",
    sample(["spin", "spin_once", "service", "callback", "rate", "sleep", "thread", "pool"], 3),
)
@pytest.mark.parametrize(("signal", "status"), [("interrupt", 130), ("terminate", 0)])
def test_a_signal_ends_a_program_quietly_in_every_state(shared_ros, state, signal, status):
    process = shared_ros.spawn_module("teleopctl.nodes", [str(PROGRAMS / "waiting.py"), state])
    process.wait_for_line("waiting")
    getattr(process, signal)()
    assert process.wait() == status
    assert "Traceback" not in process.stderr
