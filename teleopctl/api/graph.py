"""The live ROS graph, and nodes of a program's own."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

from teleopctl.node import (
    Context,
    ExternalShutdownException,
    Node,
    SignalHandlerOptions,
    SingleThreadedExecutor,
)
from teleopctl.wire import Graph


@contextlib.contextmanager
def open_node(name: str, *, namespace: str = "") -> Iterator[Node]:
    """Start a node whose callbacks run on a thread of their own, until the ``with`` block ends.

    The node has rclpy's methods: ``create_publisher``, ``create_subscription``, ``create_client``,
    ``declare_parameter`` and so on. A callback that raises ends the node with that error.

    Args:
        name: Name of the node.
        namespace: Namespace of the node, such as ``/left``.

    Raises:
        UsageError: A name is malformed.
        RouterNotRunning: No router answers, and the configuration needs one.

    Example:
        >>> from teleopctl import open_node
        >>> with open_node("watcher") as node:
        ...     nodes = node.get_fully_qualified_node_names()
    """
    context = Context()
    context.init([], signal_handler_options=SignalHandlerOptions.NO)
    failures: list[BaseException] = []
    executor = SingleThreadedExecutor(context=context)

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        except Exception as error:  # noqa: BLE001 -- whatever a callback raises
            failures.append(error)

    thread = threading.Thread(target=spin, name=name, daemon=True)
    try:
        node = Node(name, context=context, namespace=namespace)
        executor.add_node(node)
        thread.start()
        yield node
    finally:
        context.try_shutdown()
        if thread.is_alive():
            thread.join()
    if failures:
        raise failures[0]


def watch_graph() -> Iterator[Graph]:
    """Yield a snapshot of the ROS graph now, and another one after each change, without polling.

    Changes that come while the program handles a snapshot are in the next one. The graph is that of
    ``ROS_DOMAIN_ID``. Stop by leaving the loop; Ctrl-C ends the wait too.

    Raises:
        RouterNotRunning: No router answers, and the configuration needs one.

    Example:
        >>> for graph in watch_graph():
        ...     print(graph.node_names(), graph.topic_names_and_types())
        ...     break
    """
    context = Context()
    context.init([], signal_handler_options=SignalHandlerOptions.NO)
    changed = threading.Event()
    try:
        context.on_graph_change(changed.set)
        while True:
            changed.clear()
            yield context.watcher.snapshot()
            changed.wait()
    finally:
        context.try_shutdown()
