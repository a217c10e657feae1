"""``teleopctl topic type`` and ``teleopctl topic find``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli.listing import of_type, out_names, out_types, types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import AsJson, CountTopics, HiddenTopics, TopicName
from teleopctl.cli.verb import Argument


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
    found = of_type(message_type, topics, kind="msg")
    out_names(found, only_count=count_topics, as_json=as_json)
