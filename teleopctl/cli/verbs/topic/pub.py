"""``teleopctl topic pub``."""

import itertools
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.command_node import brief_node, command_node
from teleopctl.cli.learning import learn_type
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
from teleopctl.cli.waiting import wait_aloud
from teleopctl.errors import InvalidFileError, UnavailableError, UsageError, what_there_is
from teleopctl.wire import EntityKind, ensure_router, query_graph, router_has_all

if TYPE_CHECKING:
    from teleopctl.node import BareNode, Node, Publisher

_DEPTH = 10
# For ROS 2's own programs it is always so long.
_KEEP_ALIVE_S = 0.1
_PRESENT_TIME = ("auto", "now")


def publish(
    topic_name: TopicName,
    message_type: Annotated[
        str, Argument(help="Its type, such as std_msgs/msg/String.", complete="message_types")
    ],
    values: Annotated[
        str, Argument(help="The message as YAML; fields left out have their defaults.")
    ] = "{}",
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
        Option("--max-wait-time-secs", help="Give up waiting after this many seconds."),
    ] = None,
    print_every: Annotated[
        int, Option("-p", "--print", help="Print only every Nth message; 0 for none.")
    ] = 1,
    keep_alive: Annotated[
        float | None,
        Option(
            "--keep-alive",
            help="Seconds to stay after the last message; by default until it is on its way.",
        ),
    ] = None,
    node_name: Annotated[
        str | None, Option("-n", "--node-name", help="Name of the publishing node.")
    ] = None,
    stdin: Annotated[bool, Option("--stdin", help="Read the message from standard input.")] = False,
    yaml_file: Annotated[
        str | None,
        Option("--yaml-file", help="Read the message from this file; - for standard input."),
    ] = None,
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
) -> None:
    """Publish messages to a topic.

    A std_msgs/msg/Header or a builtin_interfaces/msg/Time may be given as auto or now: it is the
    time of each publication.
    """
    from teleopctl.interfaces import get_message, message_from_yaml, normalize
    from teleopctl.node import QoSProfile

    if rate <= 0:
        raise UsageError("The rate must be greater than zero")
    count = 1 if once else times
    if wait_matching_subscriptions is not None and wait_matching_subscriptions < 0:
        raise UsageError("There cannot be less than 0 subscriptions")
    file = "-" if stdin else yaml_file
    text = _read(file) if file else values
    learn_type(normalize(message_type))
    message_class = get_message(message_type)
    message = message_from_yaml(message_class, text)  # a mistake is reported before anything starts
    is_stamped = any(word in text for word in _PRESENT_TIME)
    wishes = QosWishes(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth)
    qos = wishes.applied_to(QoSProfile(depth=_DEPTH))
    subscribers = wait_matching_subscriptions
    if subscribers is None:
        subscribers = 1 if count else 0
    if count != 1:
        ensure_router()
    # What a peer publishes while it still meets the others is lost; a client's goes through the
    # router, which knows them all.
    with (
        brief_node(name=node_name, starts_router=True)
        if count == 1
        else command_node(name=node_name)
    ) as node:
        publisher = node.create_publisher(message_class, absolute_name(topic_name), qos)
        if subscribers:
            _wait_for_subscribers(node, publisher, subscribers, max_wait_time)
        console.out("publisher: beginning loop")
        console.flush()
        for number in _paced(rate, count):
            if is_stamped:
                now = node.get_clock().now().to_msg()
                message = message_from_yaml(message_class, text, now=now)
            if print_every and number % print_every == 0:
                console.out_text(f"publishing #{number}: {message!r}\n")
                console.flush()
            publisher.publish(message)
        if keep_alive is not None:
            time.sleep(max(0.0, keep_alive))
        elif not router_has_all(node.context.session):
            time.sleep(_KEEP_ALIVE_S)


def _paced(rate: float, count: int) -> Iterator[int]:
    """Count from 1 to ``count``, or without end where it is 0, at a rate in Hz.

    Each number is due against the start, so that the lateness of one does not delay all others.
    """
    start = time.monotonic()
    for number in itertools.count():
        if count and number == count:
            return
        time.sleep(max(0.0, start + number / rate - time.monotonic()))
        yield number + 1


def _wait_for_subscribers(
    node: "Node | BareNode", publisher: "Publisher[Any]", count: int, longest_wait_s: float | None
) -> None:
    topic, type_name = publisher.topic_name, publisher.type_name
    graph = query_graph(node.context.session)
    if len(graph.subscriptions(topic, type_name)) >= count:
        return
    others = sorted({each.type_name for each in graph.subscriptions(topic)} - {type_name})
    if others:
        console.warn(f"topic [{topic}] is subscribed with the type {', '.join(others)}")
    console.note(f"Waiting for at least {count} matching subscription(s)...")

    def explain() -> str:
        graph = node.graph()
        if came := len(graph.subscriptions(topic, type_name)):
            return f"'{topic}' has {came} of {count} subscribers yet."
        heard = [name for name, _ in graph.topic_names_and_types() if graph.subscriptions(name)]
        there_is = what_there_is("topics that anybody subscribes", [topic], heard)
        return f"Nobody subscribes '{topic}' yet. {there_is}"

    if not wait_aloud(
        lambda time_s: node.wait_for_match(EntityKind.MS, topic, type_name, count, time_s),
        longest_wait_s,
        explain,
    ):
        came = publisher.get_subscription_count()
        raise UnavailableError(
            f"Only {came} of {count} subscribers came to '{topic}' within {longest_wait_s:g} s",
            hint="-w 0 publishes without a subscriber.",
        )


def _read(file: str) -> str:
    if file != "-":
        from teleopctl.text_file import read_text

        return read_text(Path(file))
    try:
        return sys.stdin.buffer.read().decode("utf-8")
    except UnicodeDecodeError as error:
        raise InvalidFileError("Cannot read standard input: it is not UTF-8 text") from error
