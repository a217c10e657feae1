"""A service call and an action's goal between two processes, against raw queries of Zenoh.

The floor of a call is one query and its reply, of the same sizes; that of a goal are the two that
no action can do without, for the goal and for its result. In turn in the same minute.
"""

from __future__ import annotations

import statistics
import sys
import threading
import time
from collections.abc import Callable

import zenoh

from teleopctl.interfaces import get_action, get_service
from teleopctl.node import ActionClient, Context, Node, SingleThreadedExecutor
from teleopctl.testing import RosGraph
from teleopctl.wire import encode_attachment
from tests.benchmarks.call_peers import ACTION, RAW_KEY, SERVICE
from tests.benchmarks.echo_peers import open_raw
from tests.benchmarks.figure import Figure

ROUNDS = 500


def raw_call(session: zenoh.Session) -> None:
    """One query in the way in which a client library has to do it: by callback."""
    answered = threading.Event()

    def receive(_: zenoh.Reply) -> None:
        answered.set()

    session.get(
        RAW_KEY,
        zenoh.handlers.Callback(receive, indirect=False),
        target=zenoh.QueryTarget.ALL_COMPLETE,
        consolidation=zenoh.ConsolidationMode.NONE,
        payload=bytes(20),
        attachment=encode_attachment(1, time.time_ns(), bytes(16)),
    )
    assert answered.wait(10)


def test_calls_against_raw_queries(ros: RosGraph, figures: list[Figure]):
    server = ros.spawn_command([sys.executable, "-m", "tests.benchmarks.call_peers"])
    server.wait_for_line("ready")
    session, context = open_raw(), Context()
    context.init([])
    node = Node("caller", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    service, action = get_service(SERVICE), get_action(ACTION)
    client = node.create_client(service, "/add")
    actions = ActionClient(node, action, "/fibonacci")
    assert client.wait_for_service(20)
    assert actions.wait_for_server(20)

    def call() -> None:
        response = client.call(service.Request(a=1, b=2), 10)
        assert response is not None and response.sum == 3

    def goal() -> None:
        handle = actions.send_goal_async(action.Goal(order=1)).wait_until_answered(10)
        assert handle is not None
        assert handle.get_result_async().wait_until_answered(10) is not None

    works: dict[str, Callable[[], None]] = {
        "query": lambda: raw_call(session),
        "call": call,
        "goal": goal,
    }
    times: dict[str, list[float]] = {name: [] for name in works}
    for number in range(ROUNDS + 20):
        for name, work in works.items():
            start = time.perf_counter()
            work()
            if number >= 20:
                times[name].append(time.perf_counter() - start)
    executor.shutdown()
    node.destroy_node()
    context.shutdown()
    session.close()
    query, called, reached = (statistics.median(times[name]) * 1e6 for name in works)
    figures += [
        Figure("service call", f"{called:.0f} us", f"query: {query:.0f} us", called / query),
        Figure(
            "action goal and result",
            f"{reached:.0f} us",
            f"two queries: {2 * query:.0f} us",
            reached / query / 2,
        ),
    ]
