"""``teleopctl topic hz``, ``bw`` and ``delay``."""

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Generic, TypeVar, contextmanager
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.graph_lookup import expand_patterns, learn_type
from teleopctl.cli.messages import filter_predicate
from teleopctl.cli.options import UseSimTime
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.qos import QosOptions
from teleopctl.cli.verbs.topic.sources import (
    TopicSource,
    find_source,
    graph_or_start_router,
    warn_unpublished,
)
from teleopctl.cli.verbs.topic.statistics import (
    Bandwidth,
    BandwidthWindow,
    DelayWindow,
    RateWindow,
    Summary,
    bandwidth_cells,
    bandwidth_text,
    delay_text,
    rate,
    rate_text,
)
from teleopctl.errors import InvalidMessageError, UsageError, did_you_mean
from teleopctl.interfaces import deserialize, get_message, to_nanoseconds

if TYPE_CHECKING:
    from rich.table import Table

    from teleopctl.node import Node
    from teleopctl.wire import Graph


Rows = Sequence[tuple[str, ...]]
"""Header and a row for each topic; the first cell is the name of the topic."""


@contextmanager
def table_of_topics(topics: Sequence[str], *, as_json: bool) -> Iterator[Callable[[Rows], None]]:
    """Yield a function that prints a table, which on a terminal replaces the previous table.

    On a terminal, each table replaces the previous one, and topics without values have a row too.

    Args:
        topics: Names of the topics.
        as_json: Whether the output is JSON, so that no table is shown.
    """
    if as_json or len(topics) == 1 or not sys.stdout.isatty():
        yield lambda rows: console.out_lines(_lines(rows))
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(), auto_refresh=False) as live:

        def show(rows: Rows) -> None:
            live.update(_rich_table(rows, topics), refresh=True)

        yield show


def _lines(rows: Rows) -> list[str]:
    """Return the lines of a table as in ROS 2: centred titles, left-aligned cells."""
    if len(rows) < 2:
        return []
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    header, *others = rows
    titles = "   ".join(title.center(width) for title, width in zip(header, widths, strict=True))
    lines = [
        "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in others
    ]
    return [titles, "=" * len(titles), *lines, ""]


def _rich_table(rows: Rows, topics: Sequence[str]) -> "Table":
    from rich.table import Table
    from rich.text import Text

    from teleopctl.base.printable import printable_line

    header, *others = rows
    by_topic = {row[0]: row for row in others}
    table = Table(box=None, pad_edge=False, header_style="bold")
    for place, title in enumerate(header):
        # On a narrow terminal, names are wrapped and numbers are not.
        table.add_column(title, justify="right" if place else "left", no_wrap=place > 0)
    for topic in topics:
        row = by_topic.get(topic, (topic, *("-" for _ in header[1:])))
        table.add_row(*(Text(printable_line(cell)) for cell in row))
    return table


_Value = TypeVar("_Value")


class _Figures(Generic[_Value]):
    """Text, table cells and JSON record of the values of one verb.

    Args:
        columns: Titles of the cells.
        text: Returns a value as the lines that are printed for a single topic.
        cells: Returns a value as the cells of a table of several topics.
        record: Returns a value as a JSON object.
    """

    def __init__(
        self,
        columns: tuple[str, ...],
        text: Callable[[_Value], str],
        cells: Callable[[_Value], tuple[str, ...]],
        record: Callable[[_Value], "dict[str, console.Json]"],
    ) -> None:
        self._columns = columns
        self._text = text
        self._cells = cells
        self._record = record

    def print_values(
        self, values: dict[str, _Value], show: Callable[[Rows], None], *, as_table: bool
    ) -> None:
        """Print each topic's values as text, or as a table by calling ``show`` with rows."""
        if as_table:
            rows = [(topic, *self._cells(value)) for topic, value in values.items()]
            show([("topic", *self._columns), *rows])
        else:
            for value in values.values():
                console.out_text(self._text(value))

    def print_json(self, values: dict[str, _Value], *, by_topic: bool) -> None:
        """Print a JSON object with the values by topic, or the value of the only topic."""
        records = {topic: self._record(value) for topic, value in values.items()}
        if by_topic and records:
            console.out_json(records, compact=True)
        else:
            for record in records.values():
                console.out_json(record, compact=True)


def _summary_cells(summary: Summary, first: float) -> tuple[str, ...]:
    times = (f"{value:.3f}" for value in (first, summary.minimum, summary.maximum))
    return (*times, f"{summary.deviation:.5f}", str(summary.window))


_RATES: _Figures[Summary] = _Figures(
    ("rate", "min_delta", "max_delta", "std_dev", "window"),
    rate_text,
    lambda summary: _summary_cells(summary, rate(summary)),
    lambda summary: {"rate": rate(summary), **summary._asdict()},
)
_BANDWIDTHS: _Figures[Bandwidth] = _Figures(
    ("bandwidth", "window", "mean", "min", "max"),
    bandwidth_text,
    bandwidth_cells,
    lambda bandwidth: bandwidth._asdict(),
)
_DELAYS: _Figures[Summary] = _Figures(
    ("delay", "min", "max", "std_dev", "window"),
    delay_text,
    lambda summary: _summary_cells(summary, summary.mean),
    lambda summary: summary._asdict(),
)

TopicNames = Annotated[
    list[str] | None, Argument(help="The topics.", metavar="TOPIC_NAME...", complete="topics")
]
WindowSize = Annotated[int, Option("-w", "--window", help="Number of messages in the average.")]
AllTopics = Annotated[bool, Option("-a", "--all", help="Measure every topic.")]
AsJsonReports = Annotated[bool, Option("--json", help="Print one JSON object a report.")]


def measure_rate(
    topic_names: TopicNames = None,
    window: WindowSize = 10000,
    filter_expression: Annotated[
        str | None,
        Option("--filter", help="Count a message m only where this Python is true: m.data > 3."),
    ] = None,
    wall_time: Annotated[
        bool,
        Option("--wall-time", help="Measure wall time even with -s."),
    ] = False,
    all_topics: AllTopics = False,
    as_json: AsJsonReports = False,
    use_sim_time: UseSimTime = False,
    *,
    qos: QosOptions,
) -> None:
    """Print the message rates of topics each second, until Ctrl-C."""
    listener = TopicListener(
        topic_names or (),
        all_topics=all_topics,
        raw=filter_expression is None,
        qos=qos,
        use_sim_time=use_sim_time and not wall_time,
    )
    if all_topics and not listener.announce_all(as_json=as_json):
        return
    windows = {topic: RateWindow(window) for topic in listener.topics}
    are_several = len(windows) > 1
    selected = filter_predicate(filter_expression) if filter_expression else None
    lock = threading.Lock()
    failures: list[InvalidMessageError] = []

    def add(source: TopicSource, message: Any, time_ns: int) -> None:
        try:
            # The time is zero before the first message of /clock.
            if time_ns and (selected is None or selected(message)):
                with lock:
                    windows[source.topic].add_arrival(time_ns)
        except InvalidMessageError as error:
            failures.append(error)  # raised by the main thread: this one is the transport's

    def report(_: int) -> None:
        if failures:
            raise failures[0]
        with lock:
            values = {topic: each.new_summary() for topic, each in windows.items()}
        new = {topic: value for topic, value in values.items() if value}
        if as_json:
            _RATES.print_json(new, by_topic=True)
        else:
            _RATES.print_values(new, show, as_table=are_several)

    def announce(topic: str) -> None:
        if are_several and not as_json:
            console.out(f"Subscribed to [{topic}]")

    with table_of_topics(listener.topics, as_json=as_json) as show:
        listener.run(add, report, announce)


def measure_bandwidth(
    topic_names: TopicNames = None,
    window: WindowSize = 100,
    all_topics: AllTopics = False,
    as_json: AsJsonReports = False,
    use_sim_time: UseSimTime = False,
    *,
    qos: QosOptions,
) -> None:
    """Print the bandwidths of topics each second, until Ctrl-C."""
    listener = TopicListener(
        topic_names or (), all_topics=all_topics, raw=True, qos=qos, use_sim_time=use_sim_time
    )
    if all_topics and not listener.announce_all(as_json=as_json):
        return
    windows = {topic: BandwidthWindow(window) for topic in listener.topics}
    are_several = len(windows) > 1
    lock = threading.Lock()

    def add(source: TopicSource, payload: Any, time_ns: int) -> None:
        # The time is zero before the first message of /clock.
        if time_ns:
            with lock:
                windows[source.topic].add_arrival(time_ns, len(payload))

    def report(now_ns: int) -> None:
        with lock:
            values = {topic: each.summary(now_ns) for topic, each in windows.items()}
        known = {topic: value for topic, value in values.items() if value}
        if as_json:
            _BANDWIDTHS.print_json(known, by_topic=are_several)
        else:
            _BANDWIDTHS.print_values(known, show, as_table=are_several)

    def announce(topic: str) -> None:
        if not as_json:
            console.out(f"Subscribed to [{topic}]")

    with table_of_topics(listener.topics, as_json=as_json) as show:
        listener.run(add, report, announce)


def measure_delay(
    topic_names: Annotated[
        list[str], Argument(help="The topics.", metavar="TOPIC_NAME...", complete="topics")
    ],
    window: WindowSize = 10000,
    as_json: AsJsonReports = False,
    use_sim_time: UseSimTime = False,
    *,
    qos: QosOptions,
) -> None:
    """Print the delays of messages from stamp to arrival each second, until Ctrl-C.

    The delay is the time from a message's header.stamp to its arrival; the clocks of both machines
    must agree.
    """
    readers: dict[str, Callable[[bytes], int]] = {}

    def check(source: TopicSource) -> None:
        readers[source.topic] = _stamp_reader(source.message_class.TYPE_NAME)

    listener = TopicListener(
        topic_names,
        all_topics=False,
        raw=True,
        qos=qos,
        use_sim_time=use_sim_time,
        wall_clock=True,
        check=check,
    )
    windows = {topic: DelayWindow(window) for topic in listener.topics}
    are_several = len(windows) > 1
    lock = threading.Lock()

    def add(source: TopicSource, payload: Any, time_ns: int) -> None:
        stamp_ns = readers[source.topic](payload)
        # The time is zero before the first message of /clock.
        if time_ns:
            with lock:
                windows[source.topic].add((time_ns - stamp_ns) * 1e-9)

    def report(_: int) -> None:
        with lock:
            values = {topic: each.new_summary() for topic, each in windows.items()}
        new = {topic: value for topic, value in values.items() if value}
        if as_json:
            _DELAYS.print_json(new, by_topic=are_several)
        elif new or are_several:
            _DELAYS.print_values(new, show, as_table=are_several)
        elif any(each.arrivals for each in windows.values()):
            console.out("no new messages")

    with table_of_topics(listener.topics, as_json=as_json) as show:
        listener.run(add, report)


_STAMP = "builtin_interfaces/msg/Time"


def _stamp_reader(type_name: str) -> Callable[[bytes], int]:
    """Return a function that reads the stamp of a serialized message, in nanoseconds.

    Raises:
        InvalidMessageError: The type has no header.
    """
    learn_type(type_name)
    message_class = get_message(type_name)
    fields = message_class.get_fields_and_field_types()
    if fields.get("header") != "std_msgs/Header":
        raise InvalidMessageError(f"msg does not have header: {type_name}, so its age is unknown")
    if next(iter(fields)) == "header":
        # The message begins with its stamp: only these bytes are deserialized.
        stamp_class = get_message(_STAMP)
        return lambda payload: to_nanoseconds(deserialize(payload[:12], stamp_class))

    def read(payload: bytes) -> int:
        # Any: a message of any type.
        message: Any = deserialize(payload, message_class)
        return to_nanoseconds(message.header.stamp)

    return read


PRINT_PERIOD_S = 1.0
_DEPTH = 10

# Any: bytes, or a message of any type.
OnMessage = Callable[[TopicSource, Any, int], None]


class TopicListener:
    """Subscriptions of `topic hz`, `bw` and `delay`, also to topics that appear later.

    Args:
        names: Names or patterns of topics.
        all_topics: Whether to measure all topics of the graph instead.
        raw: Whether to pass serialized messages as bytes, without deserialization.
        qos: QoS options of the command line.
        use_sim_time: Whether to measure the time of ``/clock``.
        wall_clock: Whether arrival times are wall time instead of the time of a steady clock.
        check: Function that raises an error for a topic that cannot be measured; called with each
            topic, at once or when the topic appears.

    Attributes:
        topics: Full names of the topics.

    Raises:
        UsageError: No topic is named.
        TeleopctlError: An existing topic cannot be measured.
    """

    def __init__(
        self,
        names: Sequence[str],
        *,
        all_topics: bool,
        raw: bool,
        qos: "QosOptions",
        use_sim_time: bool,
        wall_clock: bool = False,
        check: Callable[[TopicSource], None] = lambda _: None,
    ) -> None:
        if not names and not all_topics:
            raise UsageError("Name a topic, or measure all of them with --all")
        if names and all_topics:
            raise UsageError("Cannot specify both --all/-a and topic names")
        graph = graph_or_start_router()
        live = [name for name, _ in graph.topic_names_and_types(include_hidden=not all_topics)]
        self.topics = live if all_topics else expand_patterns(names, live, kind="topic")
        self._raw = raw
        self._qos = qos
        self._use_sim_time = use_sim_time
        self._uses_node_clock = use_sim_time or wall_clock
        self._check = check
        self._sources = [found for topic in self.topics if (found := self._source(topic, graph))]
        self._missing = sorted(set(self.topics) - {source.topic for source in self._sources})
        for topic in self._missing:
            warn_unpublished(topic)
            if hint := did_you_mean(topic, live):
                console.note(f"  {hint}")

    def announce_all(self, *, as_json: bool) -> bool:
        """Print the number of topics for ``--all``; return False if it is zero."""
        if not self.topics:
            say = console.note if as_json else console.out
            say("No topics available")
        elif not as_json:
            console.out(f"Subscribing to all {len(self.topics)} available topics...")
        return bool(self.topics)

    def run(
        self,
        on_message: OnMessage,
        on_period: Callable[[int], None],
        on_subscribed: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Subscribe to the topics, and call ``on_period`` once a second until Ctrl-C.

        Args:
            on_message: Called on the transport's thread for each message, with the topic, the
                message and its arrival time in nanoseconds, so that neither decoding nor printing
                of other messages delays the times.
            on_period: Called once a second with the present time of the same clock.
            on_subscribed: Called with the name of each topic when it is subscribed to.
        """
        with command_node(use_sim_time=self._use_sim_time) as node:
            now_ns = node.get_clock().nanoseconds if self._uses_node_clock else time.monotonic_ns
            for source in self._sources:
                self._subscribe(node, source, on_message, now_ns)
                on_subscribed(source.topic)
            console.flush()
            graph_has_changed = threading.Event()
            if self._missing:
                node.context.on_graph_change(graph_has_changed.set)
                graph_has_changed.set()
            due_s = time.monotonic()
            while node.context.ok():
                due_s += PRINT_PERIOD_S
                while (left_s := due_s - time.monotonic()) > 0:
                    if graph_has_changed.wait(left_s):
                        graph_has_changed.clear()
                        for source in self._appeared(node):
                            self._subscribe(node, source, on_message, now_ns)
                            on_subscribed(source.topic)
                on_period(now_ns())
                console.flush()

    def _appeared(self, node: "Node") -> list[TopicSource]:
        """Return the missing topics that have appeared, and remove them from the missing ones."""
        graph = node.graph()
        sources = [found for topic in self._missing if (found := self._source(topic, graph))]
        for source in sources:
            self._missing.remove(source.topic)
        return sources

    def _source(self, topic: str, graph: "Graph") -> TopicSource | None:
        """Return a topic of the graph; None if the graph has no endpoint of it."""
        if not (graph.publishers(topic) or graph.subscriptions(topic)):
            return None
        source = find_source(topic, graph=graph, raw=self._raw)
        self._check(source)
        return source

    def _subscribe(
        self, node: "Node", source: TopicSource, on_message: OnMessage, now_ns: Callable[[], int]
    ) -> None:
        from teleopctl.node import DurabilityPolicy

        qos = source.compatible_qos(_DEPTH)
        # Latched messages arrive all at once, which would distort the rate.
        qos.durability = DurabilityPolicy.VOLATILE

        def receive(message: Any) -> None:
            on_message(source, message, now_ns())

        node.create_subscription(
            source.message_class,
            source.topic,
            receive,
            self._qos.for_subscription(qos),
            raw=self._raw,
            immediate=True,
        )
