"""Publisher to subscriber between two processes, against raw Zenoh in Python.

A message of the given size goes over and a small answer comes back; both sides of a pair are timed
in turn in the same run, and the ratio of the medians is what counts.
"""

import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from tests.benchmarks import echo_peers

STRING, IMAGE = "std_msgs/msg/String", "sensor_msgs/msg/Image"
# Size of the payload in bytes, type, round trips.
CASES = [(64, STRING, 3000), (1024, STRING, 3000), (2304 * 1296 * 3, IMAGE, 60)]


class Partner:
    """The echo process."""

    def __init__(self, kind, type_name, env):
        import os

        self._process = subprocess.Popen(
            [sys.executable, str(Path(echo_peers.__file__)), kind, type_name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **env},
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"

    def stop(self):
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait(10)
        self._process.stdout.close()


def raw_round_trip(size, _):
    session = echo_peers.open_raw()
    answered = threading.Event()
    publisher = session.declare_publisher(echo_peers.PING_KEY)
    session.declare_subscriber(echo_peers.PONG_KEY, lambda _: answered.set())
    payload = bytes(size)

    def once():
        answered.clear()
        publisher.put(payload)
        return answered.wait(5)

    return once, session.close


def node_round_trip(size, type_name):
    from teleopctl.interfaces.store import get_message
    from teleopctl.node import Context, Node

    context = Context()
    context.init([])
    node = Node("pinger", context=context)
    message_class, empty = get_message(type_name), get_message("std_msgs/msg/Empty")
    answered = threading.Event()
    publisher = node.create_publisher(message_class, "ping", 10)
    node.create_subscription(empty, "pong", lambda _: answered.set(), 10, immediate=True)
    message = message_class(data="x" * (size - 9) if type_name == STRING else bytes(size))

    def once():
        answered.clear()
        publisher.publish(message)
        return answered.wait(5)

    def close():
        node.destroy_node()
        context.try_shutdown()

    return once, close


@pytest.mark.parametrize(("size", "type_name", "rounds"), CASES)
def test_round_trip(ros, monkeypatch, size, type_name, rounds, capsys):
    for name, value in ros.env.items():
        monkeypatch.setenv(name, value)
    sides = {}
    for kind, make in {"raw": raw_round_trip, "node": node_round_trip}.items():
        sides[kind] = (Partner(kind, type_name, ros.env), *make(size, type_name))
    times: dict[str, list[float]] = {kind: [] for kind in sides}
    for _, once, _ in sides.values():
        deadline = time.monotonic() + 10
        while not once():
            assert time.monotonic() < deadline, "the partner does not answer"
        for _ in range(20):
            once()
    for _ in range(rounds):
        for kind, (_, once, _) in sides.items():
            start = time.perf_counter()
            assert once()
            times[kind].append(time.perf_counter() - start)
    for partner, _, close in sides.values():
        close()
        partner.stop()
    medians = {kind: statistics.median(values) * 1e6 for kind, values in times.items()}
    with capsys.disabled():
        print(
            f"\n{size:>8} B: raw {medians['raw']:8.0f} us, node {medians['node']:8.0f} us, "
            f"ratio {medians['node'] / medians['raw']:.2f}"
        )
