"""``teleopctl topic bw``."""

import threading

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import UseSimTime
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.measuring.listening import TopicListener
from teleopctl.cli.verbs.topic.measuring.statistics import (
    Bandwidth,
    BandwidthWindow,
    bandwidth_cells,
    bandwidth_text,
)
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

_COLUMNS = ("bandwidth", "window", "mean", "min", "max")


def measure_bandwidth(
    topic_names: Annotated[
        list[str] | None, Argument(help="The topics.", metavar="TOPIC_NAME...", complete="topics")
    ] = None,
    window: Annotated[
        int, Option("-w", "--window", help="How many messages the average is taken over.")
    ] = 100,
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
    """Measure the bandwidth of topics."""
    listener = TopicListener(
        topic_names or (),
        every=all_topics,
        raw=True,
        wishes=QosWishes(
            *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
            *(qos_liveliness, qos_liveliness_lease_duration_seconds),
        ),
        use_sim_time=use_sim_time,
    )
    if all_topics and not listener.announce_all(as_json=as_json):
        return
    sizes = {topic: BandwidthWindow(window) for topic in listener.topics}
    are_several = len(listener.topics) > 1
    lock = threading.Lock()

    def arrive(source: TopicSource, payload: Any, time_ns: int) -> None:
        # Before the first message of /clock there is no time.
        if not time_ns:
            return
        with lock:
            sizes[source.topic].arrive(time_ns, len(payload))

    def report(now_ns: int) -> None:
        with lock:
            found = {topic: window.summary(now_ns) for topic, window in sizes.items()}
        known = {topic: bandwidth for topic, bandwidth in found.items() if bandwidth}
        if are_several and not as_json:
            show(_table(known))
        elif known and are_several:
            console.out_json({t: b._asdict() for t, b in known.items()}, compact=True)
        else:
            for bandwidth in known.values():
                if as_json:
                    console.out_json(bandwidth._asdict(), compact=True)
                else:
                    console.out_text(bandwidth_text(bandwidth))

    def subscribed(topic: str) -> None:
        if not as_json:
            console.out(f"Subscribed to [{topic}]")

    with table_of_topics(listener.topics, as_json=as_json) as show:
        listener.run(arrive, report, subscribed)


def _table(bandwidths: dict[str, Bandwidth]) -> Rows:
    rows: list[tuple[str, ...]] = [("topic", *_COLUMNS)]
    for topic, bandwidth in bandwidths.items():
        rows.append((topic, *bandwidth_cells(bandwidth)))
    return rows
