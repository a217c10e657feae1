"""Durations of whole processes; compared processes run in turn, in the same minute.

Wall time is what a user waits for. Processor time (of the process, user and system) is comparable
even if the machine does other work. The minimum of many runs varies least.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import time
from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Times(NamedTuple):
    """Wall and processor time of one process, in seconds."""

    wall: float
    processor: float


class Summary(NamedTuple):
    """Wall and processor times of several runs of one command, in seconds."""

    least_wall: float
    median_wall: float
    least_processor: float


def time_of(
    argv: Sequence[str],
    env: Mapping[str, str],
    output: int = subprocess.DEVNULL,
    status: int = 0,
) -> Times:
    """Run a command and return its wall and processor time; AssertionError for another status."""
    start = time.perf_counter()
    errors = None if status == 0 else subprocess.DEVNULL
    process = subprocess.Popen(argv, env=env, stdout=output, stderr=errors)
    _, ended, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(ended)
    assert process.returncode == status, f"{argv} ended with {process.returncode}"
    return Times(wall, usage.ru_utime + usage.ru_stime)


def times_in_turn(
    commands: Mapping[str, Sequence[str]],
    env: Mapping[str, str],
    rounds: int,
    statuses: Mapping[str, int] | None = None,
) -> dict[str, Summary]:
    """Run each command once per round, in turn, and return a summary for each.

    An additional first round, which writes the bytecode files, does not count. Commands end with
    status 0, or the one in ``statuses``.
    """
    expected = statuses or {}
    taken: dict[str, list[Times]] = {name: [] for name in commands}
    for _ in range(rounds + 1):
        for name, argv in commands.items():
            taken[name].append(time_of(argv, env, status=expected.get(name, 0)))
    return {name: _summary(times[1:]) for name, times in taken.items()}


def _summary(times: list[Times]) -> Summary:
    walls = [each.wall for each in times]
    return Summary(min(walls), statistics.median(walls), min(each.processor for each in times))
