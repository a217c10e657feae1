"""Many nodes in one process, for a large graph: ``python graph_peers.py PREFIX COUNT``.

Each node has the nine endpoints of every node and one more publisher. The program prints ``ready``
when all nodes are announced, and ends when its standard input closes.
"""

from __future__ import annotations

import sys
import threading

from teleopctl.interfaces import get_message
from teleopctl.node import Context, Node, SingleThreadedExecutor


def main(prefix: str, count: int) -> None:
    string = get_message("std_msgs/msg/String")
    context = Context()
    context.init([])
    executor = SingleThreadedExecutor(context=context)
    for number in range(count):
        node = Node(f"{prefix}_{number}", context=context)
        node.create_publisher(string, "~/state", 10)
        executor.add_node(node)

    def end_with_stdin() -> None:
        sys.stdin.read()
        executor.shutdown()

    threading.Thread(target=end_with_stdin, daemon=True).start()
    print("ready", flush=True)
    executor.spin()
    context.shutdown()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
