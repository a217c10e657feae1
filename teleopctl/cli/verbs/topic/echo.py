"""``teleopctl topic echo``."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.command_node import brief_node, command_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.options import TopicName
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.qos_options import (
    Depth,
    DurabilityName,
    HistoryName,
    ProfileName,
    QosWishes,
    ReliabilityName,
)
from teleopctl.cli.verbs.topic.selection import filter_predicate
from teleopctl.cli.verbs.topic.source import find_source
from teleopctl.cli.verbs.topic.text import TextStyle, json_value
from teleopctl.errors import UnavailableError
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.cli.verbs.topic.source import TopicSource
    from teleopctl.node import BareNode, MessageInfo, Node

_DEPTH = 10
_TRUNCATE = 128


def echo(
    topic_name: TopicName,
    message_type: Annotated[
        str | None,
        Argument(
            help="Its type; otherwise the one that it has in the graph.", complete="message_types"
        ),
    ] = None,
    once: Annotated[bool, Option("--once", help="Print the first message and end.")] = False,
    timeout: Annotated[
        float | None, Option("--timeout", help="End after this many seconds.", metavar="SECONDS")
    ] = None,
    field: Annotated[
        str | None, Option("--field", help="Print one field, such as transforms[0].header.")
    ] = None,
    filter_expression: Annotated[
        str | None,
        Option("--filter", help="Print a message m only where this Python is true: m.data > 3."),
    ] = None,
    csv: Annotated[bool, Option("--csv", help="Print all values on one line.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
    raw: Annotated[bool, Option("--raw", help="Print the bytes as they arrive.")] = False,
    flow_style: Annotated[
        bool, Option("--flow-style", help="Print lists and mappings on one line.")
    ] = False,
    full_length: Annotated[
        bool, Option("-f", "--full-length", help="Print long lists and texts in full.")
    ] = False,
    truncate_length: Annotated[
        int,
        Option("-l", "--truncate-length", help="Longest list or text that is printed in full."),
    ] = _TRUNCATE,
    no_arr: Annotated[bool, Option("--no-arr", help="Print no elements of lists.")] = False,
    no_str: Annotated[bool, Option("--no-str", help="Print no texts.")] = False,
    include_message_info: Annotated[
        bool, Option("--include-message-info", help="Print times and numbers of each message.")
    ] = False,
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
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
) -> None:
    """Print the messages of a topic.

    The quality of service follows what the publishers offer, so that latched messages are printed
    as well. Ctrl-C ends it.
    """
    wishes = QosWishes(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth)
    topic = absolute_name(topic_name)
    if plot is not None:
        from teleopctl.cli.verbs.topic.live_plot import live_plot

        source = find_source(topic, message_type, takes_type=True, raw=raw)
        live_plot(source, plot, window, wishes.applied_to(source.suited_qos(_DEPTH)), timeout)
        return
    from teleopctl.interfaces import field_reader
    from teleopctl.node import Future, SingleThreadedExecutor

    select = field_reader(field) if field else None
    wanted = filter_predicate(filter_expression) if filter_expression else None
    style = TextStyle(
        truncate=None if full_length else truncate_length,
        flow=flow_style,
        no_arr=no_arr,
        no_str=no_str,
    )
    write = _writer(style, csv=csv, as_json=as_json, with_info=include_message_info)
    losses = None if no_lost_messages else _LossReport()
    done: Future[None] = Future()
    printed = False

    def receive(message: Any, info: "MessageInfo") -> None:
        nonlocal printed
        if done.done():
            return
        if losses is not None:
            losses.note(info)
        value = select(message) if select else message
        if wanted is not None and not wanted(value):
            return
        write(value, info)
        console.flush()
        printed = True
        if once:
            done.set_result(None)

    with (
        _listener(topic, message_type, raw=raw, once=once) as (node, source),
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        qos = wishes.applied_to(source.suited_qos(_DEPTH))
        node.create_subscription(source.message_class, source.topic, receive, qos, raw=raw)
        executor.add_node(node)
        executor.spin_until_future_complete(done, timeout)
    if timeout is not None and not printed:
        raise UnavailableError(f"No message on '{topic}' within {timeout:g} s")


@contextmanager
def _listener(
    topic: str, message_type: str | None, *, raw: bool, once: bool
) -> "Iterator[tuple[BareNode | Node, TopicSource]]":
    """A node that is to subscribe to a topic, and what is known of the topic."""
    if not once:
        source = find_source(topic, message_type, takes_type=True, raw=raw)
        with command_node() as node:
            yield node, source
        return
    # A single message may come by way of the router: that takes one session, and no peer is met.
    with brief_node(starts_router=message_type is not None) as brief:
        graph = query_graph(brief.context.session)
        source = find_source(topic, message_type, takes_type=True, raw=raw, graph=graph)
        yield brief, source


def _writer(
    style: TextStyle, *, csv: bool, as_json: bool, with_info: bool
) -> Callable[[Any, "MessageInfo"], None]:
    """The function that prints one message, or one field of it, with its information."""

    def write_json(value: Any, info: "MessageInfo") -> None:
        document = json_value(value)
        if with_info:
            document = {"info": _shown(info), "message": document}
        console.out_json(document, compact=True)

    def write_csv(value: Any, info: "MessageInfo") -> None:
        ahead = f"{','.join(str(entry) for entry in _shown(info).values())}," if with_info else ""
        console.out(ahead + style.csv(value))

    def write_yaml(value: Any, info: "MessageInfo") -> None:
        if with_info:
            lines = [f"{key}: {_yaml_scalar(entry)}" for key, entry in sorted(_shown(info).items())]
            console.out_lines([*lines, "---"])
        console.out_text(f"{style.yaml(value)}---")

    if as_json:
        return write_json
    return write_csv if csv else write_yaml


def _shown(info: "MessageInfo") -> dict[str, int | None]:
    return {key: value for key, value in info.items() if isinstance(value, int | None)}


def _yaml_scalar(value: int | None) -> str:
    return "null" if value is None else str(value)


class _LossReport:
    """Counts the gaps in each publisher's numbers and says so, as ROS 2 does."""

    def __init__(self) -> None:
        self._last: dict[bytes, int] = {}
        self._lost = 0

    def note(self, info: "MessageInfo") -> None:
        publisher, number = info["publisher_gid"], info["publication_sequence_number"]
        last = self._last.get(publisher)
        self._last[publisher] = number
        gap = 0 if last is None else number - last - 1
        if gap > 0:
            self._lost += gap
            console.warn(f"{gap} lost (in all: {self._lost}); the terminal or the link is too slow")
