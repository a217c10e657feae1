"""``teleopctl topic bw``."""

import threading
from typing import Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.live import absolute_name
from teleopctl.cli.options import TopicName
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.topic.listening import listen
from teleopctl.cli.verbs.topic.source import TopicSource, find_source
from teleopctl.cli.verbs.topic.statistics import BandwidthWindow, bandwidth_text


def measure_bandwidth(
    topic_name: TopicName,
    window: Annotated[
        int, Option("-w", "--window", help="How many messages the average is taken over.")
    ] = 100,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a report.")] = False,
) -> None:
    """Measure the bandwidth of a topic."""
    source = find_source(absolute_name(topic_name), raw=True)
    sizes = BandwidthWindow(window)
    lock = threading.Lock()

    def arrive(_: TopicSource, payload: Any, time_s: float) -> None:
        with lock:
            sizes.arrive(time_s, len(payload))

    def report(now_s: float) -> None:
        with lock:
            bandwidth = sizes.summary(now_s)
        if bandwidth is None:
            return
        if as_json:
            console.out_json(bandwidth._asdict(), compact=True)
        else:
            console.out_text(bandwidth_text(bandwidth))

    if not as_json:
        console.out(f"Subscribed to [{source.topic}]")
    listen([source], arrive, report, raw=True)
