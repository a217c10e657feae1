"""``launch sim.yaml``, from the typed command to active controllers: where the time goes.

The floor is what no implementation could avoid: an interpreter that imports mujoco and zenoh and
compiles the arm's model. On a busy machine a launch of several processes waits longer than one
process; the processor time of both tells more there.
"""

import contextlib
import os
import re
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

import psutil

from teleopctl.testing import RosGraph, eventually
from tests.benchmarks.figure import Figure
from tests.benchmarks.test_command_line import SCRIPT

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


# Processes of which the simulation and its controllers consist; the rest looks on.
LOOKING_ON = ("camera", "rviz2")


def launch_once(ros: RosGraph) -> tuple[dict[str, float], dict[str, float]]:
    """Launch, wait for all stages and end it.

    Returns:
        Seconds from the command to each stage, and processor time by process until the last one.
    """
    start = time.time()
    process = ros.spawn("launch sim.yaml")

    def seconds_to(pattern: str) -> float | None:
        line = re.search(rf"\[(\d+\.\d+)\] \[[^]]+\]: .*{pattern}", process.stdout)
        return float(line[1]) - start if line else None

    eventually(lambda: None not in map(seconds_to, STAGES.values()))
    launched = psutil.Process(process.pid)
    used = {"launch": sum(launched.cpu_times()[:2])}
    for child in launched.children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):
            words, times = child.cmdline(), child.cpu_times()
            if "teleopctl.nodes" in words:
                used[words[words.index("teleopctl.nodes") + 3]] = times.user + times.system
    process.interrupt()
    process.wait()
    return {stage: seconds_to(pattern) or 0.0 for stage, pattern in STAGES.items()}, used


def processor_time_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def test_launch_to_active_controllers(ros: RosGraph, tmp_path: Path, figures: list[Figure]):
    # The bytecode is cached, as after any installation.
    ros.env.update(PYTHONPYCACHEPREFIX=str(tmp_path / "bytecode"), PYTHONDONTWRITEBYTECODE="")
    model = Path(__file__).parents[2] / "robot" / "urdf" / "teleop.urdf.xacro"
    bare, bare_used, runs, uses = [], [], [], []
    for _ in range(ROUNDS + 1):
        start, before = time.perf_counter(), processor_time_of_children()
        subprocess.run([sys.executable, "-c", BARE, str(model)], env=ros.env, check=True)
        bare.append(time.perf_counter() - start)
        bare_used.append(processor_time_of_children() - before)
        run, used = launch_once(ros)
        runs.append(run)
        uses.append(used)
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

    # A spawner may have ended before it is measured.
    names = dict.fromkeys(name for used in uses[1:] for name in used)
    least = {name: min(used[name] for used in uses[1:] if name in used) for name in names}
    needed = sum(used for name, used in least.items() if name not in LOOKING_ON)
    figures += [
        Figure(f"processor time of {name}", f"{used:.2f} s") for name, used in least.items()
    ]
    figures.append(
        Figure(
            f"processor time without {' and '.join(LOOKING_ON)}",
            f"{needed:.2f} s",
            f"a process that compiles the model: {min(bare_used[1:]):.2f} s",
            needed / min(bare_used[1:]),
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
    script = tmp_path / "teleopctl"
    script.write_text(SCRIPT)

    # A process that starts at once and waits: opening the pipe is what it does first.
    os.mkfifo(ros.folder / "a")

    def seconds_to_start(command: list[str]) -> tuple[float, float]:
        """Wall time and processor time of the command until the process has started."""
        start = time.perf_counter()
        process = subprocess.Popen(command, env=ros.env, cwd=ros.folder, stdout=subprocess.DEVNULL)
        with (ros.folder / "a").open("w"):
            taken = time.perf_counter() - start
            # Finer than psutil's clock ticks of 10 ms; nanoseconds on a processor come first.
            threads = Path(f"/proc/{process.pid}/task").glob("*/schedstat")
            used = sum(int(thread.read_text().split()[0]) for thread in threads) / 1e9
        process.wait()
        return taken, used

    bare = [sys.executable, "-c", "import subprocess; subprocess.run(['cat', 'a'])"]
    commands = {"a bare script": bare} | {
        language: [sys.executable, str(script), "launch", f"one.launch.{language}"]
        for language in LANGUAGES
    }
    runs = [
        {name: seconds_to_start(command) for name, command in commands.items()}
        for _ in range(2 * ROUNDS + 1)
    ]
    walls, used = (
        {name: statistics.median(run[name][which] for run in runs[1:]) for name in commands}
        if which == 0
        else {name: min(run[name][which] for run in runs[1:]) for name in commands}
        for which in (0, 1)
    )
    bare_s, bare_used_s = walls.pop("a bare script"), used.pop("a bare script")
    figures += [
        Figure(
            f"launch FILE.{name}: first process",
            f"{1000 * walls[name]:.0f} ms (processor time {1000 * used[name]:.0f} ms)",
            f"bare script: {1000 * bare_s:.0f} ms ({1000 * bare_used_s:.0f} ms)",
            # On a busy machine wall times say little.
            used[name] / bare_used_s,
            5.0 if name == "py" else 3.5,
        )
        for name in walls
    ]
