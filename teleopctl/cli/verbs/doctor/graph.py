"""Checks of the graph: names, types and quality of service."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from teleopctl.cli.verbs.doctor.finding import Finding, warning
from teleopctl.cli.verbs.topic.qos.pairs import ON_ZENOH, QosPair, qos_pairs
from teleopctl.wire import EndpointToken, EntityKind, Graph

# Somebody listens to these, or speaks there, only now and then.
_OFTEN_ALONE = {"/parameter_events", "/rosout"}


def check_topics(graph: Graph) -> Iterator[Finding]:
    """Yield the topics that have only publishers or only subscriptions."""
    for topic, _ in graph.topic_names_and_types():
        if topic in _OFTEN_ALONE:
            continue
        publishers, subscriptions = graph.publishers(topic), graph.subscriptions(topic)
        if publishers and not subscriptions:
            yield warning(f"Publisher without subscriber detected on {topic}.")
        elif subscriptions and not publishers:
            yield warning(f"Subscriber without publisher detected on {topic}.")


def check_nodes(graph: Graph) -> Iterator[Finding]:
    """Yield node names that several nodes have."""
    for name, count in Counter(graph.node_names()).items():
        if count > 1:
            yield Finding(
                f"{count} nodes are called {name}: their services and parameters are mixed up.",
                f"Give each a name of its own: --ros-args -r __node:={name.rsplit('/', 1)[1]}_2",
            )


def check_types(graph: Graph) -> Iterator[Finding]:
    """Yield topics and services with several types."""
    for word, names, ends in (
        ("topic", graph.topic_names_and_types(), (graph.publishers, graph.subscriptions)),
        ("service", graph.service_names_and_types(), (graph.servers, graph.clients)),
    ):
        for name, types in names:
            endpoints = [endpoint for end in ends for endpoint in end(name)]
            # As simulators do that serve Gazebo's programs beside the standard's.
            is_served = word == "service" and all(graph.servers(name, each) for each in types)
            if len(types) > 1 and not is_served:
                yield Finding(
                    f"The {word} {name} has several types: {', '.join(types)}. "
                    f"{_by(endpoints, lambda endpoint: endpoint.type_name)}",
                    "Those of different types do not hear each other: rename one.",
                )
            for type_name in types:
                alike = [each for each in endpoints if each.type_name == type_name]
                # ROS 2 before Jazzy has none, and hears those of every hash.
                hashed = [each for each in alike if each.type_hash.startswith("RIHS")]
                if len({endpoint.type_hash for endpoint in hashed}) > 1:
                    yield Finding(
                        f"The {word} {name} has definitions of {type_name} that differ. "
                        f"{_by(hashed, lambda endpoint: endpoint.type_hash[:14] + '…')}",
                        "Build all with the same version of that package.",
                    )


def _by(endpoints: Sequence[EndpointToken], value: Callable[[EndpointToken], str]) -> str:
    """Say which nodes have which value."""
    nodes: dict[str, set[str]] = {}
    for endpoint in endpoints:
        nodes.setdefault(value(endpoint), set()).add(endpoint.full_name)
    return "; ".join(f"{key}: {', '.join(sorted(names))}" for key, names in sorted(nodes.items()))


def check_qos(graph: Graph) -> Iterator[Finding]:
    """Yield the pairs of publisher and subscription with incompatible QoS."""
    from teleopctl.node import QoSCompatibility

    for topic, pair in pairs_by_topic(graph):
        if pair.verdict is not QoSCompatibility.OK:
            kind = "error" if pair.verdict is QoSCompatibility.ERROR else "warning"
            yield warning(
                f"QoS compatibility {kind} found on topic '{topic}': "
                f"{pair.publisher.full_name} and {pair.subscription.full_name}: {pair.reason}",
                ON_ZENOH,
            )


def pairs_by_topic(graph: Graph) -> Iterator[tuple[str, QosPair]]:
    """Yield each publisher with each subscription of its topic, with the topic."""
    for topic, _ in graph.topic_names_and_types():
        for pair in qos_pairs(graph.publishers(topic), graph.subscriptions(topic)):
            yield topic, pair


def sessions(graph: Graph) -> dict[str, EndpointToken]:
    """Return one parameter service per session."""
    found: dict[str, EndpointToken] = {}
    for name, _ in graph.service_names_and_types(include_hidden=True):
        if name.endswith("/get_parameters"):
            for server in graph.servers(name):
                if server.kind is EntityKind.SS:
                    found.setdefault(server.zid, server)
    return found
