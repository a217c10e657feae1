"""``teleopctl topic bw``."""

import threading
from typing import Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.live import absolute_name
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.measuring.listening import listen
from teleopctl.cli.verbs.topic.measuring.statistics import (
    Bandwidth,
    BandwidthWindow,
    bandwidth_cells,
    bandwidth_text,
)
from teleopctl.cli.verbs.topic.measuring.table import Rows, chosen_sources, table_of_topics
from teleopctl.cli.verbs.topic.source import TopicSource

_COLUMNS = ("bandwidth", "mean", "min", "max", "window")


def measure_bandwidth(
    topic_names: Annotated[
        list[str] | None, Argument(help="The topics.", metavar="TOPIC_NAME...", complete="topics")
    ] = None,
    window: Annotated[
        int, Option("-w", "--window", help="How many messages the average is taken over.")
    ] = 100,
    all_topics: Annotated[bool, Option("-a", "--all", help="Measure every topic.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a report.")] = False,
) -> None:
    """Measure the bandwidth of topics."""
    names = [absolute_name(name) for name in topic_names or []]
    sources = chosen_sources(names, every=all_topics, raw=True)
    sizes = {source.topic: BandwidthWindow(window) for source in sources}
    lock = threading.Lock()

    def arrive(source: TopicSource, payload: Any, time_s: float) -> None:
        with lock:
            sizes[source.topic].arrive(time_s, len(payload))

    def report(now_s: float) -> None:
        with lock:
            found = {topic: window.summary(now_s) for topic, window in sizes.items()}
        known = {topic: bandwidth for topic, bandwidth in found.items() if bandwidth}
        if len(sources) > 1 and not as_json:
            show(_table(known))
        elif as_json and len(sources) > 1:
            console.out_json({t: b._asdict() for t, b in known.items()}, compact=True)
        else:
            for bandwidth in known.values():
                if as_json:
                    console.out_json(bandwidth._asdict(), compact=True)
                else:
                    console.out_text(bandwidth_text(bandwidth))

    if not as_json and len(sources) == 1:
        console.out(f"Subscribed to [{sources[0].topic}]")
    with table_of_topics(sources, as_json=as_json) as show:
        listen(sources, arrive, report, raw=True)


def _table(bandwidths: dict[str, Bandwidth]) -> Rows:
    rows: list[tuple[str, ...]] = [("topic", *_COLUMNS)]
    for topic, bandwidth in bandwidths.items():
        rows.append((topic, *bandwidth_cells(bandwidth)))
    return rows
