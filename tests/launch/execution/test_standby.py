"""The simulator's process that imports its modules while its launch file is evaluated."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from teleopctl.base import progress
from teleopctl.launch.execution.standby import StandbyProcess, standby_simulator
from teleopctl.launch.model.plan import ProcessPlan
from tests.samples import sample

PLAN = ProcessPlan(
    name="mujoco_sim-1",
    command=[sys.executable, "-P", "-m", "teleopctl.nodes", "mujoco_sim", "mujoco_sim", "--help"],
    is_node=True,
)


def environment(**changes: str) -> dict[str, str]:
    return {**os.environ, "PYTHONUNBUFFERED": "1", progress.VARIABLE: "/nowhere/x", **changes}


FILES = (
    "launch:\n- node: {pkg: mujoco_sim, exec: mujoco_sim}\n",
    "launch:\n- include: {file: $(find-pkg-share teleopctl)/launch/sim.yaml}\n",
)


@pytest.fixture
def launch_file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    file = tmp_path / "launch.yaml"
    file.write_text(str(request.param))
    return file


def process_of(standby: StandbyProcess | None) -> subprocess.Popen[bytes]:
    assert standby is not None
    return standby._process


@pytest.mark.parametrize(
    ("launch_file", "words"),
    sample([(FILES[0], []), (FILES[1], ["--builtin"])], 2),
    indirect=["launch_file"],
)
def test_it_becomes_the_simulator_with_the_arguments_of_its_plan(launch_file, words):
    command = [*PLAN.command[:4], *words, *PLAN.command[4:]]
    with standby_simulator(launch_file) as standby:
        assert standby is not None
        taken = standby.take(replace(PLAN, command=command), environment())
        assert taken is not None
        process, (out, err) = taken
        assert process is process_of(standby)
        with out, err:
            assert out.read().startswith(b"usage: mujoco_sim")
            assert err.read() == b""
        assert process.wait() == 0
        assert standby.take(PLAN, environment()) is None  # only once


@pytest.mark.parametrize("launch_file", FILES[:1], indirect=True)
def test_a_process_that_would_differ_is_started_as_usual_and_the_other_ends(launch_file):
    with standby_simulator(launch_file) as standby:
        assert standby is not None
        camera = [*PLAN.command[:4], "camera", "camera"]
        for other in (
            replace(PLAN, command=camera),
            replace(PLAN, command=["nice", *PLAN.command]),
            replace(PLAN, working_directory="/"),
            replace(PLAN, emulate_tty=True),
        ):
            assert standby.take(other, environment()) is None
        # Python and MuJoCo have read their variables.
        assert standby.take(PLAN, environment(PYTHONHASHSEED="1")) is None
        assert process_of(standby).poll() is None
        output = standby._output[1]
    assert process_of(standby).returncode is not None
    assert output.closed


@pytest.mark.parametrize("launch_file", FILES[:1], indirect=True)
def test_it_ends_with_a_launch_that_is_killed_while_it_evaluates_its_file(launch_file):
    with standby_simulator(launch_file) as standby:
        process = process_of(standby)
        assert process.stdin is not None
        process.stdin.close()  # as the system does
        assert process.wait() == 0


def test_no_process_waits_for_a_launch_without_a_simulator(tmp_path):
    file = tmp_path / "talker.launch.yaml"
    file.write_text("launch:\n- node: {pkg: demo_nodes_py, exec: talker}\n")
    for path in (file, tmp_path / "missing.launch.yaml"):
        with standby_simulator(path) as standby:
            assert standby is None
