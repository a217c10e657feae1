"""Which topics are recorded: the rules of rosbag2's recorder, with the actions of its Lyrical."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace

from teleopctl.bag.service_events import is_service_event, service_of
from teleopctl.errors import UsageError
from teleopctl.wire import Graph, is_hidden_name

_ACTION_TOPIC = re.compile(
    r"(?P<action>.+)/_action/"
    r"(feedback|status|(send_goal|cancel_goal|get_result)/_service_event)"
)


@dataclass(frozen=True)
class Selection:
    """Selection of the topics, services and actions to record.

    Services are recorded by the events that introspection publishes of them, actions by their
    feedback, their status and the events of their services. A regular expression is searched for
    anywhere in a name; what is excluded is excluded whatever chose it.

    Attributes:
        all_topics: Every topic that is not hidden.
        all_services: Every service.
        all_actions: Every action.
        topics: Names of topics.
        services: Names of services.
        actions: Names of actions.
        topic_types: Types of topics.
        regex: For names of topics, services and actions; an empty one chooses none.
        exclude_regex: What it is found in is not recorded; an empty one excludes none.
        exclude_topics: Names of topics.
        exclude_topic_types: Types of topics.
        exclude_services: Names of services.
        exclude_actions: Names of actions.
        static_topics: Topics with their types, which are subscribed to before anybody publishes.
        include_hidden_topics: Whether names with a part that starts with ``_`` count.
        include_unpublished_topics: Whether topics without a publisher are subscribed to.
        ignore_leaf_topics: Whether topics that nobody else subscribes to are left out.
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
                raise UsageError(f"{pattern!r} is no regular expression: {error}") from error

    @property
    def is_empty(self) -> bool:
        """Return whether nothing can ever be selected."""
        everything = self.all_topics or self.all_services or self.all_actions
        named = self.topics or self.services or self.actions or self.topic_types
        return not (everything or named or self.regex or self.static_topics)

    def with_absolute_names(
        self, topic: Callable[[str], str], service: Callable[[str], str]
    ) -> Selection:
        """Return the selection with fully qualified names.

        Args:
            topic: Resolves the name of a topic.
            service: Resolves that of a service or an action.
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
        """Return whether a topic is selected by name and type."""
        action = _ACTION_TOPIC.fullmatch(topic)
        is_static = topic in self.static_topics
        if action is not None:
            return self._chooses_named(
                action["action"], self.all_actions or is_static, self.actions, self.exclude_actions
            )
        if is_service_event(topic, type_name):
            service, _ = service_of(topic, type_name)
            return self._chooses_named(
                service, self.all_services or is_static, self.services, self.exclude_services
            )
        everything = self.all_topics or is_static
        return (
            (type_name in self.topic_types and not self._excludes(topic, self.exclude_topics))
            or self._chooses_named(topic, everything, self.topics, self.exclude_topics)
        ) and type_name not in self.exclude_topic_types

    def takes_hidden(self, topic: str, type_name: str) -> bool:
        """Return whether the rules for hidden topics let a topic be recorded."""
        is_own_kind = _ACTION_TOPIC.fullmatch(topic) or is_service_event(topic, type_name)
        return bool(self.include_hidden_topics or is_own_kind) or not is_hidden_name(topic)

    def is_ready(self, topic: str, graph: Graph) -> bool:
        """Return whether a topic has the required publishers and subscribers."""
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
