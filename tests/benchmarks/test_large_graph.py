"""Questions about a graph of 200 nodes and 2,000 endpoints, against a graph of a single node.

Each is a whole process. The aim is at most twice the time of the small graph and 100 ms; what Zenoh
itself takes to hand the tokens over stands beside it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from teleopctl.testing import RosGraph
from tests.benchmarks.figure import Figure
from tests.benchmarks.processes import Summary, times_in_turn
from tests.benchmarks.test_command_line import ours

HERE = Path(__file__).parent
ROUNDS = 8
PROCESSES, NODES_EACH = 4, 50

COMMANDS = (
    "topic list",
    "node info /first_0",
    "topic info --verbose /first_0/state",
    "param get /first_0 use_sim_time",
    "topic echo <Tab>",
)


def measured(env: dict[str, str]) -> dict[str, Summary]:
    bare = [sys.executable, str(HERE / "bare_commands.py"), "tokens"]
    times = times_in_turn({"tokens alone": bare}, env, ROUNDS)
    for command in COMMANDS:
        argv, variables = ours(command)
        times |= times_in_turn({command: argv}, env | variables, ROUNDS)
    return times


def test_a_large_graph_against_a_small_one(ros: RosGraph, tmp_path: Path, figures: list[Figure]):
    def start(prefix: str, count: int) -> None:
        peers = [sys.executable, str(HERE / "graph_peers.py"), prefix, str(count)]
        ros.spawn_command(peers).wait_for_line("ready")

    env = ros.env | {"PYTHONPYCACHEPREFIX": str(tmp_path), "PYTHONDONTWRITEBYTECODE": ""}
    start("first", 1)
    small = measured(env)
    for number in range(PROCESSES):
        start(f"fleet{number}", NODES_EACH)
    large = measured(env)
    for command in small:
        before, after = (times[command].median_wall * 1e3 for times in (small, large))
        figures.append(
            Figure(
                f"{command}, 200 nodes",
                f"{after:.0f} ms",
                f"1 node: {before:.0f} ms",
                after / before,
                (2 * before + 100) / before,
            )
        )
