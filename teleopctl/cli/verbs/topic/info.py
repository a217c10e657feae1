"""``teleopctl topic info``."""

from collections.abc import Iterator, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.listing import types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import AsJson, TopicName
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.topic.endpoint_text import (
    endpoint_block,
    endpoint_record,
    warn_of_mismatch,
)
from teleopctl.cli.verbs.topic.qos.pairs import warn_of_qos

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
                "publishers": [endpoint_record(endpoint) for endpoint in publishers],
                "subscribers": [endpoint_record(endpoint) for endpoint in subscriptions],
            }
        )
    else:
        console.out_lines(_lines(types, publishers, subscriptions, verbose=verbose))
    console.flush()
    warn_of_mismatch(topic, [*publishers, *subscriptions])
    warn_of_qos(topic, publishers, subscriptions)


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
                yield from endpoint_block(endpoint, "Topic", title.upper())
