"""``ros2node.api``. Nodes of the graph, and the endpoints of each."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from rclpy.node import HIDDEN_NODE_PREFIX
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from ros2cli.helpers import wait_for

__all__ = [
    "INFO_NONUNIQUE_WARNING_TEMPLATE",
    "NodeName",
    "TopicInfo",
    "get_absolute_node_name",
    "get_action_client_info",
    "get_action_server_info",
    "get_node_names",
    "get_publisher_info",
    "get_service_client_info",
    "get_service_server_info",
    "get_subscriber_info",
    "get_topics",
    "has_duplicates",
    "parse_node_name",
    "wait_for_node",
]

INFO_NONUNIQUE_WARNING_TEMPLATE = (
    'There are {num_nodes} nodes in the graph with the exact name "{node_name}". '
    "You are seeing information about only one of them."
)


class NodeName(NamedTuple):
    """Name, namespace and fully qualified name of a node."""

    name: str
    namespace: str
    full_name: str


class TopicInfo(NamedTuple):
    """Name of a topic, service or action, and its types."""

    name: str
    types: list[str]


def get_absolute_node_name(node_name: str) -> str | None:
    """Return a node's name with a slash in front; None for an empty one."""
    if not node_name:
        return None
    return node_name if node_name.startswith("/") else f"/{node_name}"


def parse_node_name(node_name: str) -> NodeName:
    """Return the parts of a node's name."""
    full_name = node_name if node_name.startswith("/") else f"/{node_name}"
    namespace, _, name = full_name.rpartition("/")
    return NodeName(name, namespace or "/", full_name)


def has_duplicates(values: Iterable[str]) -> bool:
    """Return whether a value is there twice."""
    listed = list(values)
    return len(set(listed)) < len(listed)


# Any, here and below: a Node, or a node of ros2cli.


def get_node_names(*, node: Any, include_hidden_nodes: bool = False) -> list[NodeName]:
    """Return the names of the nodes of the graph."""
    return [
        NodeName(name, namespace, f"{namespace.rstrip('/')}/{name}")
        for name, namespace in node.get_node_names_and_namespaces()
        if include_hidden_nodes or not name.startswith(HIDDEN_NODE_PREFIX)
    ]


def wait_for_node(
    node: Any, node_name: str, include_hidden_nodes: bool = False, timeout: float = 1.0
) -> bool:
    """Wait until a node is in the graph; return False at the end of a timeout in seconds."""

    def is_there() -> bool:
        names = get_node_names(node=node, include_hidden_nodes=include_hidden_nodes)
        return node_name in {name.full_name for name in names}

    return wait_for(is_there, timeout)


def get_topics(
    remote_node_name: str,
    func: Callable[[str, str], list[tuple[str, list[str]]]],
    *,
    include_hidden_topics: bool = False,
) -> list[TopicInfo]:
    """Return the result of a graph query for a node, by its name and namespace."""
    remote = parse_node_name(remote_node_name)
    return [
        TopicInfo(name, types)
        for name, types in func(remote.name, remote.namespace)
        if include_hidden_topics or not topic_or_service_is_hidden(name)
    ]


def get_subscriber_info(
    *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    """Return the topics that a node subscribes to."""
    by_node = node.get_subscriber_names_and_types_by_node
    return get_topics(remote_node_name, by_node, include_hidden_topics=include_hidden)


def get_publisher_info(
    *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    """Return the topics that a node publishes."""
    by_node = node.get_publisher_names_and_types_by_node
    return get_topics(remote_node_name, by_node, include_hidden_topics=include_hidden)


def get_service_client_info(
    *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    """Return the services that a node has clients of."""
    by_node = node.get_client_names_and_types_by_node
    return get_topics(remote_node_name, by_node, include_hidden_topics=include_hidden)


def get_service_server_info(
    *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    """Return the services that a node serves."""
    by_node = node.get_service_names_and_types_by_node
    return get_topics(remote_node_name, by_node, include_hidden_topics=include_hidden)


def get_action_server_info(
    *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    """Return the actions that a node of `DirectNode` or `NodeStrategy` finds a node to serve."""
    by_node = node.get_action_server_names_and_types_by_node
    return get_topics(remote_node_name, by_node, include_hidden_topics=include_hidden)


def get_action_client_info(
    *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    """Return the actions that a node of `DirectNode` or `NodeStrategy` finds clients of."""
    by_node = node.get_action_client_names_and_types_by_node
    return get_topics(remote_node_name, by_node, include_hidden_topics=include_hidden)
