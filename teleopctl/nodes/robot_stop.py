"""Executable ``robot_stop``: holds the robot stopped until its service ``~/release`` is called."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence

from teleopctl.base import progress
from teleopctl.node import (
    ExternalShutdownException,
    Future,
    Node,
    StopButton,
    init,
    spin_until_future_complete,
)


def main(args: Sequence[str] | None = None) -> None:
    """Hold the robot stopped by ``/stop`` until it is released."""
    init(args=args)
    released: Future[None] = Future()
    with Node("robot_stop") as node:
        button = StopButton(node, lambda: released.set_result(None))
        button.press()
        node.get_logger().info("The robot is stopped until 'teleopctl stop --robot --release'")
        progress.report(progress.READY)
        with contextlib.suppress(ExternalShutdownException):
            spin_until_future_complete(node, released)
