"""Draw what the terminal's commands draw: ``python docs/images/make_graphs.py [NAME…]``.

Each picture is made by the command that its page has, in a graph of its own.
"""

from __future__ import annotations

import io
import os
import pty
import re
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.text import Text

from teleopctl.testing import RosGraph

FOLDER = Path(__file__).parent
COLUMNS, LINES = 92, 22
# Goes back over what stands on the terminal, to draw it anew.
AGAIN = re.compile(r"(?:\x1b\[\d*[AK]|\r)+")

FIELDS = "position[0],position[1],position[2]"
POINTS = ", ".join(
    f"{{positions: {list(positions)}, time_from_start: {{sec: {second}}}}}"
    for second, positions in enumerate(((0.7, -0.5, 0.5), (-0.6, 0.3, -0.4), (0.2, 0.0, 0.1)), 2)
)


def command(ros: RosGraph, *words: str) -> str:
    """Run ``teleopctl`` to its end, and return what it has printed."""
    done = ros.run([*words], 60)
    if done.returncode:
        raise SystemExit(f"{words}: {done.stdout}{done.stderr}")
    return done.stdout


def display(ros: RosGraph, file: Path) -> None:
    """The nodes and topics of ``display.yaml``."""
    command(ros, "launch", "-d", "display.yaml")
    command(ros, "graph", "--show", "all", "--svg", str(file))


def chatter(ros: RosGraph, file: Path) -> None:
    """The publisher and the subscriber of the tutorial."""
    command(ros, "run", "-d", "simple_publisher")
    command(ros, "run", "-d", "simple_subscriber")
    command(ros, "graph", "--svg", str(file))


def greeter(ros: RosGraph, file: Path) -> None:
    """Two talkers and a listener, as the launch file of the page on nodes starts them."""
    names = ["--ros-args", "-r", "__ns:=/party", "-r", "chatter:=/words", "-r"]
    for name in ("host", "guest"):
        command(ros, "run", "-d", "simple_publisher", *names, f"__node:={name}")
    command(ros, "run", "-d", "simple_subscriber", "--ros-args", "-r", "chatter:=/words")
    command(ros, "graph", "--svg", str(file))


def frames(ros: RosGraph, file: Path) -> None:
    """The frames of the robot that the page on one's own robot has."""
    page = (FOLDER.parent / "own_robot.md").read_text(encoding="utf-8")
    urdf = "<robot" + page.partition("<robot")[2].partition("```")[0]
    (ros.folder / "head.urdf").write_text(urdf, encoding="utf-8")
    command(ros, "launch", "-d", "display.yaml", "model:=head.urdf")
    command(ros, "tf", "view_frames", "-t", "2", "-o", str(file.with_suffix("")))
    file.with_suffix(".gv").unlink()


def plot(ros: RosGraph, file: Path) -> None:
    """Three joints over time, on a terminal, while the arm moves."""
    command(ros, "launch", "-d", "sim.yaml", "camera:=false")
    topic = ["/arm_controller/joint_trajectory", "trajectory_msgs/msg/JointTrajectory"]
    joints = "joint_names: [joint_1, joint_2, joint_3]"
    ros.spawn(["topic", "pub", "--once", *topic, f"{{{joints}, points: [{POINTS}]}}"])
    drawn = b""

    def keep(terminal: int) -> bytes:
        nonlocal drawn
        drawn += (said := os.read(terminal, 65536))
        return said

    os.environ.pop("NO_COLOR", None)
    os.environ |= {"COLUMNS": str(COLUMNS), "LINES": str(LINES), "TERM": "xterm-256color"}
    words = ["topic", "echo", "/joint_states", "--plot", FIELDS]
    pty.spawn(
        [sys.executable, "-m", "teleopctl", *words, "--window", "5", "--timeout", "4.5"], keep
    )
    whole = drawn.decode()
    start = max(match.end() for match in re.finditer(r"\x1b\[\d*A", whole))
    console = Console(record=True, width=COLUMNS, file=io.StringIO(), force_terminal=True)
    console.print(Text.from_ansi(AGAIN.sub("", whole[start:])))
    file.write_text(console.export_svg(title=f"teleopctl {' '.join(words)}"), encoding="utf-8")


PICTURES: dict[str, Callable[[RosGraph, Path], None]] = {
    "graph_display": display,
    "graph_chatter": chatter,
    "graph_greeter": greeter,
    "frames_head": frames,
    "plot": plot,
}

if __name__ == "__main__":
    for wanted in sys.argv[1:] or PICTURES:
        picture = FOLDER / f"{wanted}.svg"
        with tempfile.TemporaryDirectory() as folder, RosGraph(Path(folder)) as graph:
            PICTURES[wanted](graph, picture)
        sys.stdout.write(f"{picture}: {picture.stat().st_size} bytes\n")
