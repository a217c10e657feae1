"""Draw what the terminal's commands draw: ``python docs/images/make_graphs.py [NAME…]``.

Each picture is made by the command that its page has, in a graph of its own.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from teleopctl.testing import RosGraph

FOLDER = Path(__file__).parent


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


PICTURES: dict[str, Callable[[RosGraph, Path], None]] = {
    "graph_display": display,
    "graph_greeter": greeter,
    "frames_head": frames,
}

if __name__ == "__main__":
    for wanted in sys.argv[1:] or PICTURES:
        picture = FOLDER / f"{wanted}.svg"
        with tempfile.TemporaryDirectory() as folder, RosGraph(Path(folder)) as graph:
            PICTURES[wanted](graph, picture)
        sys.stdout.write(f"{picture}: {picture.stat().st_size} bytes\n")
