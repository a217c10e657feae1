"""``teleopctl topic delay``."""

import threading
from collections.abc import Callable

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.learning import learn_type
from teleopctl.cli.options import UseSimTime
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.measuring.listening import TopicListener
from teleopctl.cli.verbs.topic.measuring.statistics import DelayWindow, Summary, delay_text
from teleopctl.cli.verbs.topic.measuring.table import Rows, table_of_topics
from teleopctl.cli.verbs.topic.qos.options import (
    Depth,
    DurabilityName,
    HistoryName,
    LeaseDuration,
    LivelinessName,
    ProfileName,
    QosWishes,
    ReliabilityName,
)
from teleopctl.cli.verbs.topic.source import TopicSource
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import deserialize, get_message, to_nanoseconds

_COLUMNS = ("delay", "min", "max", "std_dev", "window")
_STAMP = "builtin_interfaces/msg/Time"


def measure_delay(
    topic_names: Annotated[
        list[str], Argument(help="The topics.", metavar="TOPIC_NAME...", complete="topics")
    ],
    window: Annotated[
        int, Option("-w", "--window", help="How many messages the average is taken over.")
    ] = 10000,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a report.")] = False,
    use_sim_time: UseSimTime = False,
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
    qos_liveliness: LivelinessName = None,
    qos_liveliness_lease_duration_seconds: LeaseDuration = None,
) -> None:
    """Measure the age of stamped messages.

    It is the time between a message's header.stamp and its arrival, so that the clocks of both
    machines matter.
    """
    stamps: dict[str, Callable[[bytes], int]] = {}

    def check(source: TopicSource) -> None:
        stamps[source.topic] = _stamp_reader(source.message_class.TYPE_NAME)

    listener = TopicListener(
        topic_names,
        every=False,
        raw=True,
        wishes=QosWishes(
            *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
            *(qos_liveliness, qos_liveliness_lease_duration_seconds),
        ),
        use_sim_time=use_sim_time,
        of_day=True,
        check=check,
    )
    delays = {topic: DelayWindow(window) for topic in listener.topics}
    lock = threading.Lock()

    def arrive(source: TopicSource, payload: Any, time_ns: int) -> None:
        stamp_ns = stamps[source.topic](payload)
        # Before the first message of /clock there is no time.
        if time_ns:
            with lock:
                delays[source.topic].add((time_ns - stamp_ns) * 1e-9)

    def report(_: int) -> None:
        with lock:
            found = {topic: delays[topic].news() for topic in listener.topics}
        news = {topic: summary for topic, summary in found.items() if summary}
        if len(found) > 1:
            if not as_json:
                show(_table(news))
            elif news:
                console.out_json({t: s._asdict() for t, s in news.items()}, compact=True)
        elif news:
            (summary,) = news.values()
            if as_json:
                console.out_json(summary._asdict(), compact=True)
            else:
                console.out_text(delay_text(summary))
        elif not as_json and any(window.arrivals for window in delays.values()):
            console.out("no new messages")

    with table_of_topics(listener.topics, as_json=as_json) as show:
        listener.run(arrive, report)


def _stamp_reader(type_name: str) -> Callable[[bytes], int]:
    """A function that reads the stamp of a message, in nanoseconds, and no more than it must.

    Raises:
        InvalidMessageError: The type has no header.
    """
    learn_type(type_name)
    message_class = get_message(type_name)
    fields = message_class.get_fields_and_field_types()
    if fields.get("header") != "std_msgs/Header":
        raise InvalidMessageError(f"msg does not have header: {type_name}, so its age is unknown")
    if next(iter(fields)) == "header":
        # It begins with its stamp, and what follows has not to be there.
        stamp_class = get_message(_STAMP)
        return lambda payload: to_nanoseconds(deserialize(payload[:12], stamp_class))

    def read(payload: bytes) -> int:
        # Any: a message of any type.
        message: Any = deserialize(payload, message_class)
        return to_nanoseconds(message.header.stamp)

    return read


def _table(summaries: dict[str, Summary]) -> Rows:
    rows: list[tuple[str, ...]] = [("topic", *_COLUMNS)]
    for topic, s in summaries.items():
        times = (f"{value:.3f}" for value in (s.mean, s.minimum, s.maximum))
        rows.append((topic, *times, f"{s.deviation:.5f}", str(s.window)))
    return rows
