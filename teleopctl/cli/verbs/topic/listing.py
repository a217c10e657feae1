"""``teleopctl topic list``, ``info``, ``type`` and ``find``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Iterator, Sequence
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name, live_graph
from teleopctl.cli.listing import names_of_type, out_names, out_types, types_of
from teleopctl.cli.options import AsJson, CountTopics, HiddenTopics, TopicName
from teleopctl.cli.verb import Argument, Option

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken


def list_topics(
    show_types: Annotated[
        bool, Option("-t", "--show-types", help="Show the type of each topic.")
    ] = False,
    count_topics: CountTopics = False,
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="Show types and numbers of endpoints.")
    ] = False,
    include_hidden: HiddenTopics = False,
    as_json: AsJson = False,
) -> None:
    """List the topics."""
    graph = live_graph()
    topics = graph.topic_names_and_types(include_hidden=include_hidden)
    if as_json:
        console.out_json(
            [
                {
                    "name": name,
                    "types": list(types),
                    "publishers": len(graph.publishers(name)),
                    "subscribers": len(graph.subscriptions(name)),
                }
                for name, types in topics
            ]
        )
    elif verbose and not count_topics:
        published = [(name, types, len(graph.publishers(name))) for name, types in topics]
        subscribed = [(name, types, len(graph.subscriptions(name))) for name, types in topics]
        console.out_lines(_section("Published topics:", published, "publisher"))
        console.out_lines(_section("Subscribed topics:", subscribed, "subscriber"))
    else:
        out_names(topics, only_count=count_topics, show_types=show_types)


def _section(title: str, topics: list[tuple[str, list[str], int]], role: str) -> list[str]:
    lines = [
        f" * {name} [{', '.join(types)}] {count} {role}{'s' if count > 1 else ''}"
        for name, types, count in topics
        if count
    ]
    return [title, *lines, ""]


def topic_info(
    topic_name: TopicName,
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="Show each publisher and subscriber with its QoS.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the types, publishers and subscriptions of a topic."""
    from teleopctl.cli.verbs.topic.endpoints import (
        endpoint_record,
        warn_of_incompatible_qos,
        warn_of_type_mismatch,
    )

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
    warn_of_type_mismatch(topic, [*publishers, *subscriptions])
    warn_of_incompatible_qos(topic, publishers, subscriptions)


def _lines(
    types: Sequence[str],
    publishers: Sequence["EndpointToken"],
    subscriptions: Sequence["EndpointToken"],
    *,
    verbose: bool,
) -> Iterator[str]:
    from teleopctl.cli.verbs.topic.endpoints import endpoint_lines

    end = [""] if verbose else []
    yield from (f"Type: {types[0] if len(types) == 1 else list(types)}", *end)
    for title, endpoints in (("Publisher", publishers), ("Subscription", subscriptions)):
        yield from (f"{title} count: {len(endpoints)}", *end)
        if verbose:
            for endpoint in endpoints:
                yield from endpoint_lines(endpoint, "Topic", title.upper())


def topic_type(topic_name: TopicName, as_json: AsJson = False) -> None:
    """Print the type of a topic."""
    topics = live_graph().topic_names_and_types(include_hidden=True)
    out_types(types_of(absolute_name(topic_name), topics, kind="topic"), as_json=as_json)


def topics_of_type(
    message_type: Annotated[
        str, Argument(help="The message type.", metavar="TYPE", complete="message_types")
    ],
    count_topics: CountTopics = False,
    include_hidden: HiddenTopics = False,
    as_json: AsJson = False,
) -> None:
    """List the topics of a type."""
    topics = live_graph().topic_names_and_types(include_hidden=include_hidden)
    found = names_of_type(message_type, topics, kind="msg")
    out_names(found, only_count=count_topics, as_json=as_json)
