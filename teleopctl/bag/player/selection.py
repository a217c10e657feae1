"""Which topics of a bag are played."""

from __future__ import annotations

import enum
import re
from collections.abc import Callable
from dataclasses import dataclass

from teleopctl.errors import UsageError

SERVICE_EVENT = "/_service_event"
"""What ends the name of the topic on which a service tells of its requests and responses."""

_ACTION_TOPIC = re.compile(
    r"(?P<action>.+)/_action/"
    rf"(?:feedback|status|(?:send_goal|cancel_goal|get_result){SERVICE_EVENT})"
)


class TopicKind(enum.Enum):
    """Kind of a topic: message topic, service event or action."""

    TOPIC = enum.auto()
    SERVICE = enum.auto()
    ACTION = enum.auto()


def kind_of(name: str, type_name: str) -> tuple[TopicKind, str]:
    """Return the kind of a topic, and the name of its topic, service or action."""
    action = _ACTION_TOPIC.fullmatch(name)
    if action:
        return TopicKind.ACTION, action["action"]
    if name.endswith(SERVICE_EVENT) and type_name.endswith("_Event"):
        return TopicKind.SERVICE, name.removesuffix(SERVICE_EVENT)
    return TopicKind.TOPIC, name


@dataclass(frozen=True)
class PlaySelection:
    """Selection of the topics, services and actions to play; by default all.

    What is excluded is never played. Of each kind, all are played if neither names of that kind
    nor an expression are given; else those that have one of the names or fit the expression.

    Args:
        topics: Names of topics.
        services: Names of services whose events are played.
        actions: Names of actions whose topics are played.
        exclude_topics: Likewise not.
        exclude_services: Likewise not.
        exclude_actions: Likewise not.
        regex: A regular expression for the whole name of a topic; one of events ends with
            ``/_service_event``.
        exclude_regex: Likewise not.

    Raises:
        UsageError: An expression is none.
    """

    topics: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()
    exclude_topics: tuple[str, ...] = ()
    exclude_services: tuple[str, ...] = ()
    exclude_actions: tuple[str, ...] = ()
    regex: str = ""
    exclude_regex: str = ""

    def __post_init__(self) -> None:
        for expression in (self.regex, self.exclude_regex):
            try:
                re.compile(expression)
            except re.error as error:
                raise UsageError(f"'{expression}' is not a regular expression: {error}") from error

    def expanded(self, expand: Callable[[str], str]) -> PlaySelection:
        """Return the selection with absolute names."""

        def absolute(names: tuple[str, ...]) -> tuple[str, ...]:
            return tuple(expand(name) for name in names)

        return PlaySelection(
            absolute(self.topics),
            absolute(self.services),
            absolute(self.actions),
            absolute(self.exclude_topics),
            absolute(self.exclude_services),
            absolute(self.exclude_actions),
            self.regex,
            self.exclude_regex,
        )

    def chooses(self, name: str, type_name: str) -> bool:
        """Return whether a topic is played.

        Args:
            name: Its full name.
            type_name: Its type.
        """
        kind, owner = kind_of(name, type_name)
        wanted, unwanted = {
            TopicKind.TOPIC: (self.topics, self.exclude_topics),
            TopicKind.SERVICE: (self.services, self.exclude_services),
            TopicKind.ACTION: (self.actions, self.exclude_actions),
        }[kind]
        if owner in unwanted or (self.exclude_regex and re.fullmatch(self.exclude_regex, name)):
            return False
        if not wanted and not self.regex:
            return True
        return owner in wanted or bool(self.regex and re.fullmatch(self.regex, name))
