"""Servers of the call benchmark: ``python call_peers.py`` serves until its stdin closes.

Plain Zenoh answers queries of `RAW_KEY`. A teleopctl node has the service ``/add`` and the action
``/fibonacci``, whose goals succeed at once.
"""

from __future__ import annotations

import sys
import threading
from typing import Any

from teleopctl.interfaces import get_action, get_service
from teleopctl.node import ActionServer, Node, SingleThreadedExecutor, init, shutdown
from tests.benchmarks.echo_peers import open_raw

RAW_KEY = "benchmark/call"
SERVICE, ACTION = "example_interfaces/srv/AddTwoInts", "example_interfaces/action/Fibonacci"


def main() -> None:
    session = open_raw()
    queryable = session.declare_queryable(
        RAW_KEY,
        lambda query: query.reply(RAW_KEY, query.payload, attachment=query.attachment),
        complete=True,
    )
    init(args=[])
    node = Node("server")
    action = get_action(ACTION)

    def add(request: Any, response: Any) -> Any:
        response.sum = request.a + request.b
        return response

    def execute(goal: Any) -> Any:
        goal.succeed()
        return action.Result(sequence=[0, 1])

    node.create_service(get_service(SERVICE), "/add", add)
    ActionServer(node, action, "/fibonacci", execute)
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def end_with_stdin() -> None:
        sys.stdin.read()
        executor.shutdown()

    threading.Thread(target=end_with_stdin, daemon=True).start()
    print("ready", flush=True)
    executor.spin()
    queryable.undeclare()
    session.close()
    node.destroy_node()
    shutdown()


if __name__ == "__main__":
    main()
