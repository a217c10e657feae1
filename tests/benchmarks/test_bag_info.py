"""How long `bag info` takes beside the shortest script that reads the same file's summary.

Both are processes of their own, one after the other in turn. The size of the file is
`INFO_BAG_MB`, by default small.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from teleopctl.bag import BagWriter, Compression, WriterOptions
from tests.bag.bags import message, topic
from tests.benchmarks.figure import Figure

MEGABYTE = 10**6
ROUNDS = 7

BARE_SUMMARY = """
import sys
from mcap.reader import make_reader
with open(sys.argv[1], "rb") as stream:
    summary = make_reader(stream).get_summary()
print(summary.statistics.message_count, len(summary.chunk_indexes))
"""


def write_large(folder: Path, size: int) -> int:
    """Write a bag of ten topics; return how many messages it has."""
    base = message("/x", 0, data="x" * 100_000)
    with BagWriter(folder, WriterOptions(compression=Compression.NONE)) as writer:
        for number in range(10):
            writer.add_topic(topic(f"/topic_{number}"))
        count = size // len(base.data)
        for number in range(count):
            name, time_ns = f"/topic_{number % 10}", base.log_time_ns + number * 1_000_000
            writer.write(base._replace(topic=name, log_time_ns=time_ns, sequence=number))
    return count


def seconds(command: Sequence[str], told: str) -> float:
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    elapsed = time.perf_counter() - start
    assert told in done.stdout
    return elapsed


def test_bag_info_beside_a_bare_read_of_the_summary(tmp_path, figures: list[Figure]):
    size = int(os.environ.get("INFO_BAG_MB", "50")) * MEGABYTE
    count = write_large(tmp_path / "bag", size)
    info = [sys.executable, "-m", "teleopctl", "bag", "info", str(tmp_path / "bag")]
    bare = [sys.executable, "-c", BARE_SUMMARY, str(tmp_path / "bag" / "bag_0.mcap")]
    ours, floor = [], []
    for _ in range(ROUNDS):
        ours.append(seconds(info, f"Messages:          {count}"))
        floor.append(seconds(bare, str(count)))
    ours_s, floor_s = sorted(ours)[ROUNDS // 2], sorted(floor)[ROUNDS // 2]
    figures.append(
        Figure(
            f"bag info of {size / MEGABYTE:.0f} MB",
            f"{1000 * ours_s:.0f} ms",
            f"bare read of the summary: {1000 * floor_s:.0f} ms",
            ours_s / floor_s,
        )
    )
