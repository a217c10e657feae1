"""Nodes in a program, and snapshots of the ROS graph."""

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
    """Yield a node that runs until the end of the ``with`` block; a thread runs its callbacks.

    The node has rclpy's methods: ``create_publisher``, ``create_subscription``, ``create_client``,
    ``declare_parameter`` and so on. An exception in a callback stops the callbacks and is raised at
    the end of the block.

    Args:
        name: Name of the node.
        namespace: Namespace of the node, such as ``/left``.

    Raises:
        UsageError: A name is malformed.
        RouterNotRunning: No router answers, and the configuration needs one.

    Example:
        >>> with open_node("watcher", namespace="/left") as node:
        ...     node.get_fully_qualified_name()
        '/left/watcher'
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
        except Exception as error:  # noqa: BLE001 -- any exception of a callback
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
    """Yield a snapshot of the ROS graph now and after each change.

    Several changes during the loop's body are in one snapshot. The graph is that of
    ``ROS_DOMAIN_ID``. Leave the loop to stop; Ctrl-C interrupts it.

    Raises:
        RouterNotRunning: No router answers, and the configuration needs one.

    Example:
        >>> for graph in watch_graph():
        ...     print(graph.node_names())
        ...     break
        ['/talker']
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
