"""Lets nodes work for a while and compares what the process holds before and after.

``python -m tests.faults.soak [--seconds N] [--rate HZ] [--endpoints N]``: messages, service calls
and endpoints that come and go, in one process with two sessions. What is held is printed four
times: the first quarter fills caches, and Zenoh keeps each call for a minute. ``--endpoints 0``
leaves the endpoints that come and go away: Zenoh never forgets the key of one.
"""

from __future__ import annotations

import argparse
import gc
import os
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple

import psutil

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Context, Node, SingleThreadedExecutor
from tests.faults.isolation import own_graph

_STRING = get_message("std_msgs/msg/String")
_ADD = get_service("example_interfaces/srv/AddTwoInts")
_SHARED_MEMORY = Path("/dev/shm")


class Holdings(NamedTuple):
    """Resources of this process: memory, file descriptors, threads, Zenoh's shared memory."""

    rss_mb: float
    descriptors: int
    threads: int
    shared_mb: float


def holdings() -> Holdings:
    """Return the resources of this process after a garbage collection."""
    gc.collect()
    process = psutil.Process()
    shared = sum(file.stat().st_size for file in _SHARED_MEMORY.glob("*.zenoh"))
    return Holdings(
        process.memory_info().rss / 2**20, process.num_fds(), process.num_threads(), shared / 2**20
    )


class Work:
    """Two nodes in two sessions that exchange messages and service calls.

    Args:
        endpoints: Number of rounds after which two endpoints are created and destroyed; 0 for
            never.
    """

    def __init__(self, endpoints: int) -> None:
        self.contexts = [Context(), Context()]
        for context in self.contexts:
            context.init([])
        self.server = Node("server", context=self.contexts[0])
        self.user = Node("user", context=self.contexts[1])
        self.executor = SingleThreadedExecutor(context=self.contexts[0])
        self.executor.add_node(self.server)
        threading.Thread(target=self.executor.spin, daemon=True).start()
        self.server.create_service(_ADD, "add", self._add)
        self.client = self.user.create_client(_ADD, "add")
        assert self.client.wait_for_service(10)
        self.received = 0
        self.server.create_subscription(_STRING, "talk", self._count_message, 10)
        self.talk = self.user.create_publisher(_STRING, "talk", 10)
        self.rounds = 0
        self.gone = 0
        self._every = endpoints

    @staticmethod
    def _add(request: Any, response: Any) -> Any:
        response.sum = request.a + request.b
        return response

    def _count_message(self, _: object) -> None:
        self.received += 1

    def round(self) -> None:
        """Call the service and publish; in some rounds create and destroy two endpoints."""
        future = self.client.call_async(_ADD.Request(a=1, b=2))
        assert future.wait(10), "a call was not answered"
        self.talk.publish(_STRING(data="x" * 1000))
        if self._every and self.rounds % self._every == 0:
            self.user.destroy_publisher(self.user.create_publisher(_STRING, "brief", 10))
            self.user.destroy_client(self.user.create_client(_ADD, "add"))
            self.gone += 2
        self.rounds += 1

    def close(self) -> None:
        """Destroy the nodes and shut down both contexts."""
        for node in (self.server, self.user):
            node.destroy_node()
        for context in self.contexts:
            context.try_shutdown()


def main() -> None:
    """Run the nodes for the time given on the command line, and print their resources."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=240.0)
    parser.add_argument("--rate", type=float, default=0.0, help="rounds a second; 0: no limit")
    parser.add_argument("--endpoints", type=int, default=50, help="rounds until two come and go")
    options = parser.parse_args()
    print(f"pid {os.getpid()}", flush=True)
    with own_graph():
        work = Work(options.endpoints)
        began_s = time.monotonic()
        for quarter in range(1, 5):
            while time.monotonic() - began_s < options.seconds * quarter / 4:
                work.round()
                if options.rate:
                    due_s = began_s + work.rounds / options.rate
                    time.sleep(max(0.0, due_s - time.monotonic()))
            print(
                f"{work.rounds} rounds, {work.received} received, {work.gone} endpoints gone: "
                f"{holdings()}",
                flush=True,
            )
        work.close()
        print(f"after the end: {holdings()}")


if __name__ == "__main__":
    main()
