"""``teleopctl topic list``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.listing import out_names
from teleopctl.cli.live import live_graph
from teleopctl.cli.options import AsJson, CountTopics, HiddenTopics
from teleopctl.cli.verb import Option


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
