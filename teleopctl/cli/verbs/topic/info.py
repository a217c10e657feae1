"""``teleopctl topic info``."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated

from teleopctl.cli import console
from teleopctl.cli.listing import types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import AsJson, TopicName
from teleopctl.cli.verb import Option

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken


def topic_info(
    topic_name: TopicName,
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="Show each publisher and subscriber with its QoS.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Show who publishes and subscribes a topic."""
    topic = absolute_name(topic_name)
    graph = live_graph()
    types = types_of(topic, graph.topic_names_and_types(include_hidden=True), kind="topic")
    publishers, subscriptions = graph.publishers(topic), graph.subscriptions(topic)
    if as_json:
        console.out_json(
            {
                "name": topic,
                "types": list(types),
                "publishers": [_record(endpoint) for endpoint in publishers],
                "subscribers": [_record(endpoint) for endpoint in subscriptions],
            }
        )
    else:
        console.out_lines(_lines(types, publishers, subscriptions, verbose=verbose))
    console.flush()
    _warn_of_mismatch(topic, [*publishers, *subscriptions])


def _lines(
    types: Sequence[str],
    publishers: Sequence["EndpointToken"],
    subscriptions: Sequence["EndpointToken"],
    *,
    verbose: bool,
) -> Iterator[str]:
    end = [""] if verbose else []
    yield from (f"Type: {types[0] if len(types) == 1 else list(types)}", *end)
    for title, endpoints in (("Publisher", publishers), ("Subscription", subscriptions)):
        yield from (f"{title} count: {len(endpoints)}", *end)
        if verbose:
            for endpoint in endpoints:
                yield from _block(endpoint, title.upper())


def _block(endpoint: "EndpointToken", endpoint_type: str) -> list[str]:
    from teleopctl.cli.verbs.topic.qos_text import qos_lines

    return [
        f"Node name: {endpoint.node}",
        f"Node namespace: {endpoint.namespace}",
        f"Topic type: {endpoint.type_name}",
        f"Topic type hash: {endpoint.type_hash}",
        f"Endpoint type: {endpoint_type}",
        f"GID: {endpoint.gid.hex('.')}",
        *qos_lines(endpoint.qos),
        "",
    ]


def _record(endpoint: "EndpointToken") -> dict[str, console.Json]:
    from teleopctl.cli.verbs.topic.qos_text import qos_record

    return {
        "node": endpoint.node,
        "namespace": endpoint.namespace,
        "type": endpoint.type_name,
        "type_hash": endpoint.type_hash,
        "gid": endpoint.gid.hex(),
        "qos": qos_record(endpoint.qos),
    }


def _warn_of_mismatch(topic: str, endpoints: Sequence["EndpointToken"]) -> None:
    """Say what ROS keeps quiet about: ends that differ in type or hash exchange nothing."""
    types = {endpoint.type_name for endpoint in endpoints}
    if len(types) > 1:
        console.warn(
            f"{topic} has more than one type ({', '.join(sorted(types))}); "
            "nothing passes between ends of different types"
        )
    for type_name in sorted(types):
        nodes_by_hash: dict[str, list[str]] = {}
        for endpoint in endpoints:
            if endpoint.type_name == type_name:
                nodes_by_hash.setdefault(endpoint.type_hash, []).append(endpoint.full_name)
        if len(nodes_by_hash) > 1:
            groups = " and ".join(", ".join(sorted(set(nodes))) for nodes in nodes_by_hash.values())
            console.warn(
                f"{topic}: {groups} mean different versions of {type_name} (their type hashes "
                "differ), so nothing passes between them"
            )
