"""Options of a player, with the selection of the topics, services and actions to play."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from teleopctl.bag.topic_kinds import TopicKind, kind_of
from teleopctl.errors import UsageError
from teleopctl.node import QoSProfile


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

    def with_absolute_names(self, expand: Callable[[str], str]) -> PlaySelection:
        """Return the selection with its names made absolute by a function."""

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
        """Return whether a topic of a bag, given by name and type, is played.

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


MessageOrder = Literal["received", "sent"]
RequestSource = Literal["service_introspection", "client_introspection"]


@dataclass(frozen=True)
class PlayOptions:
    """Options of a player; the defaults are those of ``ros2 bag play``.

    Attributes:
        rate: Seconds of the bag per second.
        loop: Begin anew at the end, for ever.
        delay_s: Seconds to wait before each beginning.
        start_offset_ns: Begin so far behind the bag's start.
        duration_ns: Play so much of the bag; None for all.
        until_ns: Play up to this time, in nanoseconds since the epoch; None for all. With both,
            the later of the two counts.
        is_paused: Begin paused.
        selection: Which topics are played.
        qos_overrides: Quality of service by topic, instead of what was recorded.
        clock_hz: Publish ``/clock`` so many times a second; None for not.
        clock_topics: Publish ``/clock`` with each message of these topics; None for all topics.
        is_lossless: Wait for subscribers that are slow, where a topic is reliable; else what they
            have no room for is lost to them, as with any publisher.
        read_ahead: How many messages are read before they are due.
        message_order: Whether messages come when they were received, or when they were sent.
        publishes_requests: Send the requests that services had, instead of their events.
        sends_actions: Send the requests that actions had, instead of their topics.
        request_source: Which events of services count for that.
    """

    rate: float = 1.0
    loop: bool = False
    delay_s: float = 0.0
    start_offset_ns: int = 0
    duration_ns: int | None = None
    until_ns: int | None = None
    is_paused: bool = False
    selection: PlaySelection = field(default_factory=PlaySelection)
    qos_overrides: Mapping[str, QoSProfile] = field(default_factory=dict)
    clock_hz: float | None = None
    clock_topics: tuple[str, ...] | None = ()
    is_lossless: bool = False
    read_ahead: int = 1000
    message_order: MessageOrder = "received"
    publishes_requests: bool = False
    sends_actions: bool = False
    request_source: RequestSource = "service_introspection"
