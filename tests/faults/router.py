"""Kills the router, starts it again, and takes the time until all nodes are seen through it.

``python -m tests.faults.router [--count N] [--nodes N]``
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import statistics
import subprocess
import sys
import time

from teleopctl.wire import find_router, open_session, query_graph
from tests.faults.isolation import own_graph, teleopctl

_LONGEST_S = 20.0


def seconds_until_seen(names: set[str]) -> float:
    """Return the seconds until a new session finds all nodes, or until the time limit."""
    began_s = time.monotonic()
    while time.monotonic() - began_s < _LONGEST_S:
        with open_session("client") as session:
            if names <= set(query_graph(session).node_names()):
                break
    return time.monotonic() - began_s


def main() -> None:
    """Kill and restart the router ``--count`` times, and print how long discovery takes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--nodes", type=int, default=3)
    parser.add_argument("--down", type=float, default=8.0, help="longest time without a router")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    with own_graph():
        names = {f"/node{number}" for number in range(options.nodes)}
        command = [sys.executable, "-m", "teleopctl", "run", "teleop_py_pkg", "simple_subscriber"]
        processes = [
            subprocess.Popen([*command, "--ros-args", "-r", f"__node:={name[1:]}"])
            for name in names
        ]
        try:
            seconds_until_seen(names)
            times_s = []
            for _ in range(options.count):
                record = find_router()
                assert record is not None, "the router has ended"
                os.kill(record.pid, signal.SIGKILL)
                time.sleep(chance.uniform(0.0, options.down))
                teleopctl("daemon", "start")
                times_s.append(seconds_until_seen(names))
                print(f"{times_s[-1]:.2f} s", flush=True)
        finally:
            for process in processes:
                process.terminate()
                process.wait()
    print(
        f"median {statistics.median(times_s):.2f} s, worst {max(times_s):.2f} s, "
        f"{sum(each > 2 for each in times_s)} of {len(times_s)} more than 2 s"
    )


if __name__ == "__main__":
    main()
