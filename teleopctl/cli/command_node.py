"""The short-lived, hidden node that a verb uses to publish, subscribe and call services."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from teleopctl.node import Context, Node, SignalHandlerOptions


@contextmanager
def command_node(
    *, session_mode: Literal["peer", "client"] = "peer", name: str | None = None
) -> Iterator[Node]:
    """A node named as those of ROS 2's command line, in a session of its own.

    Args:
        session_mode: ``client`` for a single exchange through the router; ``peer`` for a stream,
            which then goes straight from process to process.
        name: Another name.

    Raises:
        RouterNotRunning: A client finds no router.
    """
    context = Context()
    # A command has nothing to put in order: SIGTERM may end it at once, wherever it is.
    context.init(
        [],
        # Its output is the command's, and the import of logging takes longer than some commands.
        initialize_logging=False,
        session_mode=session_mode,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    try:
        with Node(
            name or f"_ros2cli_{os.getpid()}",
            context=context,
            enable_rosout=False,
            start_parameter_services=False,
        ) as node:
            yield node
    finally:
        context.try_shutdown()
