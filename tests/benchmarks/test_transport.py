"""Publisher to subscribers between processes, against raw Zenoh in Python.

One way: a message goes over, and each subscriber answers with the time at which it had it decoded;
the last one counts. Rate: bursts of small messages, of each of which the last is answered. Stream:
processor time of the subscriber's process, at a steady rate. All sides run in turn in the same
minute, and the ratio of the medians is what counts: to raw Zenoh, and to Zenoh that does by hand
what the messages of ROS 2 take (see `echo_peers`).
"""

from __future__ import annotations

import itertools
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import psutil
import pytest

from tests.benchmarks import echo_peers
from tests.benchmarks.figure import Figure

STRING, IMAGE = echo_peers.STRING, "sensor_msgs/msg/Image"
KINDS = ("raw", "hand", "node")
BURST = 50
STREAM_HZ, AT_ONCE = 1000, 5


class Case(NamedTuple):
    size: int
    type_name: str
    rounds: int
    processes: int = 1
    each: int = 1

    @property
    def subscribers(self) -> int:
        return self.processes * self.each


CASES = [
    Case(64, STRING, 2000),
    Case(64, STRING, 800, each=4),
    Case(64, STRING, 300, each=16),
    Case(64, STRING, 500, processes=4),
    Case(1024, STRING, 2000),
    Case(65536, IMAGE, 500),
    Case(2**20, IMAGE, 200),
    Case(2304 * 1296 * 3, IMAGE, 60),
    Case(2304 * 1296 * 3, IMAGE, 30, each=4),
]


class Side:
    """A publisher here, its subscribers in other processes, and their answers.

    Attributes:
        publish: Sends the message once.
    """

    def __init__(self, kind: str, case: Case, every: int) -> None:
        self._answers: list[int] = []
        self._wanted = case.subscribers
        self._all = threading.Event()
        side = {"raw": raw_side, "hand": hand_side, "node": node_side}[kind]
        self.publish, self._close = side(case, self._receive_answer)
        script = str(Path(echo_peers.__file__))
        self._peers = [
            subprocess.Popen(
                [sys.executable, script, kind, case.type_name, str(case.each), str(every)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            for _ in range(case.processes)
        ]
        for peer in self._peers:
            assert peer.stdout is not None
            assert peer.stdout.readline() == "ready\n"
        # Until everybody has met, some answers are missing.
        deadline = time.monotonic() + 20
        while self.seconds(every, 0.5) is None:
            assert time.monotonic() < deadline, "the subscribers do not answer"

    def _receive_answer(self, time_ns: int) -> None:
        self._answers.append(time_ns)
        if len(self._answers) == self._wanted:
            self._all.set()

    def seconds(self, messages: int = 1, longest_s: float = 5.0) -> float | None:
        """Publish, and return how long it took until the last subscriber had the last message."""
        self._answers.clear()
        self._all.clear()
        start = time.monotonic_ns()
        for _ in range(messages):
            self.publish()
        return (max(self._answers) - start) / 1e9 if self._all.wait(longest_s) else None

    def processor_seconds(self) -> float:
        """How long the subscribers' processes have computed so far."""
        times = [psutil.Process(peer.pid).cpu_times() for peer in self._peers]
        return sum(each.user + each.system for each in times)

    def close(self) -> None:
        for peer in self._peers:
            assert peer.stdin is not None and peer.stdout is not None
            peer.stdin.close()
            peer.wait(10)
            peer.stdout.close()
        self._close()


def raw_side(case: Case, hear: Callable[[int], None]):
    session = echo_peers.open_raw()
    publisher = session.declare_publisher(echo_peers.PING_KEY)
    session.declare_subscriber(
        echo_peers.PONG_KEY,
        lambda sample: hear(int.from_bytes(sample.payload.to_bytes(), "little")),
    )
    payload = bytes(case.size)
    return lambda: publisher.put(payload), session.close


def content(case: Case) -> str | bytes:
    return "x" * (case.size - 9) if case.type_name == STRING else bytes(case.size)


def hand_side(case: Case, hear: Callable[[int], None]):
    session = echo_peers.open_raw()
    publisher = session.declare_publisher(echo_peers.HAND_PING_KEY)
    session.declare_subscriber(
        echo_peers.HAND_PONG_KEY,
        lambda sample: hear(int.from_bytes(sample.payload.to_bytes()[4:], "little")),
    )
    message, numbers = content(case), itertools.count(1)

    def publish() -> None:
        attachment = echo_peers.attachment(next(numbers))
        publisher.put(echo_peers.packed(message), attachment=attachment)

    return publish, session.close


def node_side(case: Case, hear: Callable[[int], None]):
    from teleopctl.interfaces.store import get_message
    from teleopctl.node import Context, Node

    context = Context()
    context.init([])
    node = Node("pinger", context=context)
    message_class, when = get_message(case.type_name), get_message("std_msgs/msg/UInt64")
    publisher = node.create_publisher(message_class, "ping", 100)
    node.create_subscription(when, "pong", lambda m: hear(m.data), 100, immediate=True)
    message = message_class(data=content(case))

    def close():
        node.destroy_node()
        context.try_shutdown()

    return lambda: publisher.publish(message), close


def measured(case: Case, messages: int) -> dict[str, float]:
    """Median seconds of each kind."""
    sides = {kind: Side(kind, case, messages) for kind in KINDS}
    times: dict[str, list[float]] = {kind: [] for kind in sides}
    for _ in range(case.rounds):
        for kind, side in sides.items():
            taken = side.seconds(messages)
            assert taken is not None or kind != "node", "a message was lost"
            # Zenoh drops what finds no room on a busy machine, unless it is told otherwise.
            if taken is not None:
                times[kind].append(taken)
    for side in sides.values():
        side.close()
    return {kind: statistics.median(values) for kind, values in times.items()}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_one_way(ros, case, figures: list[Figure]):
    medians = measured(case, 1)
    raw_us, hand_us, node_us = (medians[kind] * 1e6 for kind in KINDS)
    where = f"in {case.processes} processes" if case.processes > 1 else "in one process"
    figures.append(
        Figure(
            f"{case.size} B to {case.subscribers} {where}",
            f"{node_us:.0f} us, {node_us / hand_us:.2f} times the same work by hand",
            f"raw Zenoh: {raw_us:.0f} us",
            node_us / raw_us,
        )
    )


@pytest.mark.parametrize("each", [1, 4])
def test_rate(ros, each, figures: list[Figure]):
    medians = measured(Case(64, STRING, 200, each=each), BURST)
    rates = {kind: BURST / seconds for kind, seconds in medians.items()}
    figures.append(
        Figure(
            f"burst of 64 B to {each}",
            f"{rates['node']:.0f} Hz, time {medians['node'] / medians['hand']:.2f} times the same "
            "work by hand",
            f"raw Zenoh: {rates['raw']:.0f} Hz",
            medians["node"] / medians["raw"],
        )
    )


def test_stream(ros, figures: list[Figure]):
    sides = {kind: Side(kind, Case(64, STRING, 0), BURST) for kind in KINDS}
    shares: dict[str, list[float]] = {kind: [] for kind in sides}
    for _ in range(3):
        for kind, side in sides.items():
            spent_s, start = side.processor_seconds(), time.monotonic()
            for number in range(1, 2 * STREAM_HZ + 1):
                for _ in range(AT_ONCE):
                    side.publish()
                time.sleep(max(0.0, start + number / STREAM_HZ - time.monotonic()))
            taken_s = time.monotonic() - start
            shares[kind].append((side.processor_seconds() - spent_s) / taken_s)
    for side in sides.values():
        side.close()
    raw, hand, node = (statistics.median(shares[kind]) * 100 for kind in KINDS)
    figures.append(
        Figure(
            f"stream of {AT_ONCE} times 64 B at {STREAM_HZ} Hz",
            f"{node:.0f} % of a core, {node / hand:.2f} times the same work by hand",
            f"raw Zenoh: {raw:.0f} % of a core",
            node / raw,
        )
    )
