"""What may be wished of a player."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from teleopctl.bag.player.selection import PlaySelection
from teleopctl.node import QoSProfile

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
