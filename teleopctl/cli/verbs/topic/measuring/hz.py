"""``teleopctl topic hz``."""

import threading

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import UseSimTime
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.measuring.listening import TopicListener
from teleopctl.cli.verbs.topic.measuring.statistics import RateWindow, Summary, rate, rate_text
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
from teleopctl.cli.verbs.topic.selection import filter_predicate
from teleopctl.cli.verbs.topic.source import TopicSource

_COLUMNS = ("rate", "min_delta", "max_delta", "std_dev", "window")


def measure_rate(
    topic_names: Annotated[
        list[str] | None, Argument(help="The topics.", metavar="TOPIC_NAME...", complete="topics")
    ] = None,
    window: Annotated[
        int, Option("-w", "--window", help="How many messages the average is taken over.")
    ] = 10000,
    filter_expression: Annotated[
        str | None,
        Option("--filter", help="Count a message m only where this Python is true: m.data > 3."),
    ] = None,
    wall_time: Annotated[
        bool,
        Option("--wall-time", help="Do not measure the time of /clock, in spite of -s."),
    ] = False,
    all_topics: Annotated[bool, Option("-a", "--all", help="Measure every topic.")] = False,
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
    """Measure the rate of topics."""
    listener = TopicListener(
        topic_names or (),
        every=all_topics,
        raw=filter_expression is None,
        wishes=QosWishes(
            *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
            *(qos_liveliness, qos_liveliness_lease_duration_seconds),
        ),
        use_sim_time=use_sim_time and not wall_time,
    )
    if all_topics and not listener.announce_all(as_json=as_json):
        return
    rates = _Rates(listener.topics, window)
    wanted = filter_predicate(filter_expression) if filter_expression else None

    def arrive(source: TopicSource, message: Any, time_ns: int) -> None:
        # Before the first message of /clock there is no time.
        if time_ns and (wanted is None or wanted(message)):
            rates.arrive(source.topic, time_ns)

    def report(_: int) -> None:
        summaries = rates.news()
        if as_json and summaries:
            console.out_json(
                {topic: {"rate": rate(s), **s._asdict()} for topic, s in summaries.items()},
                compact=True,
            )
        elif len(listener.topics) > 1 and not as_json:
            show(_table(summaries))
        else:
            for summary in summaries.values():
                console.out_text(rate_text(summary))

    def subscribed(topic: str) -> None:
        if len(listener.topics) > 1 and not as_json:
            console.out(f"Subscribed to [{topic}]")

    with table_of_topics(listener.topics, as_json=as_json) as show:
        listener.run(arrive, report, subscribed)


class _Rates:
    """A window for each topic, filled by one thread and read by another."""

    def __init__(self, topics: list[str], window: int) -> None:
        self._lock = threading.Lock()
        self._windows = {topic: RateWindow(window) for topic in topics}
        self._reported = dict.fromkeys(self._windows, 0)

    def arrive(self, topic: str, time_ns: int) -> None:
        with self._lock:
            self._windows[topic].arrive(time_ns)

    def news(self) -> dict[str, Summary]:
        """Return the summaries of topics with messages since the last call."""
        found = {}
        with self._lock:
            for topic, window in self._windows.items():
                summary = window.summary()
                if summary is not None and window.arrivals != self._reported[topic]:
                    found[topic] = summary
                    self._reported[topic] = window.arrivals
        return found


def _table(summaries: dict[str, Summary]) -> Rows:
    rows: list[tuple[str, ...]] = [("topic", *_COLUMNS)]
    for topic, s in summaries.items():
        times = (f"{value:.3f}" for value in (rate(s), s.minimum, s.maximum))
        rows.append((topic, *times, f"{s.deviation:.5f}", str(s.window)))
    return rows
