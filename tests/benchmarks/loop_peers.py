"""Loops of the control-loop benchmark, each in a process of its own.

``python loop_peers.py bare SECONDS yes|no`` is a loop in Python that does nothing.
``python loop_peers.py manager SECONDS yes|no ARGUMENT…`` is the controller manager with these ROS
arguments. ``yes|no`` permits real-time priority. For each line on its standard input a process
measures for SECONDS and prints the times at which the periods began, in nanoseconds, as one line of
JSON.
"""

import contextlib
import json
import os
import sys
import threading
import time

PERIOD_NS = 1_000_000
PRIORITY = 50


def bare(seconds: float) -> None:
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    print("ready", flush=True)
    for _ in sys.stdin:
        times = list[int]()
        deadline = begun = time.monotonic_ns()
        while (now := time.monotonic_ns()) < begun + seconds * 1e9:
            times.append(now)
            # As in the control loop: a late period begins at once, the next one on the grid.
            deadline += PERIOD_NS * max(1, (time.monotonic_ns() - deadline) // PERIOD_NS)
            time.sleep(max(0, deadline - time.monotonic_ns()) * 1e-9)
        print(json.dumps(times), flush=True)


def manager(seconds: float, arguments: list[str]) -> None:
    from teleopctl.control.cycle import Cycle
    from teleopctl.nodes import controller_manager

    times = list[int]()
    run = Cycle.run

    def run_and_note(self: Cycle, time_ns: int, steady_ns: int | None = None) -> None:
        times.append(steady_ns or 0)
        run(self, time_ns, steady_ns)

    def answer() -> None:
        for _ in sys.stdin:
            times.clear()
            time.sleep(seconds)
            print(json.dumps(times[:]), flush=True)

    # mypy knows no other way to replace a method; the real loop runs, with its clock.
    setattr(Cycle, "run", run_and_note)  # noqa: B010
    threading.Thread(target=answer, daemon=True).start()
    print("ready", flush=True)
    controller_manager.main(["controller_manager", *arguments])


def refuse(*_: object) -> None:
    raise PermissionError


if __name__ == "__main__":
    kind, seconds_, permitted, *arguments_ = sys.argv[1:]
    if permitted == "no":
        os.sched_setscheduler = refuse
    if kind == "bare":
        bare(float(seconds_))
    else:
        manager(float(seconds_), arguments_)
