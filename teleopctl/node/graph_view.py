"""Graph queries of a node, as rclpy's."""

from __future__ import annotations

import abc
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.context import Context
from teleopctl.node.values.exceptions import NameValidationException, NodeNameNonExistentError
from teleopctl.wire import EndpointToken, EntityKind, Graph, actions_of

if TYPE_CHECKING:
    from teleopctl.node.values.endpoint_info import TopicEndpointInfo


NamesAndTypes = list[tuple[str, list[str]]]


class GraphView(abc.ABC):
    """Base of nodes with the methods that query the graph."""

    _context: Context
    _graph_callbacks: list[Callable[[], None]]

    @abc.abstractmethod
    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a topic, remapped unless ``only_expand``."""

    @abc.abstractmethod
    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a service, remapped unless ``only_expand``."""

    def graph(self) -> Graph:
        """Return a snapshot of the ROS graph, with all nodes and endpoints (ours)."""
        return self._context.watcher.snapshot()

    def add_graph_callback(self, callback: Callable[[], None]) -> None:
        """Register a function to call after each graph change, on the reporting thread (ours)."""
        self._graph_callbacks.append(callback)
        self._context.on_graph_change(callback)

    def _remove_graph_callbacks(self) -> None:
        for callback in self._graph_callbacks:
            self._context.forget_on_graph_change(callback)

    def matched(self, kind: EntityKind, name: str, type_name: str | None) -> list[EndpointToken]:
        """Return the endpoints of a kind with a name and a type; None for any type (ours)."""
        return self._context.watcher.matching(kind, name, type_name)

    def wait_for_match(
        self,
        kind: EntityKind,
        name: str,
        type_name: str | None,
        count: int,
        timeout_s: float | None,
    ) -> bool:
        """Block until ``count`` endpoints of name and type exist; False on timeout or shutdown."""
        return self._context.wait_for_change(
            lambda: len(self.matched(kind, name, type_name)) >= count, timeout_s
        )

    def wait_for_subscribers(self, topic: str, count: int, timeout_s: float | None) -> bool:
        """Block until a topic has ``count`` subscriptions; return False on timeout or shutdown."""
        name = self.resolve_topic_name(topic)
        return self._context.wait_for_change(
            lambda: _count(self._context, EntityKind.MS, name) >= count, timeout_s
        )

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has."""
        return _count(self._context, EntityKind.MP, _resolved(self.resolve_topic_name, topic_name))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has."""
        return _count(self._context, EntityKind.MS, _resolved(self.resolve_topic_name, topic_name))

    def count_services(self, service_name: str) -> int:
        """Return how many servers a service has."""
        return _count(
            self._context, EntityKind.SS, _resolved(self.resolve_service_name, service_name)
        )

    def count_clients(self, service_name: str) -> int:
        """Return how many clients a service has."""
        return _count(
            self._context, EntityKind.SC, _resolved(self.resolve_service_name, service_name)
        )

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return descriptions of a topic's publishers; ``no_mangle`` takes the name as it is."""
        name = topic_name if no_mangle else _resolved(self.resolve_topic_name, topic_name)
        return _infos(self.graph().publishers(name))

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return descriptions of a topic's subscriptions; ``no_mangle`` takes the name as it is."""
        name = topic_name if no_mangle else _resolved(self.resolve_topic_name, topic_name)
        return _infos(self.graph().subscriptions(name))

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:  # noqa: ARG002
        """Return the names of all topics, hidden ones included, with their types.

        ``no_demangle`` is unused, for rclpy programs: names on Zenoh are not mangled.
        """
        return self.graph().topic_names_and_types(include_hidden=True)

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return the names of all services, hidden ones included, with their types."""
        return self.graph().service_names_and_types(include_hidden=True)

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes of the graph, without namespaces."""
        return [node.name for node in self.graph().nodes]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return the names and namespaces of all nodes of the graph."""
        return [(node.name, node.namespace) for node in self.graph().nodes]

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Return the names, namespaces and enclaves of all nodes of the graph."""
        return [(node.name, node.namespace, node.enclave) for node in self.graph().nodes]

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return the fully qualified names of all nodes of the graph."""
        return [node.full_name for node in self.graph().nodes]

    def wait_for_node(self, fully_qualified_node_name: str, timeout: float) -> bool:
        """Block until a node is in the graph; return False on timeout (in seconds) or shutdown."""
        return self._context.wait_for_graph(
            lambda graph: graph.find_node(fully_qualified_node_name) is not None, timeout
        )

    def get_publisher_names_and_types_by_node(
        self,
        node_name: str,
        node_namespace: str,
        no_demangle: bool = False,  # noqa: ARG002 (see above)
    ) -> NamesAndTypes:
        """Return the topics that a node publishes, with their types.

        Raises:
            NodeNameNonExistentError: The node is not in the graph.
        """
        return self._of_node(EntityKind.MP, node_name, node_namespace)

    def get_subscriber_names_and_types_by_node(
        self,
        node_name: str,
        node_namespace: str,
        no_demangle: bool = False,  # noqa: ARG002 (see above)
    ) -> NamesAndTypes:
        """Return the topics that a node subscribes to, with their types.

        Raises:
            NodeNameNonExistentError: The node is not in the graph.
        """
        return self._of_node(EntityKind.MS, node_name, node_namespace)

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return the services that a node has servers of, with their types.

        Raises:
            NodeNameNonExistentError: The node is not in the graph.
        """
        return self._of_node(EntityKind.SS, node_name, node_namespace)

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return the services that a node has clients of, with their types.

        Raises:
            NodeNameNonExistentError: The node is not in the graph.
        """
        return self._of_node(EntityKind.SC, node_name, node_namespace)

    def endpoints_of(self, node_name: str, node_namespace: str) -> list[EndpointToken]:
        """Return the liveliness tokens of a node's endpoints; raise if no such node exists (ours).

        Raises:
            NodeNameNonExistentError: The node is not in the graph.
        """
        wanted = (node_name, node_namespace)
        found = [node for node in self.graph().nodes if (node.name, node.namespace) == wanted]
        if not found:
            place = f"{node_namespace.rstrip('/')}/{node_name}"
            raise NodeNameNonExistentError(f"node '{place}' is not in the graph")
        return [token for node in found for token in node.endpoints]

    def _of_node(self, kind: EntityKind, node_name: str, namespace: str) -> NamesAndTypes:
        types: dict[str, set[str]] = {}
        for token in self.endpoints_of(node_name, namespace):
            if token.kind is kind:
                types.setdefault(token.name, set()).add(token.type_name)
        return [(name, sorted(types[name])) for name in sorted(types)]


def _resolved(resolve: Callable[[str], str], name: str) -> str:
    """Return the absolute name of a topic or service; raises ValueError as rclpy does here.

    Raises:
        TypeError: The name is not a string.
        ValueError: The name is malformed.
    """
    if not isinstance(name, str):
        raise TypeError(f"a name must be a str, not {type(name).__name__}")
    try:
        return resolve(name)
    except NameValidationException as error:
        raise ValueError(f"name '{name}' is invalid: {error.error_msg}") from error


def _count(context: Context, kind: EntityKind, name: str) -> int:
    return len(context.watcher.matching(kind, name))


def _infos(tokens: list[EndpointToken]) -> list[TopicEndpointInfo]:
    from teleopctl.node.values.endpoint_info import TopicEndpointInfo

    return [TopicEndpointInfo.of(token) for token in tokens]


def get_action_names_and_types(node: GraphView) -> NamesAndTypes:
    """Return the names of all actions of the graph with their types."""
    return node.graph().action_names_and_types()


def get_action_server_names_and_types_by_node(
    node: GraphView, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the names and types of the actions that a node serves.

    Raises:
        NodeNameNonExistentError: The node is not in the graph.
    """
    return _of_node(node, EntityKind.MP, remote_node_name, remote_node_namespace)


def get_action_client_names_and_types_by_node(
    node: GraphView, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the names and types of the actions that a node has clients of.

    Raises:
        NodeNameNonExistentError: The node is not in the graph.
    """
    return _of_node(node, EntityKind.MS, remote_node_name, remote_node_namespace)


def _of_node(node: GraphView, kind: EntityKind, name: str, namespace: str) -> NamesAndTypes:
    return actions_of(token for token in node.endpoints_of(name, namespace) if token.kind is kind)
