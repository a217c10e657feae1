"""Snapshots of the ROS graph."""

from __future__ import annotations

import threading
from collections.abc import Iterator

from teleopctl.node import Context, SignalHandlerOptions
from teleopctl.wire import Graph


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
