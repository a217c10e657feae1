"""``teleopctl sim sweep``: real runs of small launch files."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import psutil
import pytest

from teleopctl.bag import open_bag
from teleopctl.node import Node
from teleopctl.sweep.one_run import _records_all
from teleopctl.testing import LONGEST_WAIT_S, RosGraph, eventually
from tests.sim.robots import control, joint, link

# A pendulum that falls: nothing drives its hinge.
ROBOT = " ".join(
    f"""<robot name="test">{link("base", "")}{link("arm")}{joint("held", "base", "arm")}
    <link name="rod"><inertial><origin xyz="0 0.1 0.25"/><mass value="$(var mass)"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
    {joint("hinge", "arm", "rod")}{control(held="position")}</robot>""".split()
)
PENDULUM = f"""
launch:
- arg: {{name: mass, default: "1"}}
- node:
    pkg: mujoco_sim
    exec: mujoco_sim
    param:
    - {{name: fixed_base, value: true}}
    - {{name: update_rate, value: 50}}
    - {{name: robot_description, type: str, value: '{ROBOT}'}}
"""

# It waits until there is a file.
WAITING = """
launch:
- arg: {name: file}
- executable: {cmd: "PYTHON wait.py $(var file)"}
""".replace("PYTHON", sys.executable)
WAIT = "import pathlib, sys, time\nwhile not pathlib.Path(sys.argv[1]).exists(): time.sleep(0.05)\n"


def states(bag: Path) -> list[bytes]:
    """The recorded joint states, each stamp once.

    How often a simulation that is not yet started shows its state depends on how the recorder's
    subscriptions arrive: each new subscriber gets it.
    """
    with open_bag(bag) as opened:
        messages = opened.messages(["/mujoco_sim/joint_states"])
        return list(dict.fromkeys(bytes(message.data) for message in messages))


def worker_and_program(folder: Path) -> tuple[psutil.Process, psutil.Process]:
    """Wait until a run is at work; its process, and the program that its launch has started."""
    runs: list[psutil.Process] = []
    programs: list[psutil.Process] = []

    def look() -> bool:
        runs.clear()
        programs.clear()
        for process in psutil.process_iter(["cmdline", "environ"]):
            words, environment = process.info["cmdline"] or [], process.info["environ"] or {}
            is_below = environment.get("TELEOPCTL_RUNTIME_DIR", "").startswith(str(folder))
            if words[-2:] == ["teleopctl.sweep", str(folder)]:
                runs.append(process)
            elif is_below and "wait.py" in words:
                programs.append(process)
        # What the run starts is a copy of it until it is another program.
        return len(runs) == len(programs) == 1

    eventually(look)
    return runs[0], programs[0]


def test_a_run_begins_when_the_recorder_has_each_topic_that_is_published() -> None:
    published = {"/clock": 1, "/joint_states": 1, "/_hidden": 1, "/only_subscribed": 0}
    recorded: list[tuple[str, list[str]]] = [("/clock", [])]
    node = SimpleNamespace(
        get_subscriber_names_and_types_by_node=lambda *_: recorded,
        get_topic_names_and_types=lambda: [(name, []) for name in published],
        count_publishers=published.get,
    )
    assert not _records_all(cast(Node, node))
    recorded.append(("/joint_states", []))
    assert _records_all(cast(Node, node))


def test_runs_are_measured_alike_and_one_that_fails_does_not_stop_the_others(
    ros_without_router: RosGraph, tmp_path: Path
) -> None:
    (tmp_path / "fall.launch.yaml").write_text(PENDULUM)
    done = ros_without_router.run(
        "sim sweep fall.launch.yaml mass:=2 --grid mujoco_sim:update_rate:=50,0,50 "
        "--duration 0.5 --output runs --jobs 2 "
        "--measure /mujoco_sim/joint_states.position[1]:last --json",
        timeout=2 * LONGEST_WAIT_S,
        cwd=tmp_path,
    )

    assert done.returncode == 1, done.stderr
    runs = json.loads(done.stdout)["runs"]
    assert [run["result"] for run in runs] == ["done", "failed", "done"], done.stderr
    assert [run["simulated_s"] for run in runs] == [0.5, None, 0.5]
    assert "'update_rate' is 0" in runs[1]["error"]
    first, _, third = (Path(run["folder"]) for run in runs)
    (angle,) = runs[0]["measures"].values()
    assert abs(angle) > 0.1
    assert runs[2]["measures"] == runs[0]["measures"]
    assert states(first / "bag") == states(third / "bag"), "the same bits"
    assert len(states(first / "bag")) > 20


@pytest.mark.nightly
def test_what_is_done_is_kept_at_ctrl_c_or_a_kill_and_the_rest_is_done_later(
    ros_without_router: RosGraph, tmp_path: Path
) -> None:
    (tmp_path / "wait.launch.yaml").write_text(WAITING)
    (tmp_path / "wait.py").write_text(WAIT)
    again = tmp_path / "again"
    sweep = ros_without_router.spawn(
        f"sim sweep wait.launch.yaml --grid file:={tmp_path},{again} --output runs --jobs 1",
        cwd=tmp_path,
    )
    sweep.wait_for_line(r"\[1/2\] run 1")
    sweep.interrupt()
    assert sweep.wait() == 130
    assert "1 left: teleopctl sim sweep --resume" in sweep.stderr

    sweep = ros_without_router.spawn("sim sweep --resume runs", cwd=tmp_path)
    run, waiting = worker_and_program(tmp_path / "runs" / "002")
    run.kill()
    assert sweep.wait() == 1
    assert re.search(r"^2 .* failed ", sweep.stdout, re.MULTILINE)
    assert "Run 2: its process ended without a result (killed by signal 9)" in sweep.stderr
    assert not waiting.is_running(), "what it had started is ended"

    again.touch()
    done = ros_without_router.run(
        "sim sweep --resume runs --json", timeout=2 * LONGEST_WAIT_S, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert [run["number"] for run in json.loads(done.stdout)["runs"]] == [1, 2]
    assert "1 run, 1 at a time" in done.stderr
    refused = ros_without_router.run("sim sweep wait.launch.yaml -o runs", cwd=tmp_path)
    assert refused.returncode == 1
    assert "--resume" in refused.stderr


def test_a_name_that_the_launch_file_does_not_know_is_refused_before_anything_runs(
    ros_without_router: RosGraph, tmp_path: Path
) -> None:
    (tmp_path / "wait.launch.yaml").write_text(WAITING)
    done = ros_without_router.run(
        "sim sweep wait.launch.yaml file:=x --grid fiel:=1,2 -o runs", cwd=tmp_path
    )
    assert done.returncode == 2
    assert "fiel" in done.stderr
    assert not (tmp_path / "runs").exists()


# Its start never ends: no controller manager comes.
STUCK = """
launch:
- node: {pkg: controller_manager, exec: spawner, args: none_such}
"""


@pytest.mark.nightly
def test_the_time_of_a_run_counts_from_its_start_and_the_time_without_progress_is_given(
    ros_without_router: RosGraph, tmp_path: Path
) -> None:
    (tmp_path / "stuck.launch.yaml").write_text(STUCK)
    for option, result, error in (
        ("--timeout", "timed out", "it took longer than 4 s"),
        ("--stall-timeout", "failed", "No progress for 4 s: spawner-1 (waiting for /controller_"),
    ):
        done = ros_without_router.run(
            f"sim sweep stuck.launch.yaml {option} 4 --output {option[2:]} --json", cwd=tmp_path
        )
        assert done.returncode == 1, done.stderr
        (run,) = json.loads(done.stdout)["runs"]
        assert run["result"] == result
        assert run["error"].startswith(error)
