"""Experiment: a subscriber stopped by SIGSTOP is sent more messages than it can queue.

``python -m tests.faults.frozen`` prints how long the publisher took to end, its exit status and its
output.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import time

from teleopctl.testing import LONGEST_WAIT_S
from tests.faults.isolation import own_graph

_SENDER = """
import time
from teleopctl.interfaces import get_message
from teleopctl.node import Context, Node
with Context() as context, Node("sender", context=context) as node:
    publisher = node.create_publisher(get_message("std_msgs/msg/String"), "chatter", 10)
    assert context.wait_for_graph(lambda graph: bool(graph.subscriptions("/chatter")), 10)
    print("met", flush=True)
    input()
    message = get_message("std_msgs/msg/String")(data="x" * 50_000)
    for _ in range(2000):
        publisher.publish(message)
    print("sent", flush=True)
"""


def main() -> None:
    """Run the experiment once."""
    with own_graph():
        node = subprocess.Popen(
            [sys.executable, "-m", "teleopctl", "run", "teleop_py_pkg", "simple_subscriber"],
            stderr=subprocess.DEVNULL,
        )
        with subprocess.Popen(
            [sys.executable, "-c", _SENDER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as sender:
            assert sender.stdout is not None
            assert sender.stdout.readline() == "met\n"
            node.send_signal(signal.SIGSTOP)
            began_s = time.monotonic()
            said, complained = sender.communicate("\n", timeout=3 * LONGEST_WAIT_S)
        print(f"{time.monotonic() - began_s:.1f} s, status {sender.returncode}: {said}{complained}")
        node.kill()
        node.wait()


if __name__ == "__main__":
    main()
