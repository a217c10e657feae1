"""Programs of ROS 2's tutorials, under the names of ROS 2's packages, written with rclpy.

Included are the programs of ``demo_nodes_py``, ``action_tutorials_py`` and ``lifecycle_py``, and
those of ``demo_nodes_cpp`` that most tutorials start. They print the same text as in ROS 2.
"""

from __future__ import annotations

from collections.abc import Callable

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def run(make_node: Callable[[], Node], args: list[str] | None = None) -> None:
    """Create a node by ``make_node``, spin the node until Ctrl-C or a shutdown, and destroy it.

    Args:
        make_node: Class of the node, or a function that returns the node.
        args: Command line; None takes ``sys.argv``.
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
