"""Checks of the graph: names, types and quality of service."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from teleopctl.cli.verbs.doctor.finding import Finding, warning
from teleopctl.wire import EndpointToken, EntityKind, Graph

if TYPE_CHECKING:
    from teleopctl.node import QoSCompatibility

# Somebody listens to these, or speaks there, only now and then.
_OFTEN_ALONE = {"/parameter_events", "/rosout"}


def check_topics(graph: Graph) -> Iterator[Finding]:
    """Look for topics to which nobody listens, or on which nobody speaks."""
    for topic, _ in graph.topic_names_and_types():
        if topic in _OFTEN_ALONE:
            continue
        publishers, subscriptions = graph.publishers(topic), graph.subscriptions(topic)
        if publishers and not subscriptions:
            yield warning(f"Publisher without subscriber detected on {topic}.")
        elif subscriptions and not publishers:
            yield warning(f"Subscriber without publisher detected on {topic}.")


def check_nodes(graph: Graph) -> Iterator[Finding]:
    """Look for nodes of one name."""
    for name, count in Counter(graph.node_names()).items():
        if count > 1:
            yield Finding(
                f"{count} nodes are called {name}: their services and parameters are mixed up.",
                f"Give each a name of its own: --ros-args -r __node:={name.rsplit('/', 1)[1]}_2",
            )


def check_types(graph: Graph) -> Iterator[Finding]:
    """Look for topics and services on which not all speak of the same type."""
    for word, names, ends in (
        ("topic", graph.topic_names_and_types(), (graph.publishers, graph.subscriptions)),
        ("service", graph.service_names_and_types(), (graph.servers, graph.clients)),
    ):
        for name, types in names:
            endpoints = [endpoint for end in ends for endpoint in end(name)]
            if len(types) > 1:
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
    """Look for publishers that offer less than a subscription asks for."""
    from teleopctl.node import QoSCompatibility

    for topic, publisher, subscription, verdict, reason in qos_pairs(graph):
        if verdict is not QoSCompatibility.OK:
            kind = "error" if verdict is QoSCompatibility.ERROR else "warning"
            yield warning(
                f"QoS compatibility {kind} found on topic '{topic}': "
                f"{publisher.full_name} and {subscription.full_name}: "
                f"{reason.partition(': ')[2]}",
                "On Zenoh they hear each other, with what the publisher offers; on DDS not at all.",
            )


def qos_pairs(
    graph: Graph,
) -> Iterator[tuple[str, EndpointToken, EndpointToken, QoSCompatibility, str]]:
    """Return each publisher with each subscription of its topic, and whether they fit."""
    from teleopctl.node import QoSProfile, qos_check_compatible

    for topic, _ in graph.topic_names_and_types():
        for publisher in graph.publishers(topic):
            for subscription in graph.subscriptions(topic):
                verdict, reason = qos_check_compatible(
                    QoSProfile.from_wire(publisher.qos), QoSProfile.from_wire(subscription.qos)
                )
                yield topic, publisher, subscription, verdict, reason


def sessions(graph: Graph) -> dict[str, EndpointToken]:
    """Return one parameter service of each session that has one, by the session's identity."""
    found: dict[str, EndpointToken] = {}
    for name, _ in graph.service_names_and_types(include_hidden=True):
        if name.endswith("/get_parameters"):
            for server in graph.servers(name):
                if server.kind is EntityKind.SS:
                    found.setdefault(server.zid, server)
    return found
