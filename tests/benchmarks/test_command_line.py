"""Commands as whole processes, each against a bare script that does the same with Zenoh.

The script looks into the graph, asks, waits and decodes as the command does; where no graph is
asked, it is a bare interpreter that prints the file. Command and script run in turn in the same
minute, with their bytecode cached as after any installation.
"""

import sys
from pathlib import Path

from teleopctl import load_robot
from teleopctl.testing import RosGraph
from tests.benchmarks.figure import Figure
from tests.benchmarks.processes import times_in_turn

HERE = Path(__file__).parent
# As a shell finds it; `python -m` would load runpy besides.
TELEOPCTL = [sys.executable, str(Path(sys.executable).with_name("teleopctl"))]
ROUNDS = 15
STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
SHOW = "interface show std_msgs/msg/String"

# Command, what the bare script is told (None reads a file), and the ratio that is aimed at.
CASES = [
    ("topic list", "tokens", 2.0),
    ("action list", "tokens", 2.0),
    ("topic echo <Tab>", "tokens", 3.0),
    ("param get /peer rate", "parameter /peer rate", 2.5),
    (f"service call /trigger {TRIGGER}", "trigger /trigger", 3.0),
    ("topic echo --once /chatter", "first /chatter", 3.0),
    (f"topic pub --once /heard {STRING} data: x", "put /heard x", 2.5),
    (SHOW, None, 2.5),
]


def ours(command: str) -> tuple[list[str], dict[str, str]]:
    """The command and the variables by which a shell asks it for completions."""
    words = command.split(" ", 5 if "topic pub" in command else -1)
    if words[-1] != "<Tab>":
        return [*TELEOPCTL, *words], {}
    asked = [*TELEOPCTL, "--", *words[:-1], ""]
    return asked, {"_TELEOPCTL_COMPLETE": "zsh"}


def bare(told: str | None, definition: Path) -> list[str]:
    if told is None:
        return [sys.executable, "-c", f"print(open({str(definition)!r}).read())"]
    return [sys.executable, str(HERE / "bare_commands.py"), *told.split()]


def test_commands_against_bare_scripts(ros: RosGraph, tmp_path: Path, figures: list[Figure]):
    peer = ros.spawn_command([sys.executable, str(HERE / "command_peers.py")])
    peer.wait_for_line("ready")
    definition = tmp_path / "String.msg"
    definition.write_text("string data\n")
    env = ros.env | {"PYTHONPYCACHEPREFIX": str(tmp_path), "PYTHONDONTWRITEBYTECODE": ""}
    for command, told, aim in CASES:
        argv, variables = ours(command)
        pair = {"bare": bare(told, definition), "ours": argv}
        times = times_in_turn(pair, env | variables, ROUNDS)
        a, b = times["ours"], times["bare"]
        figures.append(
            Figure(
                command,
                f"{a.median_wall * 1e3:.0f} ms (ratio of the least "
                f"{a.least_wall / b.least_wall:.2f}, of processor time "
                f"{a.least_processor / b.least_processor:.2f})",
                f"bare script: {b.median_wall * 1e3:.0f} ms",
                a.median_wall / b.median_wall,
                aim,
            )
        )


# Loads the compiled model that the command keeps in the cache, behind two lines of facts on it.
LOADS_MODEL = """
import sys, mujoco{also}
content = open(sys.argv[1], "rb").read().split(b"\\n", 2)[2]
model = mujoco.MjModel.from_binary_path("model", {{"model": content}})
data = mujoco.MjData(model)
mujoco.mj_kinematics(model, data)
print(data.xpos[-1])
"""


def test_kinematics_against_scripts_that_load_the_model(
    ros: RosGraph, tmp_path: Path, figures: list[Figure]
):
    """From the second call on, of a robot's file and of the robot that runs."""
    env = ros.env | {
        "PYTHONPYCACHEPREFIX": str(tmp_path / "bytecode"),
        "PYTHONDONTWRITEBYTECODE": "",
        "XDG_CACHE_HOME": str(tmp_path),
    }
    ros.env["XDG_CACHE_HOME"] = str(tmp_path)
    file = tmp_path / "arm.urdf"
    file.write_text(load_robot("package://teleop_description/urdf/teleop.urdf.xacro").urdf)
    assert ros.run("launch --detach controller.yaml", timeout=60).returncode == 0
    assert ros.run(f"kinematics fk {file}").returncode == 0
    (model,) = (tmp_path / "teleopctl" / "kinematics").iterdir()
    for command, also in (
        (f"kinematics fk {file}", ""),
        ("kinematics fk", ""),
        ("kinematics jacobian", ""),
        ("kinematics ik 0.3 0.9 1.4", ", daqp"),
    ):
        script = [sys.executable, "-c", LOADS_MODEL.format(also=also), str(model)]
        pair = {"bare": script, "ours": [*TELEOPCTL, *command.split()]}
        times = times_in_turn(pair, env, ROUNDS)
        a, b = times["ours"], times["bare"]
        figures.append(
            Figure(
                command.replace(f" {file}", " FILE"),
                f"{a.median_wall * 1e3:.0f} ms (ratio of the least "
                f"{a.least_wall / b.least_wall:.2f}, of processor time "
                f"{a.least_processor / b.least_processor:.2f})",
                f"bare script: {b.median_wall * 1e3:.0f} ms",
                a.median_wall / b.median_wall,
                1.4,
            )
        )
