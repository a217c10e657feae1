"""How a demonstration runs: until Ctrl-C, or until a launch file's shutdown."""

from __future__ import annotations

from collections.abc import Callable

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def run(make_node: Callable[[], Node], args: list[str] | None = None) -> None:
    """Make a node and spin it until Ctrl-C.

    Args:
        make_node: The node's class, or a function that makes it.
        args: Command line; None takes the process's.
    """
    rclpy.init(args=args)
    node = make_node()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end of these nodes
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
