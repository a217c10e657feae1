"""``teleopctl topic delay``."""

import threading
import time
from typing import Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.live import absolute_name
from teleopctl.cli.options import TopicName
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.topic.measuring.listening import listen
from teleopctl.cli.verbs.topic.measuring.statistics import Window, delay_text
from teleopctl.cli.verbs.topic.source import TopicSource, find_source
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import to_nanoseconds, to_seconds


def measure_delay(
    topic_name: TopicName,
    window: Annotated[
        int, Option("-w", "--window", help="How many messages the average is taken over.")
    ] = 10000,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a report.")] = False,
) -> None:
    """Measure the age of stamped messages.

    It is the time between a message's header.stamp and its arrival, so that the clocks of both
    machines matter.
    """
    source = find_source(absolute_name(topic_name))
    if "header" not in source.message_class.get_fields_and_field_types():
        raise InvalidMessageError(
            f"{source.message_class.TYPE_NAME} has no header, so its age cannot be told"
        )
    delays = Window(window)
    lock = threading.Lock()

    def arrive(_: TopicSource, message: Any, __: float) -> None:
        delay_s = to_seconds(time.time_ns() - to_nanoseconds(message.header.stamp))
        with lock:
            delays.add(delay_s)

    def report(_: float) -> None:
        with lock:
            summary = delays.summary()
        if summary is None:
            return
        if as_json:
            console.out_json(summary._asdict(), compact=True)
        else:
            console.out_text(delay_text(summary))

    listen([source], arrive, report, raw=False)
