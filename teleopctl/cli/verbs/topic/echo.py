"""``teleopctl topic echo``."""

import sys

from teleopctl.base.typed import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Callable,
    Iterator,
    Sequence,
    contextmanager,
)
from teleopctl.cli import console
from teleopctl.cli.command_node import brief_node, command_node
from teleopctl.cli.options import TopicName, UseSimTime, check_positive
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.qos import QosOptions
from teleopctl.cli.verbs.topic.text import TextOptions
from teleopctl.errors import InvalidMessageError, UnavailableError
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.cli.console import Json
    from teleopctl.cli.verbs.topic.sources import NamedTopics, TopicSource
    from teleopctl.cli.verbs.topic.text import TextStyle
    from teleopctl.node import BareNode, MessageInfo, Node, QoSProfile


_DEPTH = 10


def echo(
    topic_name: TopicName,
    message_type: Annotated[
        str | None,
        Argument(
            help="Type; by default the one in the graph.",
            complete="message_types",
        ),
    ] = None,
    more: Annotated[
        list[str] | None,
        Argument(
            help="More topics, each optionally followed by its type.",
            metavar="TOPIC_NAME...",
            complete="topics",
        ),
    ] = None,
    once: Annotated[bool, Option("--once", help="Print the first message and end.")] = False,
    timeout: Annotated[
        float | None, Option("--timeout", help="End after this many seconds.", metavar="SECONDS")
    ] = None,
    field: Annotated[
        list[str] | None,
        Option(
            "--field",
            help="Print one field, such as transforms[0].header; may be repeated.",
            repeated=True,
            complete="fields",
        ),
    ] = None,
    filter_expression: Annotated[
        str | None,
        Option("--filter", help="Print a message m only where this Python is true: m.data > 3."),
    ] = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
    raw: Annotated[bool, Option("--raw", help="Print the bytes as they arrive.")] = False,
    include_message_info: Annotated[
        bool,
        Option("-i", "--include-message-info", help="Print times and numbers of each message."),
    ] = False,
    clear: Annotated[
        bool, Option("-c", "--clear", help="Clear the terminal before each message.")
    ] = False,
    node_name: Annotated[
        str | None, Option("-n", "--node-name", help="Name of the listening node.")
    ] = None,
    plot: Annotated[
        str | None,
        Option("--plot", help="Draw fields over time instead.", metavar="FIELD[,FIELD]..."),
    ] = None,
    window: Annotated[
        float, Option("--window", help="With --plot: time range, in seconds.", metavar="SECONDS")
    ] = 10.0,
    no_lost_messages: Annotated[
        bool, Option("--no-lost-messages", help="Do not report lost messages.")
    ] = False,
    use_sim_time: UseSimTime = False,
    *,
    text: TextOptions,
    qos: QosOptions,
) -> None:
    """Print the messages of topics.

    The QoS follows the publishers' QoS, so latched messages are printed as well. With several
    topics, prints the name before each message. Ends on Ctrl-C.
    """
    from teleopctl.cli.messages import filter_predicate
    from teleopctl.cli.verbs.topic.sources import NamedTopics

    check_positive(timeout=timeout)
    for path in field or ():
        if not path.strip("."):
            raise InvalidMessageError(f"Invalid field value '{path}'")
    topics = NamedTopics([topic_name, *([message_type] if message_type else []), *(more or ())])
    printer = MessagePrinter(
        text.style(as_json=as_json),
        field or (),
        "json" if as_json else "csv" if text.csv else "yaml",
        with_info=include_message_info,
        names_topics=topics.are_several,
        clears=clear,
    )
    selected = filter_predicate(filter_expression) if filter_expression else None
    if plot is not None:
        from teleopctl.cli.verbs.topic.plot import live_plot

        topics.require_single()
        (source,) = topics.sources(raw=False)
        profile = qos.for_subscription(source.compatible_qos(_DEPTH))
        live_plot(source, plot, window, profile, timeout)
        return
    losses = None if no_lost_messages else LossReport()
    is_simple = once and not (use_sim_time or raw or topics.are_several or qos.are_given)
    if is_simple and _echo_at_once(topics, node_name, printer, selected, losses, timeout):
        return
    opened = (
        _brief_listener(topics, node_name, raw=raw)
        if once and not use_sim_time
        else _listener(topics, node_name, raw=raw, use_sim_time=use_sim_time)
    )
    with opened as (node, sources):
        echoed = _Echo(printer, selected, losses, once=once)
        for source in sources:
            profile = qos.for_subscription(source.compatible_qos(_DEPTH))
            echoed.subscribe(node, source, profile, raw=raw)
        echoed.spin(node, timeout)
    if timeout is not None and not echoed.has_printed:
        raise _no_message([source.topic for source in sources], timeout)


def _no_message(topics: Sequence[str], timeout_s: float) -> UnavailableError:
    names = "', '".join(topics)
    return UnavailableError(f"No message on '{names}' within {timeout_s:g} s")


def _echo_at_once(
    topics: "NamedTopics",
    node_name: str | None,
    printer: "MessagePrinter",
    selected: Callable[[Any], bool] | None,
    losses: "LossReport | None",
    timeout_s: float | None,
) -> bool:
    """Print the next message of a topic that is published; return False if it is not, or latched.

    Raises:
        UnavailableError: No message came within the time.
    """
    from teleopctl.cli.brief_endpoints import BriefNode
    from teleopctl.cli.command_node import command_node_name
    from teleopctl.wire import (
        RELIABILITY_BEST_EFFORT,
        RELIABILITY_RELIABLE,
        EndpointQos,
        InvalidMessageCounter,
        RouterNotRunning,
    )

    try:
        opened = BriefNode(node_name or command_node_name())
    except RouterNotRunning:
        return False
    with opened as node:
        graph = node.graph()
        if not topics.are_all_published(graph):
            return False
        (source,) = topics.sources(raw=False, graph=graph)
        source.note_fallbacks()
        reliable = all(publisher.qos.is_reliable for publisher in source.publishers)
        qos = EndpointQos(
            reliability=RELIABILITY_RELIABLE if reliable else RELIABILITY_BEST_EFFORT, depth=_DEPTH
        )
        report = InvalidMessageCounter(f"a message on '{source.topic}'", console.warn)
        topic = node.resolve_topic_name(source.topic)
        for message, info in node.receive(topic, source.message_class, qos, report, timeout_s):
            if losses is not None:
                losses.add(info)
            values = printer.selected_values(message)
            if selected is None or selected(values[0]):
                printer.write(source.topic, values, info)
                return True
    if timeout_s is None:
        return True
    raise _no_message([source.topic], timeout_s)


class _Echo:
    """Subscriptions whose messages are printed.

    Args:
        printer: Printer of the messages.
        selected: Predicate that returns whether to print a message; None for all messages.
        losses: Report of lost messages; None for no report.
        once: Whether to stop after the first printed message.

    Attributes:
        has_printed: Whether a message was printed.
    """

    def __init__(
        self,
        printer: "MessagePrinter",
        selected: Callable[[Any], bool] | None,
        losses: "LossReport | None",
        *,
        once: bool,
    ) -> None:
        from teleopctl.node import Future

        self._printer = printer
        self._selected = selected
        self._losses = losses
        self._once = once
        self._done: Future[None] = Future()
        self.has_printed = False

    def subscribe(
        self, node: "Node | BareNode", source: "TopicSource", qos: "QoSProfile", *, raw: bool
    ) -> None:
        """Subscribe to a topic and print each message; with ``raw`` messages arrive as bytes."""

        # Any: messages of any type.
        def receive(message: Any, info: "MessageInfo") -> None:
            self._receive(source.topic, message, info)

        node.create_subscription(source.message_class, source.topic, receive, qos, raw=raw)

    def spin(self, node: "Node | BareNode", timeout_s: float | None) -> None:
        """Receive messages until Ctrl-C, the timeout or, with ``once``, the first message."""
        from teleopctl.node import SingleThreadedExecutor

        with SingleThreadedExecutor(context=node.context) as executor:
            executor.add_node(node)
            executor.spin_until_future_complete(self._done, timeout_s)

    def _receive(self, topic: str, message: Any, info: "MessageInfo") -> None:
        if self._done.done():
            return
        if self._losses is not None:
            self._losses.add(info)
        values = self._printer.selected_values(message)
        if self._selected is not None and not self._selected(values[0]):
            return
        self._printer.write(topic, values, info)
        self.has_printed = True
        if self._once:
            self._done.set_result(None)


@contextmanager
def _listener(
    topics: "NamedTopics", name: str | None, *, raw: bool, use_sim_time: bool
) -> "Iterator[tuple[Node, list[TopicSource]]]":
    """Open a peer for a stream of messages; yield its node and the topics to subscribe to."""
    sources = topics.sources(raw=raw)
    with command_node(name=name, use_sim_time=use_sim_time) as node:
        yield node, sources


@contextmanager
def _brief_listener(
    topics: "NamedTopics", name: str | None, *, raw: bool
) -> "Iterator[tuple[BareNode, list[TopicSource]]]":
    """Open a client of the router for a single message; yield its node and the topics."""
    with brief_node(name=name, starts_router=topics.have_types) as node:
        yield node, topics.sources(raw=raw, graph=query_graph(node.context.session))


# Largest number of publishers whose sequence numbers are kept: more than any topic has, since a
# faulty program may send made-up publisher IDs.
_MOST_SENDERS = 1000


class MessagePrinter:
    """Printer of topic messages as YAML, CSV or JSON, whole or only selected fields.

    Args:
        style: Format of the values.
        fields: Paths of the fields to print; empty for the whole message.
        form: Output format: ``yaml``, ``csv`` or ``json``.
        with_info: Whether to print the message info before each message.
        names_topics: Whether to print the topic of each message.
        clears: Whether to clear the terminal before each message.
    """

    def __init__(
        self,
        style: "TextStyle",
        fields: Sequence[str],
        form: str,
        *,
        with_info: bool,
        names_topics: bool,
        clears: bool,
    ) -> None:
        self._style = style
        self._fields: list[tuple[str, Callable[[Any], Any]]] = []
        if fields:
            from teleopctl.interfaces import field_reader

            self._fields = [(path, field_reader(path)) for path in fields]
        self._with_info = with_info
        self._names_topics = names_topics
        self._clears = clears and sys.stdout.isatty()
        self._write: Callable[[str, list[Any], MessageInfo], None] = {
            "yaml": self._write_yaml,
            "csv": self._write_csv,
            "json": self._write_json,
        }[form]

    # Any, here and below: messages of any type, and parts of them.
    def selected_values(self, message: Any) -> list[Any]:
        """Return a list of the selected fields' values, or of the message if no field is selected.

        Raises:
            InvalidMessageError: The message has no such field.
        """
        return [read(message) for _, read in self._fields] or [message]

    def write(self, topic: str, values: list[Any], info: "MessageInfo") -> None:
        """Print selected values of a message, with topic and message info if configured."""
        if self._clears:
            console.clear_terminal()
        self._write(topic, values, info)
        console.flush()

    def _write_json(self, topic: str, values: list[Any], info: "MessageInfo") -> None:
        from teleopctl.cli.verbs.topic.text import json_value

        documents = [json_value(value) for value in values]
        document: Json = documents[0]
        if len(documents) > 1:
            document = {path: each for (path, _), each in zip(self._fields, documents, strict=True)}
        if self._with_info or self._names_topics:
            document = {"message": document}
            if self._with_info:
                document = {"info": _shown(info), **document}
            if self._names_topics:
                document = {"topic": topic, **document}
        console.out_json(document, compact=True)

    def _write_csv(self, topic: str, values: list[Any], info: "MessageInfo") -> None:
        columns = [topic] if self._names_topics else []
        if self._with_info:
            columns += map(str, _shown(info).values())
        console.out(",".join([*columns, *map(self._style.csv, values)]))

    def _write_yaml(self, topic: str, values: list[Any], info: "MessageInfo") -> None:
        from teleopctl.cli.verbs.topic.text import is_message

        if self._names_topics:
            # A comment, so that the output can be parsed as YAML.
            console.out(f"# {topic}")
        if self._with_info:
            console.out_lines(_info_lines(info, is_of_message=is_message(values[0])))
        console.out_text(f"{''.join(map(self._style.yaml, values))}---")


def _info_lines(info: "MessageInfo", *, is_of_message: bool) -> list[str]:
    shown = _shown(info)
    if not is_of_message:
        return ["---Got new message, message info:---", str(shown), "---Message data:---"]
    lines = [f"{key}: {entry}" for key, entry in sorted(shown.items())]
    return [*lines, "---"]


def _shown(info: "MessageInfo") -> dict[str, int]:
    return {key: value for key, value in info.items() if isinstance(value, int)}


class LossReport:
    """Report of lost messages by gaps in the publishers' sequence numbers, as in ROS 2."""

    def __init__(self) -> None:
        self._last: dict[bytes, int] = {}
        self._lost = 0

    def add(self, info: "MessageInfo") -> None:
        """Print how many messages were lost since the publisher's last message, if any."""
        publisher, number = info["publisher_gid"], info["publication_sequence_number"]
        last = self._last.pop(publisher, None)
        if len(self._last) >= _MOST_SENDERS:
            del self._last[next(iter(self._last))]
        self._last[publisher] = number
        gap = 0 if last is None else number - last - 1
        if gap > 0:
            self._lost += gap
            console.note(
                f"A message was lost!!!\n\ttotal count change:{gap}\n\ttotal count: {self._lost}---"
            )
