"""``teleopctl topic hz``."""

import threading
from typing import Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.live import absolute_name
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.measuring.listening import listen
from teleopctl.cli.verbs.topic.measuring.statistics import RateWindow, Summary, rate, rate_text
from teleopctl.cli.verbs.topic.measuring.table import Rows, chosen_sources, table_of_topics
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
        Option("--wall-time", help="Accepted for ROS 2's sake: messages are always timed so here."),
    ] = False,
    all_topics: Annotated[bool, Option("-a", "--all", help="Measure every topic.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a report.")] = False,
) -> None:
    """Measure the rate of topics."""
    del wall_time
    names = [absolute_name(name) for name in topic_names or []]
    sources = chosen_sources(names, every=all_topics, raw=filter_expression is None)
    rates = _Rates(sources, window)
    wanted = filter_predicate(filter_expression) if filter_expression else None

    def arrive(source: TopicSource, message: Any, time_s: float) -> None:
        if wanted is None or wanted(message):
            rates.arrive(source.topic, time_s)

    def report(_: float) -> None:
        summaries = rates.news()
        if as_json:
            console.out_json(
                {topic: {"rate": rate(s), **s._asdict()} for topic, s in summaries.items()},
                compact=True,
            )
        elif len(sources) > 1:
            show(_table(summaries))
        else:
            for summary in summaries.values():
                console.out_text(rate_text(summary))

    with table_of_topics(sources, as_json=as_json) as show:
        listen(sources, arrive, report, raw=wanted is None)


class _Rates:
    """A window for each topic, filled by one thread and read by another."""

    def __init__(self, sources: list[TopicSource], window: int) -> None:
        self._lock = threading.Lock()
        self._windows = {source.topic: RateWindow(window) for source in sources}
        self._reported = dict.fromkeys(self._windows, 0)

    def arrive(self, topic: str, time_s: float) -> None:
        with self._lock:
            self._windows[topic].arrive(time_s)

    def news(self) -> dict[str, Summary]:
        """The summaries of the topics that had a message since the last question."""
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
