"""Questions about the actions of the graph, as rclpy asks them."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire import EntityKind, actions_of

if TYPE_CHECKING:
    from teleopctl.node.graph_view import GraphView, NamesAndTypes


def get_action_names_and_types(node: GraphView) -> NamesAndTypes:
    """Return all actions with their types."""
    return node.graph().action_names_and_types()


def get_action_server_names_and_types_by_node(
    node: GraphView, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions that a node has servers of.

    Raises:
        NodeNameNonExistentError: There is no such node.
    """
    return _of_node(node, EntityKind.MP, remote_node_name, remote_node_namespace)


def get_action_client_names_and_types_by_node(
    node: GraphView, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions that a node has clients of.

    Raises:
        NodeNameNonExistentError: There is no such node.
    """
    return _of_node(node, EntityKind.MS, remote_node_name, remote_node_namespace)


def _of_node(node: GraphView, kind: EntityKind, name: str, namespace: str) -> NamesAndTypes:
    return actions_of(token for token in node.endpoints_of(name, namespace) if token.kind is kind)
