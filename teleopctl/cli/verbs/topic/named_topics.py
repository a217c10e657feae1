"""The topics that a person names for ``topic echo``: some with their type, some as patterns."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.verbs.topic.source import TopicSource, find_source, find_sources, graph_or_router
from teleopctl.cli.words.patterns import fitting, is_pattern
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.wire import Graph


class NamedTopics:
    """Topics named on a command line.

    Args:
        words: Names of topics, each with its type behind it or not.

    Attributes:
        are_several: More than one topic is meant.
        have_types: The type of each is given, so that none of them has to be there yet.
    """

    def __init__(self, words: Sequence[str]) -> None:
        self._wanted: list[tuple[str, str | None]] = []
        for position, word in enumerate(words):
            # The second word may be anything but a topic: a type that is not one is told as such.
            is_second = position == 1 == len(words) - 1
            is_type = _looks_like_type(word) or (is_second and word[:1] != "/")
            if position and is_type and self._wanted[-1][1] is None:
                self._wanted[-1] = (self._wanted[-1][0], word)
            else:
                self._wanted.append((word, None))
        self.have_types = all(type_name for _, type_name in self._wanted)
        self.are_several = len(self._wanted) > 1 or is_pattern(self._wanted[0][0])

    def only(self) -> str:
        """Return the single topic, or raise.

        Raises:
            UsageError: There are several.
        """
        if self.are_several:
            raise UsageError("Fields of one topic can be drawn, not of several")
        return self._wanted[0][0]

    def sources(self, *, raw: bool, graph: Graph | None = None) -> list[TopicSource]:
        """Return the sources of the topics.

        Args:
            raw: The verb takes bytes, so that their types may be unknown here.
            graph: The graph, where the caller has it.

        Raises:
            TeleopctlError: The only one, or each of them, cannot be listened to.
        """
        if graph is None:
            graph = graph_or_router() if self.have_types else live_graph()
        if not self.are_several:
            name, type_name = self._wanted[0]
            topic = absolute_name(name)
            return [find_source(topic, type_name, graph=graph, takes_type=True, raw=raw)]
        live = [name for name, _ in graph.topic_names_and_types(include_hidden=True)]
        found = {
            topic: type_name
            for name, type_name in self._wanted
            for topic in (fitting(name, live, kind="topic") if is_pattern(name) else [name])
        }
        topics = [(absolute_name(topic), type_name) for topic, type_name in found.items()]
        return find_sources(topics, graph, raw=raw)


def _looks_like_type(word: str) -> bool:
    """Whether it is a package and a name that begins with a capital."""
    package, slash, name = word.replace("/msg/", "/", 1).partition("/")
    return (
        bool(slash)
        and package.isidentifier()
        and package[0].islower()
        and name.isidentifier()
        and name[0].isupper()
    )
