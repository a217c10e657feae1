"""``teleopctl topic pub``."""

import itertools
import sys
import time

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Iterator
from teleopctl.cli import console
from teleopctl.cli.command_node import brief_node, command_node
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.messages import message_class_named, message_from_values, yaml_documents
from teleopctl.cli.options import TopicName, UseSimTime, check_not_negative, check_positive
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.qos import QosOptions
from teleopctl.errors import (
    InvalidFileError,
    RefusedError,
    UnavailableError,
    UsageError,
    existing_names_hint,
)
from teleopctl.wire import EntityKind, RouterNotRunning, flush_to_router, query_graph

if TYPE_CHECKING:
    import zenoh

    from teleopctl.node import BareNode, Node, Publisher
    from teleopctl.wire import Graph

_DEPTH = 10
# Default of ROS 2, in seconds.
_KEEP_ALIVE_S = 0.1
_PRESENT_TIME = ("auto", "now")


def publish(
    topic_name: TopicName,
    message_type: Annotated[
        str, Argument(help="Its type, such as std_msgs/msg/String.", complete="message_types")
    ],
    values: Annotated[
        str | None,
        Argument(
            help="The message as YAML; fields left out have their defaults.",
            complete="prototypes",
        ),
    ] = None,
    rate: Annotated[float, Option("-r", "--rate", help="Messages per second.", metavar="HZ")] = 1.0,
    once: Annotated[bool, Option("-1", "--once", help="Publish one message and end.")] = False,
    times: Annotated[
        int, Option("-t", "--times", help="Publish this many and end; 0 for no end.")
    ] = 0,
    wait_matching_subscriptions: Annotated[
        int | None,
        Option(
            "-w",
            "--wait-matching-subscriptions",
            help="Wait for this many subscribers first; 1 with --once and --times, else 0.",
        ),
    ] = None,
    max_wait_time: Annotated[
        float | None,
        Option("--max-wait-time-secs", help="Seconds to wait at most."),
    ] = None,
    print_every: Annotated[
        int, Option("-p", "--print", help="Print only every Nth message; 0 for none.")
    ] = 1,
    keep_alive: Annotated[
        float | None,
        Option(
            "--keep-alive",
            help="Seconds to stay after the last message; by default until it is sent.",
        ),
    ] = None,
    node_name: Annotated[
        str | None, Option("-n", "--node-name", help="Name of the publishing node.")
    ] = None,
    stdin: Annotated[
        bool, Option("--stdin", help="Read the message, or several, from standard input.")
    ] = False,
    yaml_file: Annotated[
        str | None,
        Option(
            "--yaml-file",
            help="Publish each document of this file and end; - for standard input.",
        ),
    ] = None,
    use_sim_time: UseSimTime = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
    *,
    qos: QosOptions,
) -> None:
    """Publish messages to a topic.

    A std_msgs/msg/Header or builtin_interfaces/msg/Time given as auto or now is set to the time of
    each publication. The output of topic echo, as YAML or JSON lines, is published message by
    message.
    """
    check_positive(rate=rate, max_wait_time_secs=max_wait_time)
    check_not_negative(
        times=times,
        print=print_every,
        keep_alive=keep_alive,
        wait_matching_subscriptions=wait_matching_subscriptions,
    )
    if once and times:
        raise UsageError("--once and --times contradict each other; give one of them")
    if sum((stdin, yaml_file is not None, values is not None)) > 1:
        raise UsageError(
            "The message is given more than once: give only one of MESSAGE, --stdin and the file"
        )
    file = "-" if stdin else yaml_file
    documents = yaml_documents(_read(file) if file else "{}" if values is None else values)
    message_class = message_class_named(message_type)
    messages = _Messages(message_class, documents)
    count = 1 if once else times
    subscribers = wait_matching_subscriptions
    if subscribers is None:
        subscribers = 1 if count else 0
    if not subscribers and max_wait_time is not None:
        raise RefusedError(
            "--max-wait-time-secs option is only effective with --wait-matching-subscriptions, "
            "--once or --times"
        )
    is_played = yaml_file is not None or len(documents) > 1
    if is_played:
        count = min(count or len(documents), len(documents))
    is_brief = count == 1 and not use_sim_time
    if is_brief and not (is_played or qos.are_given or messages.depend_on_time):
        sent = _publish_at_once(
            messages, topic_name, node_name, subscribers, keep_alive, print_every, as_json=as_json
        )
        if sent:
            return
    from teleopctl.node import QoSProfile

    profile = qos.applied_to(QoSProfile(depth=_DEPTH))
    if not is_brief:
        from teleopctl.wire import ensure_router

        ensure_router()
    # Messages that a peer publishes before it is connected to the others are lost; those of a
    # client go through the router, which is connected to all.
    with (
        brief_node(name=node_name, starts_router=True)
        if is_brief
        else command_node(
            session_mode="client" if count == 1 or is_played else "peer",
            name=node_name,
            use_sim_time=use_sim_time,
        )
    ) as node:
        publisher = node.create_publisher(message_class, absolute_name(topic_name), profile)
        if subscribers:
            _wait_for_subscribers(node, publisher, subscribers, max_wait_time)
        else:
            _note_another_type(node.graph(), publisher)
        if not as_json:
            console.out("publisher: beginning loop")
            console.flush()
        if use_sim_time:
            from teleopctl.cli.waiting import wait_for_clock

            wait_for_clock(node)
        for number in _paced(node, rate, count):
            message = messages.at(number, node)
            if print_every and number % print_every == 0:
                _print_message(number, publisher.topic_name, message, as_json)
            publisher.publish(message)
        _wait_until_sent(node.context.session, keep_alive)


def _publish_at_once(
    messages: "_Messages",
    topic: str,
    node_name: str | None,
    subscribers: int,
    keep_alive_s: float | None,
    print_every: int,
    *,
    as_json: bool,
) -> bool:
    """Publish the first message if its subscribers are there; return whether it was published."""
    from teleopctl.cli.brief_endpoints import BriefNode
    from teleopctl.cli.command_node import command_node_name
    from teleopctl.interfaces import serialize
    from teleopctl.wire import EndpointQos, Graph, query_endpoints

    message = messages.first
    type_name: str = message.TYPE_NAME
    try:
        opened = BriefNode(node_name or command_node_name())
    except RouterNotRunning:
        return False
    with opened as node:
        name = node.resolve_topic_name(absolute_name(topic))
        graph = query_endpoints(node.session, name) if subscribers else Graph()
        found = graph.subscriptions(name, type_name)
        if len(found) < subscribers:
            return False
        if not as_json:
            console.out("publisher: beginning loop")
        if print_every == 1:
            _print_message(1, name, message, as_json)
        node.publish(name, type_name, serialize(message), EndpointQos(depth=_DEPTH))
        _wait_until_sent(node.session, keep_alive_s)
    return True


def _wait_until_sent(session: "zenoh.Session", keep_alive_s: float | None) -> None:
    """Wait for the given time, else until what was published has left this process."""
    if keep_alive_s is not None:
        time.sleep(keep_alive_s)
    elif not flush_to_router(session):
        time.sleep(_KEEP_ALIVE_S)


# Any: a message of any type.
def _print_message(number: int, topic: str, message: Any, as_json: bool) -> None:
    if as_json:
        from teleopctl.cli.verbs.topic.text import json_value

        console.out_json(
            {"topic": topic, "number": number, "message": json_value(message)}, compact=True
        )
    else:
        console.out_text(f"publishing #{number}: {message!r}\n")
    console.flush()


class _Messages:
    """The messages that are published in turn.

    Args:
        message_class: Class of the messages.
        documents: YAML document of each message.

    Raises:
        InvalidMessageError: A document does not match the type; raised before the node starts.
    """

    # Any, here and below: messages of any type.
    def __init__(self, message_class: type[Any], documents: list[object]) -> None:
        self._class = message_class
        self._messages = [(each, message_from_values(message_class, each)) for each in documents]

    @property
    def first(self) -> Any:
        """The first message, without the time of a node."""
        return self._messages[0][1]

    @property
    def depend_on_time(self) -> bool:
        """Whether a message has the time at which it is published."""
        return any(_has_time(document) for document, _ in self._messages)

    def at(self, number: int, node: "Node | BareNode") -> Any:
        """Return the n-th message of a repeating list; ``auto`` and ``now`` get the node's time."""
        document, message = self._messages[(number - 1) % len(self._messages)]
        if _has_time(document):
            return message_from_values(self._class, document, node.get_clock().now().to_msg())
        return message


def _has_time(document: object) -> bool:
    return any(word in str(document) for word in _PRESENT_TIME)


def _paced(node: "Node | BareNode", rate: float, count: int) -> Iterator[int]:
    """Count from 1 to ``count``, or without end if it is 0, at a rate in Hz.

    Each number is due at a time relative to the start, so that a late one does not delay the next.
    The time is that of ``/clock`` if the node's clock follows it, else steady time.
    """
    from teleopctl.node import Duration

    clock = node.get_clock()
    start, start_s = clock.now(), time.monotonic()
    for number in itertools.count():
        if count and number == count:
            return
        if clock.ros_time_is_active:
            clock.sleep_until(start + Duration(seconds=number / rate), node.context)
        else:
            time.sleep(max(0.0, start_s + number / rate - time.monotonic()))
        yield number + 1


def _wait_for_subscribers(
    node: "Node | BareNode", publisher: "Publisher[Any]", count: int, longest_wait_s: float | None
) -> None:
    from teleopctl.cli.waiting import wait_with_notice

    topic, type_name = publisher.topic_name, publisher.type_name
    graph = query_graph(node.context.session)
    if len(graph.subscriptions(topic, type_name)) >= count:
        return
    console.note(f"Waiting for at least {count} matching subscription(s)...")

    def explain() -> str:
        graph = node.graph()
        if came := len(graph.subscriptions(topic, type_name)):
            return f"'{topic}' has {came} of {count} subscribers yet."
        subscribed = [
            name
            for name, _ in graph.topic_names_and_types()
            if name != topic and graph.subscriptions(name)
        ]
        hint = existing_names_hint("topics with subscriptions", [topic], subscribed)
        return f"No subscription to '{topic}' yet. {hint}"

    def wait(time_s: float | None) -> bool:
        return node.wait_for_match(EntityKind.MS, topic, type_name, count, time_s)

    is_explained = _note_another_type(graph, publisher)
    if not (
        wait(longest_wait_s) if is_explained else wait_with_notice(wait, longest_wait_s, explain)
    ):
        came = publisher.get_subscription_count()
        raise UnavailableError(
            # The misspelling is ROS 2's.
            f"Timed out waiting for subscribers: Expected {count} subcribers but only got {came} "
            "subscribers",
            hint="-w 0 publishes without a subscriber.",
        )


def _note_another_type(graph: "Graph", publisher: "Publisher[Any]") -> bool:
    """Print to stderr that a topic has another type, if it has; return whether it has."""
    topic, type_name = publisher.topic_name, publisher.type_name
    ends = (*graph.publishers(topic), *graph.subscriptions(topic))
    others = sorted({each.type_name for each in ends} - {type_name})
    if not others or graph.subscriptions(topic, type_name):
        return False
    console.note(f"'{topic}' has the type {' and '.join(others)}, not {type_name}.")
    return True


def _read(file: str) -> str:
    if file != "-":
        from pathlib import Path

        from teleopctl.base.files import read_text

        return read_text(Path(file))
    try:
        return sys.stdin.buffer.read().decode("utf-8")
    except UnicodeDecodeError as error:
        raise InvalidFileError("Cannot read standard input: it is not UTF-8 text") from error
