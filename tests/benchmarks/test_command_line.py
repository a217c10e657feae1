"""Commands as whole processes, each against a bare script that does the same with Zenoh.

The script looks into the graph, asks, waits and decodes as the command does; where no graph is
asked, it is a bare interpreter that prints a file, or reads records or YAML. Command and script run
in turn in the same minute, with their bytecode cached as after any installation. The ratio is that
of the least processor times.
"""

import sys
from pathlib import Path

from teleopctl import load_robot
from teleopctl.base.folders import runtime_dir
from teleopctl.testing import RosGraph
from tests import ROOT
from tests.benchmarks.figure import Figure
from tests.benchmarks.processes import times_in_turn

HERE = Path(__file__).parent
# The script that pip writes since 25.0, and uv; that of an older pip imports `re` besides, 4 ms.
SCRIPT = """\
import sys
from teleopctl.__main__ import main
if __name__ == "__main__":
    sys.argv[0] = sys.argv[0].removesuffix(".exe")
    sys.exit(main())
"""
ROUNDS = 15
STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
SHOW = "interface show std_msgs/msg/String"
CONTROLLERS = "controllers /controller_manager/list_controllers"

# Command, what the bare script is told (a file name: it prints the file), and the highest ratio.
CASES = [
    ("topic list", "tokens", 1.3),
    ("action list", "tokens", 1.3),
    ("topic echo <Tab>", "tokens", 1.4),
    ("param get /peer rate", "parameter /peer rate", 1.6),
    ("param set /peer rate 5", "set /peer rate 5", 1.8),
    (f"service call /trigger {TRIGGER}", "trigger /trigger", 1.8),
    ("topic echo --once /chatter", "first /chatter", 1.8),
    (f"topic pub --once /heard {STRING} data: x", "put /heard x", 1.7),
    (SHOW, "String.msg", 1.5),
    ("control list_controllers", CONTROLLERS, 1.8),
    ("control unload_controller <Tab>", CONTROLLERS, 1.8),
    ("daemon status", "tokens", 1.8),
    ("topc list", "String.msg", 1.8),
    ("ps", "processes", 1.8),
    ("launch sim.yaml <Tab>", "yaml", 1.8),
]


def ours(command: str, script: Path | None = None) -> tuple[list[str], dict[str, str]]:
    """The command and the variables by which a shell asks it for completions."""
    program = [sys.executable, *(["-m", "teleopctl"] if script is None else [str(script)])]
    words = command.split(" ", 5 if "topic pub" in command else -1)
    if words[-1] != "<Tab>":
        return [*program, *words], {}
    return [*program, "--", *words[:-1], ""], {"_TELEOPCTL_COMPLETE": "zsh"}


def bare(told: str, folder: Path) -> list[str]:
    """The script that does the same with Python, Zenoh, json and PyYAML alone."""
    if told == "String.msg":
        return [sys.executable, "-c", f"print(open({str(folder / told)!r}).read())"]
    if told == "yaml":
        file = str(ROOT / "teleopctl/share/teleopctl/launch/sim.yaml")
        code = "import sys, yaml; print(yaml.load(open(sys.argv[1]), yaml.CSafeLoader))"
        return [sys.executable, "-c", code, file]
    if told == "processes":
        return [sys.executable, "-c", PROCESSES, str(runtime_dir() / "processes")]
    return [sys.executable, str(HERE / "bare_commands.py"), *told.split()]


# Prints each recorded process that still runs.
PROCESSES = """
import glob, json, sys
for file in glob.glob(sys.argv[1] + "/*.json"):
    record = json.load(open(file))
    started = open(f"/proc/{record['pid']}/stat").read().rpartition(")")[2].split()[19]
    if record["start"][1].endswith(started):
        print(record["name"], record["pid"], record["kind"], *record["command"])
"""


def test_commands_against_bare_scripts(ros: RosGraph, tmp_path: Path, figures: list[Figure]):
    peer = ros.spawn_command([sys.executable, str(HERE / "command_peers.py")])
    peer.wait_for_line("ready")
    (tmp_path / "String.msg").write_text("string data\n")
    script = tmp_path / "teleopctl"
    script.write_text(SCRIPT)
    env = ros.env | {"PYTHONPYCACHEPREFIX": str(tmp_path), "PYTHONDONTWRITEBYTECODE": ""}
    # The script would write each line by itself.
    env.pop("PYTHONUNBUFFERED", None)
    for command, told, aim in CASES:
        if command == "control list_controllers":
            assert ros.run("launch --detach controller.yaml", timeout=60).returncode == 0
        argv, variables = ours(command, script)
        pair = {"bare": bare(told, tmp_path), "ours": argv}
        status = 2 if command == "topc list" else 0
        times = times_in_turn(pair, env | variables, ROUNDS, {"ours": status})
        a, b = times["ours"], times["bare"]
        figures.append(
            Figure(
                command,
                f"{a.median_wall * 1e3:.0f} ms (processor time {a.least_processor * 1e3:.0f} ms)",
                f"bare script: {b.median_wall * 1e3:.0f} ms ({b.least_processor * 1e3:.0f} ms)",
                # On a busy machine wall times say little.
                a.least_processor / b.least_processor,
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
        pair = {"bare": script, "ours": [sys.executable, "-m", "teleopctl", *command.split()]}
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
