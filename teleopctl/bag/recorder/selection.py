"""Selection of the topics to record: the rules of rosbag2's recorder, with Lyrical's actions."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from teleopctl.bag.option_file import read_option_list
from teleopctl.bag.records import full_type_name
from teleopctl.bag.topic_kinds import TopicKind, kind_of
from teleopctl.errors import InvalidFileError, UsageError
from teleopctl.wire import Graph, is_hidden_name


@dataclass(frozen=True)
class Selection:
    """Selection of the topics, services and actions that a recorder records.

    Of a service, the introspection events are recorded; of an action, the feedback, the status and
    the introspection events of its services. Regular expressions match anywhere in a name.
    Exclusions take precedence over everything else.

    Attributes:
        all_topics: Whether to record every topic that is not hidden.
        all_services: Whether to record every service.
        all_actions: Whether to record every action.
        topics: Names of topics to record.
        services: Names of services to record.
        actions: Names of actions to record.
        topic_types: Types of topics to record.
        regex: Regular expression for names of topics, services and actions to record; an empty one
            chooses none.
        exclude_regex: Regular expression for names to exclude; an empty one excludes none.
        exclude_topics: Names of topics to exclude.
        exclude_topic_types: Types of topics to exclude.
        exclude_services: Names of services to exclude.
        exclude_actions: Names of actions to exclude.
        static_topics: Type by name of topics that are subscribed to before a publisher exists.
        include_hidden_topics: Whether to record topics with a name part that starts with ``_``.
        include_unpublished_topics: Whether topics without a publisher are subscribed to.
        ignore_leaf_topics: Whether to skip topics without other subscriptions.
    """

    all_topics: bool = False
    all_services: bool = False
    all_actions: bool = False
    topics: Collection[str] = ()
    services: Collection[str] = ()
    actions: Collection[str] = ()
    topic_types: Collection[str] = ()
    regex: str = ""
    exclude_regex: str = ""
    exclude_topics: Collection[str] = ()
    exclude_topic_types: Collection[str] = ()
    exclude_services: Collection[str] = ()
    exclude_actions: Collection[str] = ()
    static_topics: Mapping[str, str] = field(default_factory=dict)
    include_hidden_topics: bool = False
    include_unpublished_topics: bool = False
    ignore_leaf_topics: bool = False

    def __post_init__(self) -> None:
        for pattern in (self.regex, self.exclude_regex):
            try:
                re.compile(pattern)
            except re.error as error:
                raise UsageError(f"{pattern!r} is not a regular expression: {error}") from error

    @property
    def is_empty(self) -> bool:
        """Whether the selection can never choose any topic."""
        everything = self.all_topics or self.all_services or self.all_actions
        named = self.topics or self.services or self.actions or self.topic_types
        return not (everything or named or self.regex or self.static_topics)

    def with_absolute_names(
        self, topic: Callable[[str], str], service: Callable[[str], str]
    ) -> Selection:
        """Return the selection with names made absolute by functions for topics and services.

        Args:
            topic: Function that resolves the name of a topic.
            service: Function that resolves the name of a service or an action.
        """
        return replace(
            self,
            topics=frozenset(map(topic, self.topics)),
            services=frozenset(map(service, self.services)),
            actions=frozenset(map(service, self.actions)),
            static_topics={topic(name): kind for name, kind in self.static_topics.items()},
            exclude_topics=frozenset(map(topic, self.exclude_topics)),
            exclude_services=frozenset(map(service, self.exclude_services)),
            exclude_actions=frozenset(map(service, self.exclude_actions)),
        )

    def chooses(self, topic: str, type_name: str) -> bool:
        """Return whether the selection chooses a topic, by its name and type."""
        kind, name = kind_of(topic, type_name)
        is_static = topic in self.static_topics
        if kind is TopicKind.ACTION:
            return self._chooses_named(
                name, self.all_actions or is_static, self.actions, self.exclude_actions
            )
        if kind is TopicKind.SERVICE:
            return self._chooses_named(
                name, self.all_services or is_static, self.services, self.exclude_services
            )
        everything = self.all_topics or is_static
        return (
            (type_name in self.topic_types and not self._excludes(topic, self.exclude_topics))
            or self._chooses_named(topic, everything, self.topics, self.exclude_topics)
        ) and type_name not in self.exclude_topic_types

    def passes_hidden_rule(self, topic: str, type_name: str) -> bool:
        """Return whether a topic is not hidden, is of a service or action, or may be hidden."""
        kind, _ = kind_of(topic, type_name)
        return (
            self.include_hidden_topics or kind is not TopicKind.TOPIC or not is_hidden_name(topic)
        )

    def is_ready(self, topic: str, graph: Graph) -> bool:
        """Return whether a topic has the publishers and subscribers that the selection requires."""
        needs_publisher = not self.include_unpublished_topics and topic not in self.static_topics
        if needs_publisher and not graph.publishers(topic):
            return False
        return not self.ignore_leaf_topics or bool(graph.subscriptions(topic))

    def _chooses_named(
        self, name: str, everything: bool, names: Collection[str], excluded: Collection[str]
    ) -> bool:
        chosen = (
            everything
            or name in names
            or bool(self.regex and re.search(self.regex, name) is not None)
        )
        return chosen and not self._excludes(name, excluded)

    def _excludes(self, name: str, excluded: Collection[str]) -> bool:
        found = self.exclude_regex and re.search(self.exclude_regex, name) is not None
        return name in excluded or bool(found)


_ROOT = "static_topics_and_types_list"
_EXPECTED = f"The file is a list of pairs: {_ROOT}: [[/chatter, std_msgs/msg/String], …]"


def read_static_topics(path: Path) -> dict[str, str]:
    """Read a ``--static-topics-path`` file; return the type of each topic by name.

    Raises:
        InvalidFileError: The file cannot be read or has another form; names the line.
    """
    topics: dict[str, str] = {}
    for item in read_option_list(path, _ROOT, _EXPECTED):
        pair = item.value
        is_pair = isinstance(pair, list) and len(pair) == 2
        if not is_pair or not all(isinstance(word, str) and word for word in pair):
            raise InvalidFileError(
                f"{item.place}: expected a topic and its type, got {pair!r}",
                hint=_EXPECTED,
            )
        name, type_name = pair
        if name in topics:
            raise InvalidFileError(f"{item.place}: '{name}' is given twice")
        topics[name] = full_type_name(type_name)
    return topics
