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

    Exclusions take precedence. Of each kind, all are played if neither names of that kind nor a
    regular expression are given; else those that have one of the names or match the expression.

    Args:
        topics: Names of topics to play.
        services: Names of services whose introspection events are played.
        actions: Names of actions whose topics are played.
        exclude_topics: Names of topics to exclude.
        exclude_services: Names of services to exclude.
        exclude_actions: Names of actions to exclude.
        regex: Regular expression for whole topic names to play; event topics of services end with
            ``/_service_event``.
        exclude_regex: Regular expression for whole topic names to exclude.

    Raises:
        UsageError: A regular expression is invalid.
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
            name: Full name of the topic.
            type_name: Type of the topic.
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
        rate: Seconds of the bag per second of wall time.
        loop: Whether to start again at the end.
        delay_s: Seconds to wait before each start.
        start_offset_ns: Start of the playback, in nanoseconds after the bag's start.
        duration_ns: Duration of the bag to play, in nanoseconds; None for all.
        until_ns: End of the playback, in nanoseconds since the epoch; None for all. With
            `duration_ns`, the later of both ends counts.
        is_paused: Whether to start paused.
        selection: Topics, services and actions to play.
        qos_overrides: QoS profiles by topic, instead of the recorded ones.
        clock_hz: Rate at which ``/clock`` is published, in Hz; None to not publish at a rate.
        clock_topics: Topics before whose messages ``/clock`` is published; None for all topics.
        is_lossless: Whether to wait for slow subscribers of reliable topics; otherwise messages
            that exceed the queue of a subscriber are lost, as with any publisher.
        read_ahead: Number of messages to read before they are due.
        message_order: Order and times of messages: of receipt, or of publication.
        publishes_requests: Whether to send the recorded requests of services, instead of publishing
            the introspection events.
        sends_actions: Whether to send the recorded requests of actions, instead of publishing their
            topics.
        request_source: Side whose introspection events are used to send requests.
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
