"""``ros2cli.node.direct``. Node of a command-line tool."""

import argparse
import os
from types import TracebackType
from typing import Any, Self

import rclpy
from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from rclpy.parameter import Parameter

from ros2cli.node import NODE_NAME_PREFIX

__all__ = ["DEFAULT_TIMEOUT", "DirectNode", "add_arguments"]

DEFAULT_TIMEOUT = 0.5


class DirectNode:
    """Node of a command-line tool, for queries of the graph; a context manager.

    The default context is initialized, and shut down at the end, unless the program has done so.

    Args:
        args: Parsed command line; its attributes ``argv``, ``node_name_suffix``, ``use_sim_time``
            and ``start_parameter_services`` apply if there are any. No time is needed for
            discovery, so that ``spin_time`` does not.
        node_name: Name of the node; made of the process's number if None.

    Attributes:
        node: The `Node`, whose attributes this object has too.
    """

    def __init__(self, args: object, *, node_name: str | None = None) -> None:
        self._owns_context = not rclpy.ok()
        if self._owns_context:
            rclpy.init(args=getattr(args, "argv", []))
        suffix = getattr(args, "node_name_suffix", f"_{os.getpid()}")
        sim_time = Parameter("use_sim_time", value=getattr(args, "use_sim_time", False))
        self.node = rclpy.create_node(
            node_name or f"{NODE_NAME_PREFIX}{suffix}",
            start_parameter_services=getattr(args, "start_parameter_services", False),
            parameter_overrides=[sim_time],
        )

    def get_action_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return the actions of the graph with their types."""
        return get_action_names_and_types(self.node)

    def get_action_client_names_and_types_by_node(
        self, remote_node_name: str, remote_node_namespace: str
    ) -> list[tuple[str, list[str]]]:
        """Return the actions that a node has clients of, with their types."""
        return get_action_client_names_and_types_by_node(
            self.node, remote_node_name, remote_node_namespace
        )

    def get_action_server_names_and_types_by_node(
        self, remote_node_name: str, remote_node_namespace: str
    ) -> list[tuple[str, list[str]]]:
        """Return the actions that a node serves, with their types."""
        return get_action_server_names_and_types_by_node(
            self.node, remote_node_name, remote_node_namespace
        )

    def __getattr__(self, name: str) -> Any:  # Any: an attribute of the node
        return getattr(self.node, name)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.node.destroy_node()
        if self._owns_context:
            rclpy.try_shutdown()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `DirectNode` to a command line."""
    parser.add_argument(
        "--spin-time",
        type=float,
        default=DEFAULT_TIMEOUT,
        help="Accepted and without effect: the graph is known at once.",
    )
    parser.add_argument("-s", "--use-sim-time", action="store_true", help="Follow simulated time.")
