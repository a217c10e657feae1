"""``ros2action.api``. Actions of the graph."""

from typing import Any

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_names_and_types as _get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from ros2node.api import get_node_names
from rosidl_runtime_py import get_action_interfaces

__all__ = [
    "action_type_completer",
    "get_action_clients_and_servers",
    "get_action_names",
    "get_action_names_and_types",
]

# Any, here and below: a Node, or a node of ros2cli.


def get_action_names_and_types(*, node: Any) -> list[tuple[str, list[str]]]:
    """Return the actions of the graph with their types."""
    return _get_action_names_and_types(_node(node))


def get_action_names(*, node: Any) -> list[str]:
    """Return the names of the actions of the graph."""
    return [name for name, _ in get_action_names_and_types(node=node)]


def get_action_clients_and_servers(
    *, node: Any, action_name: str
) -> tuple[list[tuple[str, list[str]]], list[tuple[str, list[str]]]]:
    """Return the nodes with clients and the nodes with servers of an action, with the types."""
    clients: list[tuple[str, list[str]]] = []
    servers: list[tuple[str, list[str]]] = []
    for remote in get_node_names(node=node, include_hidden_nodes=True):
        place = (_node(node), remote.name, remote.namespace)
        for found, by_node in (
            (clients, get_action_client_names_and_types_by_node),
            (servers, get_action_server_names_and_types_by_node),
        ):
            found += [
                (remote.full_name, types) for name, types in by_node(*place) if name == action_name
            ]
    return clients, servers


def action_type_completer(**_: object) -> list[str]:
    """Return the names of all action types."""
    return [
        f"{package}/{name}" for package, names in get_action_interfaces().items() for name in names
    ]


def _node(node: Any) -> Any:
    """Return the `Node` of a node of ros2cli, or a `Node` itself."""
    return getattr(node, "node", node)
