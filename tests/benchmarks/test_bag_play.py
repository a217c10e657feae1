"""How exactly `bag play` keeps time, and how soon it goes on after a seek.

The error of the spacing is how much the time between two messages differs from that in the bag, by
the publisher's own stamps. Its floor is a bare loop that sleeps until each message is due, in the
same run. The size of the bag for the seek is `SEEK_BAG_MB`, by default small.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

import pytest

from teleopctl.bag import BagMessage, BagWriter, Compression, Player, PlayOptions, WriterOptions
from teleopctl.interfaces import type_hash
from teleopctl.node import MessageInfo, Node, QoSProfile, raw_message_class
from tests.bag.bags import LATCHED, START_NS, STRING, message, topic
from tests.benchmarks.figure import Figure

COUNT = 5000
PERIOD_NS = 1_000_000
MEGABYTE = 10**6
SEEKS = 20

BARE_LOOP = f"""
import time
due = time.monotonic_ns()
for number in range({COUNT}):
    time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
    print(time.time_ns())
    due += {PERIOD_NS}
"""


def spacing_errors_us(times_ns: Sequence[int]) -> tuple[float, float, float]:
    """Median, 99th percentile and maximum of the error of the spacing, in microseconds."""
    errors = sorted(
        abs(later - earlier - PERIOD_NS) / 1000 for earlier, later in itertools.pairwise(times_ns)
    )
    return errors[len(errors) // 2], errors[len(errors) * 99 // 100], errors[-1]


def sent_times_ns(ros, words: Sequence[str], topics: int) -> list[int]:
    """Play a bag in a process of its own; return when its messages were sent."""
    came: list[int] = []
    all_came = threading.Event()

    def hear(_: bytes, info: MessageInfo) -> None:
        came.append(info["source_timestamp"])
        if len(came) == COUNT:
            all_came.set()

    subscriptions = [
        ros.node.create_subscription(
            raw_message_class(STRING, type_hash(STRING)),
            f"/topic_{number}",
            hear,
            QoSProfile(depth=COUNT),
            raw=True,
            immediate=True,
        )
        for number in range(topics)
    ]
    done = ros.run(["bag", "play", *words], 60)
    assert done.returncode == 0, done.stderr
    assert all_came.wait(20), len(came)
    for subscription in subscriptions:
        ros.node.destroy_subscription(subscription)
    return came


@pytest.mark.parametrize("compression", [Compression.NONE, Compression.ZSTD])
def test_spacing_at_a_kilohertz(ros, compression, figures: list[Figure]):
    options = WriterOptions(compression=compression)
    with BagWriter(ros.folder / "bag", options) as writer:
        for number in range(10):
            writer.add_topic(topic(f"/topic_{number}"))
        for number in range(COUNT):
            # As large as the state of an arm.
            writer.write(message(f"/topic_{number % 10}", number, data=f"{number:400}"))
    played = spacing_errors_us(sent_times_ns(ros, ["bag"], 10))
    bare = subprocess.run(
        [sys.executable, "-c", BARE_LOOP], capture_output=True, text=True, check=True
    )
    floor = spacing_errors_us([int(line) for line in bare.stdout.split()])
    text = "p50 {:.0f} us, p99 {:.0f} us, worst {:.0f} us"
    figures.append(
        Figure(
            f"bag play at 1 kHz, compression {compression.value}: errors of the spacing",
            text.format(*played),
            f"bare loop: {text.format(*floor)}",
        )
    )


def test_seek_in_a_large_file(ros, figures: list[Figure]):
    size = int(os.environ.get("SEEK_BAG_MB", "200"))
    block = os.urandom(MEGABYTE)
    with BagWriter(ros.folder / "bag", WriterOptions(compression=Compression.NONE)) as writer:
        writer.add_topic(topic("/map", qos=LATCHED))
        writer.add_topic(topic("/camera"))
        writer.write(message("/map", 0))
        for number in range(size):
            time_ns = START_NS + number * PERIOD_NS
            writer.write(BagMessage("/camera", time_ns, time_ns, block))
    times = seek_times_ms(ros.node, ros.folder / "bag", size)
    result = f"median {times[len(times) // 2]:.1f} ms, worst {times[-1]:.1f} ms"
    figures.append(Figure(f"seek in a bag of {size} MB", result))


def seek_times_ms(node: Node, bag, messages: int) -> list[float]:
    """From the call of a seek until the first message from there is sent, sorted."""
    sent = threading.Event()
    times = []
    options = PlayOptions(is_paused=True)

    def note(played: BagMessage) -> None:
        if played.topic == "/camera":
            sent.set()

    with Player(node, bag, options, on_published=note) as player:
        player.play()
        player.play_next()
        for number in range(SEEKS):
            target = START_NS + (1 + number * 7919 % (messages - 1)) * PERIOD_NS
            sent.clear()
            start_s = time.perf_counter()
            player.seek(target)
            assert player.play_next()
            assert sent.wait(20)
            times.append((time.perf_counter() - start_s) * 1000)
    return sorted(times)
