"""Interrupts programs once, at chance moments of their start, and looks how they end.

``python -m tests.faults.interrupts [--count N] [--busy N] [subscriber | state | launch | echo]``
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence

from tests.faults.isolation import own_graph

PROGRAMS = {
    "subscriber": ["run", "teleop_py_pkg", "simple_subscriber"],
    # Imports lxml, an extension module that swallows what is raised in a part of its import.
    "state": [
        *("run", "robot_state_publisher", "robot_state_publisher", "--ros-args", "-p"),
        "robot_description:=<robot name='a'><link name='b'/></robot>",
    ],
    "echo": ["topic", "echo", "/chatter", "std_msgs/msg/String"],
    "launch": ["launch", "display.yaml"],
}
# Start time of Python, in seconds: interrupted earlier, Python itself prints a traceback.
_PYTHON_STARTS_S = 0.1
_LATEST_S = {"subscriber": 2.5, "state": 1.0, "echo": 1.5, "launch": 5.0}
_MUST_END_WITHIN_S = 10.0


@contextlib.contextmanager
def busy(processes: int) -> Iterator[None]:
    """Keep processor cores busy with other processes during the ``with`` block."""
    workers = [subprocess.Popen([sys.executable, "-c", "while 1: pass"]) for _ in range(processes)]
    try:
        yield
    finally:
        for worker in workers:
            worker.kill()
            worker.wait()


def interrupt_once(words: Sequence[str], after_s: float) -> tuple[str, str]:
    """Start a program, send SIGINT after a delay; return the outcome and the output on stderr."""
    with subprocess.Popen(
        [sys.executable, "-X", "faulthandler", "-m", "teleopctl", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        time.sleep(after_s)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        try:
            _, said = process.communicate(timeout=_MUST_END_WITHIN_S)
            outcome = "traceback" if "Traceback" in said else f"status {process.returncode}"
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGABRT)  # faulthandler prints the stack of each thread
            _, said = process.communicate()
            with contextlib.suppress(ProcessLookupError):  # the process group may have ended
                os.killpg(process.pid, signal.SIGKILL)
            outcome = "needed a second one"
    return outcome, said


def campaign(name: str, count: int, chance: random.Random) -> collections.Counter[str]:
    """Interrupt a program many times; return outcome counts, print the output of bad outcomes."""
    outcomes: collections.Counter[str] = collections.Counter()
    for _ in range(count):
        after_s = chance.uniform(_PYTHON_STARTS_S, _LATEST_S[name])
        outcome, said = interrupt_once(PROGRAMS[name], after_s)
        outcomes[outcome] += 1
        if not outcome.startswith("status"):
            print(f"--- {name} after {after_s:.3f} s: {outcome}\n{said}", flush=True)
    return outcomes


def main() -> None:
    """Interrupt the programs of the command line; exit status 1 after a bad outcome."""
    parser = argparse.ArgumentParser(description=__doc__)
    # Without a default: argparse compares a whole list with the choices before Python 3.14.
    parser.add_argument("programs", nargs="*", choices=[*PROGRAMS, []])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--busy", type=int, default=2, help="processes that keep processors busy")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    # A process that a script starts in the background ignores SIGINT, and so do its children.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    is_well = True
    with own_graph(), busy(options.busy):
        for name in options.programs or PROGRAMS:
            outcomes = campaign(name, options.count, random.Random(options.seed))
            print(f"{name}: {dict(sorted(outcomes.items()))}", flush=True)
            is_well &= all(outcome.startswith("status") for outcome in outcomes)
    sys.exit(0 if is_well else 1)


if __name__ == "__main__":
    main()
