"""``teleopctl topic type`` and ``teleopctl topic find``."""

from typing import Annotated

from teleopctl.cli import console
from teleopctl.cli.live import absolute_name, did_you_mean, live_graph
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.typenames import normalize


def topic_type(
    topic_name: Annotated[str, Argument(help="The topic.", complete="topics")],
) -> None:
    """Print the type of a topic."""
    topic = absolute_name(topic_name)
    topics = dict(live_graph().topic_names_and_types(include_hidden=True))
    if topic not in topics:
        raise TeleopctlError(f"Unknown topic '{topic}'", hint=did_you_mean(topic, topics))
    console.out_lines(topics[topic])


def topics_of_type(
    message_type: Annotated[
        str, Argument(help="The message type.", metavar="TYPE", complete="message_types")
    ],
    count_topics: Annotated[
        bool, Option("-c", "--count-topics", help="Print only how many there are.")
    ] = False,
    include_hidden: Annotated[
        bool,
        Option("--include-hidden-topics", help="List names with a part that starts with _, too."),
    ] = False,
) -> None:
    """List the topics of a type."""
    wanted = normalize(message_type)
    topics = live_graph().topic_names_and_types(include_hidden=include_hidden)
    found = [name for name, types in topics if wanted in types]
    if count_topics:
        console.out(str(len(found)))
    else:
        console.out_lines(found)
