"""What the measuring verbs have in common: they listen, and print once a second."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.topic.source import TopicSource

PRINT_PERIOD_S = 1.0
_DEPTH = 10

Arrival = Callable[[TopicSource, Any, float], None]


def listen(
    sources: list[TopicSource], arrive: Arrival, report: Callable[[float], None], *, raw: bool
) -> None:
    """Subscribe to topics until Ctrl-C.

    Args:
        sources: The topics.
        arrive: Called on the transport's thread for each message, with the topic, the message and
            the time of its arrival in seconds of the monotonic clock, so that neither decoding of
            other messages nor printing falsifies the times.
        report: Called once a second with the present time of that clock.
        raw: Hand over bytes instead of messages, which spares the decoding.
    """
    from teleopctl.node import DurabilityPolicy

    with command_node() as node:
        for source in sources:
            qos = source.suited_qos(_DEPTH)
            # What was sent before comes all at once, which says nothing of a rate.
            qos.durability = DurabilityPolicy.VOLATILE

            def receive(message: Any, source: TopicSource = source) -> None:
                arrive(source, message, time.monotonic())

            node.create_subscription(
                source.message_class,
                source.topic,
                receive,
                qos,
                raw=raw,
                immediate=True,
            )
        due = time.monotonic()
        while node.context.ok():
            due += PRINT_PERIOD_S
            time.sleep(max(0.0, due - time.monotonic()))
            report(time.monotonic())
            console.flush()
