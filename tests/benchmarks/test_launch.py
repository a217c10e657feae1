"""``launch sim.yaml``, from the typed command to active controllers: where the time goes.

The floor is what no implementation could avoid: an interpreter that imports mujoco and zenoh and
compiles the arm's model.
"""

import os
import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

from teleopctl.testing import RosGraph, eventually
from tests.benchmarks.figure import Figure

ROUNDS = 5

BARE = """
import sys, mujoco, zenoh
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.mujoco_model.model import build_model
build_model(RobotDescription.from_urdf(expand_xacro(sys.argv[1], {})))
"""

# What the nodes log, and what it is the end of.
STAGES = {
    "controller manager starts": r"update rate is",
    "controller manager has the robot": r"Starting Controller Manager services",
    "joint_state_broadcaster active": r"Configured and activated joint_state_broadcaster",
    "arm_controller active": r"Configured and activated arm_controller",
    "gripper_controller active": r"Configured and activated gripper_controller",
    "simulation running": r"Simulation is running",
}


def launch_once(ros: RosGraph) -> dict[str, float]:
    """Launch, wait for all stages and end it; seconds from the command to each stage."""
    start = time.time()
    process = ros.spawn("launch sim.yaml")

    def seconds_to(pattern: str) -> float | None:
        line = re.search(rf"\[(\d+\.\d+)\] \[[^]]+\]: .*{pattern}", process.stdout)
        return float(line[1]) - start if line else None

    eventually(lambda: None not in map(seconds_to, STAGES.values()))
    process.interrupt()
    process.wait()
    return {stage: seconds_to(pattern) or 0.0 for stage, pattern in STAGES.items()}


def test_launch_to_active_controllers(ros: RosGraph, tmp_path: Path, figures: list[Figure]):
    # The bytecode is cached, as after any installation.
    ros.env.update(PYTHONPYCACHEPREFIX=str(tmp_path / "bytecode"), PYTHONDONTWRITEBYTECODE="")
    model = Path(__file__).parents[2] / "robot" / "urdf" / "teleop.urdf.xacro"
    bare, runs = [], []
    for _ in range(ROUNDS + 1):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", BARE, str(model)], env=ros.env, check=True)
        bare.append(time.perf_counter() - start)
        runs.append(launch_once(ros))
    # The first round writes the bytecode.
    medians = {name: statistics.median(run[name] for run in runs[1:]) for name in runs[0]}
    floor = statistics.median(bare[1:])
    for name, seconds in sorted(medians.items(), key=lambda item: item[1]):
        is_last = name == "gripper_controller active"
        figures.append(
            Figure(
                f"launch sim.yaml: {name}",
                f"{seconds:.2f} s",
                f"a process that compiles the model: {floor:.2f} s" if is_last else "",
                seconds / floor if is_last else None,
            )
        )


def test_where_a_node_spends_its_start(ros: RosGraph, tmp_path: Path, figures: list[Figure]):
    ros.env.update(PYTHONPYCACHEPREFIX=str(tmp_path / "bytecode"), PYTHONDONTWRITEBYTECODE="")
    modules = {
        "nothing": "pass",
        "zenoh": "import zenoh",
        "the node library": "import teleopctl.node",
        "mujoco": "import mujoco",
        "mujoco_sim": "import teleopctl.sim.node",
        "controller_manager": "import teleopctl.nodes.controller_manager",
        "robot_state_publisher": "import teleopctl.nodes.robot_state_publisher",
        "spawner": "import teleopctl.nodes.spawner",
        "camera": "import teleopctl.nodes.camera, teleopctl.sim.cameras.renderer",
    }
    times: dict[str, list[float]] = {name: [] for name in modules}
    for _ in range(ROUNDS + 1):
        for name, code in modules.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], env=ros.env, check=True)
            times[name].append(time.perf_counter() - start)
    figures += [
        Figure(f"process that imports {name}", f"{statistics.median(seconds[1:]) * 1e3:.0f} ms")
        for name, seconds in times.items()
    ]


LANGUAGES = {
    "yaml": "launch:\n- arg: {name: word, default: a}\n- executable: {cmd: 'cat $(var word)'}\n",
    "xml": "<launch><arg name='word' default='a'/><executable cmd='cat $(var word)'/></launch>",
    "py": """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration
def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("word", default_value="a"),
        ExecuteProcess(cmd=["cat", LaunchConfiguration("word")]),
    ])
""",
}


def test_from_the_command_to_the_first_process_in_each_language(
    ros: RosGraph, tmp_path: Path, figures: list[Figure]
):
    ros.env.update(PYTHONPYCACHEPREFIX=str(tmp_path / "bytecode"), PYTHONDONTWRITEBYTECODE="")
    for language, text in LANGUAGES.items():
        (ros.folder / f"one.launch.{language}").write_text(text)
    # A process that starts at once and waits: opening the pipe is what it does first.
    os.mkfifo(ros.folder / "a")

    def seconds_to_start(command: list[str]) -> float:
        start = time.perf_counter()
        process = subprocess.Popen(command, env=ros.env, cwd=ros.folder, stdout=subprocess.DEVNULL)
        with (ros.folder / "a").open("w"):
            taken = time.perf_counter() - start
        process.wait()
        return taken

    bare = [sys.executable, "-c", "import subprocess; subprocess.run(['cat', 'a'])"]
    commands = {"a bare script": bare} | {
        language: [sys.executable, "-m", "teleopctl", "launch", f"one.launch.{language}"]
        for language in LANGUAGES
    }
    runs = [
        {name: seconds_to_start(command) for name, command in commands.items()}
        for _ in range(2 * ROUNDS + 1)
    ]
    medians = {name: statistics.median(run[name] for run in runs[1:]) for name in commands}
    bare_s = medians.pop("a bare script")
    figures += [
        Figure(
            f"launch FILE.{name}: first process",
            f"{1000 * seconds:.0f} ms",
            f"bare script: {1000 * bare_s:.0f} ms",
            seconds / bare_s,
        )
        for name, seconds in medians.items()
    ]
