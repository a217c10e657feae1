"""A node's questions about the graph, answered from the tokens that its context follows."""

from __future__ import annotations

import abc
from collections.abc import Callable

from teleopctl.node.context import Context
from teleopctl.wire.graph import Graph
from teleopctl.wire.tokens import EndpointToken, EntityKind

NamesAndTypes = list[tuple[str, list[str]]]


class GraphView(abc.ABC):
    """The part of a node that looks at the graph."""

    _context: Context

    @abc.abstractmethod
    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a topic."""

    def graph(self) -> Graph:
        """Return a snapshot of the whole graph (ours)."""
        return self._context.watcher.snapshot()

    def add_graph_callback(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` after each change of the graph, on the transport's thread (ours)."""
        self._context.on_graph_change(callback)

    def matched(self, kind: EntityKind, name: str, type_name: str) -> list[EndpointToken]:
        """Return the endpoints of a kind, name and type, as rmw_zenoh matches them (ours)."""
        return _matched(self.graph(), kind, name, type_name)

    def wait_for_match(
        self,
        kind: EntityKind,
        name: str,
        type_name: str,
        count: int,
        timeout_s: float | None,
    ) -> bool:
        """Wait by event until so many endpoints match; False when the time ran out (ours)."""
        watcher = self._context.watcher
        return watcher.wait_for(
            lambda graph: len(_matched(graph, kind, name, type_name)) >= count, timeout_s
        )

    def wait_for_subscribers(self, topic: str, count: int, timeout_s: float | None) -> bool:
        """Wait by event until a topic has so many subscriptions, of any type (ours)."""
        name = self.resolve_topic_name(topic)
        return self._context.watcher.wait_for(
            lambda graph: len(graph.subscriptions(name)) >= count, timeout_s
        )

    def matched_publishers(self, topic: str) -> int:
        """Return how many publishers a topic has (ours; same as :meth:`count_publishers`)."""
        return self.count_publishers(topic)

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has."""
        return len(self.get_publishers_info_by_topic(topic_name))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has."""
        return len(self.get_subscriptions_info_by_topic(topic_name))

    def get_publishers_info_by_topic(self, topic_name: str) -> list[EndpointToken]:
        """Return the publishers of a topic."""
        return self.graph().publishers(self.resolve_topic_name(topic_name))

    def get_subscriptions_info_by_topic(self, topic_name: str) -> list[EndpointToken]:
        """Return the subscriptions of a topic."""
        return self.graph().subscriptions(self.resolve_topic_name(topic_name))

    def get_topic_names_and_types(self) -> NamesAndTypes:
        """Return all topics with their types, hidden ones included."""
        return self.graph().topic_names_and_types(include_hidden=True)

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return all services with their types, hidden ones included."""
        return self.graph().service_names_and_types(include_hidden=True)

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes, without namespaces."""
        return [node.name for node in self.graph().nodes]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return the names and namespaces of all nodes."""
        return [(node.name, node.namespace) for node in self.graph().nodes]

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return what a node publishes."""
        return self._of_node(EntityKind.MP, node_name, node_namespace)

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return what a node subscribes to."""
        return self._of_node(EntityKind.MS, node_name, node_namespace)

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return what a node serves."""
        return self._of_node(EntityKind.SS, node_name, node_namespace)

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return whose client a node is."""
        return self._of_node(EntityKind.SC, node_name, node_namespace)

    def _of_node(self, kind: EntityKind, node_name: str, namespace: str) -> NamesAndTypes:
        types: dict[str, set[str]] = {}
        for token in self.graph().endpoints:
            if (token.kind, token.node, token.namespace) == (kind, node_name, namespace):
                types.setdefault(token.name, set()).add(token.type_name)
        return [(name, sorted(types[name])) for name in sorted(types)]


def _matched(graph: Graph, kind: EntityKind, name: str, type_name: str) -> list[EndpointToken]:
    of_kind = {
        EntityKind.MP: graph.publishers,
        EntityKind.MS: graph.subscriptions,
        EntityKind.SS: graph.servers,
        EntityKind.SC: graph.clients,
    }[kind]
    return of_kind(name, type_name)
