"""``teleopctl topic echo``."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli.command_node import brief_node, command_node
from teleopctl.cli.options import TopicName, UseSimTime
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.echo_text import EchoText, LossReport
from teleopctl.cli.verbs.topic.named_topics import NamedTopics
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
from teleopctl.cli.verbs.topic.text_options import (
    TRUNCATE,
    Csv,
    FlowStyle,
    FullLength,
    NoArr,
    NoStr,
    TruncateLength,
    style_of,
)
from teleopctl.cli.words.numbers import check_positive
from teleopctl.errors import InvalidMessageError, UnavailableError
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.cli.verbs.topic.source import TopicSource
    from teleopctl.node import BareNode, MessageInfo, Node

_DEPTH = 10


def echo(
    topic_name: TopicName,
    message_type: Annotated[
        str | None,
        Argument(
            help="Its type; otherwise the one that it has in the graph.",
            complete="message_types",
        ),
    ] = None,
    more: Annotated[
        list[str] | None,
        Argument(
            help="More topics, each with its type behind it or not.",
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
    csv: Csv = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
    raw: Annotated[bool, Option("--raw", help="Print the bytes as they arrive.")] = False,
    flow_style: FlowStyle = False,
    full_length: FullLength = False,
    truncate_length: TruncateLength = TRUNCATE,
    no_arr: NoArr = False,
    no_str: NoStr = False,
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
        float, Option("--window", help="With --plot: how far back.", metavar="SECONDS")
    ] = 10.0,
    no_lost_messages: Annotated[
        bool, Option("--no-lost-messages", help="Do not report lost messages.")
    ] = False,
    use_sim_time: UseSimTime = False,
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
    qos_liveliness: LivelinessName = None,
    qos_liveliness_lease_duration_seconds: LeaseDuration = None,
) -> None:
    """Print the messages of topics.

    The quality of service follows what the publishers offer, so that latched messages are printed
    as well. Of several topics, each message has the name before it. Ctrl-C ends it.
    """
    check_positive(timeout=timeout)
    wishes = QosWishes(
        *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
        *(qos_liveliness, qos_liveliness_lease_duration_seconds),
    )
    for path in field or ():
        if not path.strip("."):
            raise InvalidMessageError(f"Invalid field value '{path}'")
    wanted = filter_predicate(filter_expression) if filter_expression else None
    topics = NamedTopics([topic_name, *([message_type] if message_type else []), *(more or ())])
    text = EchoText(
        style_of(
            flow_style=flow_style,
            full_length=full_length,
            truncate_length=truncate_length,
            no_arr=no_arr,
            no_str=no_str,
        ),
        field or (),
        "json" if as_json else "csv" if csv else "yaml",
        with_info=include_message_info,
        names_topics=topics.are_several,
        clears=clear,
    )
    if plot is not None:
        from teleopctl.cli.verbs.topic.live_plot import live_plot

        topics.only()
        (source,) = topics.sources(raw=False)
        live_plot(source, plot, window, wishes.suited(source.suited_qos(_DEPTH)), timeout)
        return
    from teleopctl.node import Future, SingleThreadedExecutor

    losses = None if no_lost_messages else LossReport()
    done: Future[None] = Future()
    printed = False

    def receive(source: "TopicSource", message: Any, info: "MessageInfo") -> None:
        nonlocal printed
        if done.done():
            return
        if losses is not None:
            losses.note(info)
        values = text.chosen(message)
        if wanted is not None and not wanted(values[0]):
            return
        text.write(source.topic, values, info)
        printed = True
        if once:
            done.set_result(None)

    with (
        (
            _brief_listener(topics, node_name, raw=raw)
            if once and not use_sim_time
            else _listener(topics, node_name, raw=raw, use_sim_time=use_sim_time)
        ) as (node, sources),
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        for source in sources:
            node.create_subscription(
                source.message_class,
                source.topic,
                _with_source(receive, source),
                wishes.suited(source.suited_qos(_DEPTH)),
                raw=raw,
            )
        executor.add_node(node)
        executor.spin_until_future_complete(done, timeout)
    if timeout is not None and not printed:
        names = "', '".join(source.topic for source in sources)
        raise UnavailableError(f"No message on '{names}' within {timeout:g} s")


@contextmanager
def _listener(
    topics: NamedTopics, name: str | None, *, raw: bool, use_sim_time: bool
) -> "Iterator[tuple[Node, list[TopicSource]]]":
    """A node that is to subscribe to topics, and what is known of them."""
    sources = topics.sources(raw=raw)
    with command_node(name=name, use_sim_time=use_sim_time) as node:
        yield node, sources


@contextmanager
def _brief_listener(
    topics: NamedTopics, name: str | None, *, raw: bool
) -> "Iterator[tuple[BareNode, list[TopicSource]]]":
    """The same for a single message, by way of the router: in one session, meeting no peer."""
    with brief_node(name=name, starts_router=topics.have_types) as node:
        yield node, topics.sources(raw=raw, graph=query_graph(node.context.session))


# Any: messages of any type.
def _with_source(
    receive: "Callable[[TopicSource, Any, MessageInfo], None]", source: "TopicSource"
) -> Callable[[Any, "MessageInfo"], None]:
    """A callback that tells of which topic a message is."""

    def call(message: Any, info: "MessageInfo") -> None:
        receive(source, message, info)

    return call
