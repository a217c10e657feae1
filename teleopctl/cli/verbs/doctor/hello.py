"""``teleopctl doctor hello``: connectivity to other machines by a topic and by multicast."""

import os
import re
import socket
import threading
import time
from collections import Counter
from collections.abc import Iterator

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.multicast import (
    MULTICAST_GROUP,
    MULTICAST_PORT,
    open_receiver,
    receive_datagram,
    send_datagram,
)
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import deserialize, get_message


def hello(
    topic: Annotated[str, Option("-t", "--topic", help="The topic to talk on.")] = "/canyouhearme",
    emit_period: Annotated[
        float, Option("-ep", "--emit-period", help="Seconds from one message to the next.")
    ] = 0.1,
    print_period: Annotated[
        float, Option("-pp", "--print-period", help="Seconds from one table to the next.")
    ] = 1.0,
    ttl: Annotated[
        int | None, Option("--ttl", help="Number of routers that a datagram may pass.", metavar="N")
    ] = None,
    once: Annotated[
        bool, Option("-1", "--once", help="Print one table, after one period, and end.")
    ] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a period.")] = False,
) -> None:
    """Check the connectivity to other machines that run this command.

    Prints a table each period: the messages received from each host, by topic and by UDP multicast.
    """
    for flag, value in (("--emit-period", emit_period), ("--print-period", print_period)):
        if not value > 0:
            raise UsageError(f"{flag} must be positive, not {value}")
    if ttl is not None and not 0 < ttl < 256:
        raise UsageError(f"--ttl is 1 to 255, not {ttl}")
    here = socket.gethostname()
    summary = _Summary(here)
    string = get_message("std_msgs/msg/String")

    def count(data: bytes) -> None:
        try:
            summary.count_greeting(summary.by_topic, deserialize(data, string).data)
        except TeleopctlError:
            return  # the message is not a greeting

    name = f"ros2doctor_{re.sub('[^0-9a-zA-Z_]', '_', here)}_{os.getpid()}_node"
    with command_node(name=name) as node, open_receiver() as receiver:
        publisher = node.create_publisher(string, topic, 10)
        node.create_subscription(string, topic, count, 10, raw=True, immediate=True)
        threading.Thread(target=_receive, args=(receiver, summary), daemon=True).start()
        greeting = f"hello, it's me {here}"
        next_table = time.monotonic() + print_period
        while True:
            publisher.publish(string(data=greeting))
            send_datagram(greeting.encode(), ttl=ttl)
            summary.sent += 1
            time.sleep(emit_period)
            if once or time.monotonic() >= next_table:
                next_table += print_period
                if as_json:
                    console.out_json(summary.document(topic), compact=True)
                else:
                    console.out_lines(summary.table(topic, print_period))
                console.flush()
                summary.start_period()
            if once:
                break


def _receive(receiver: socket.socket, summary: "_Summary") -> None:
    while True:
        try:
            text, _, _ = receive_datagram(receiver)
        except OSError:
            return  # the socket was closed at the end of the verb
        summary.count_greeting(summary.by_multicast, text)


class _Summary:
    """Counts of greetings that were sent, and of received ones by host.

    Args:
        here: Name of this host, which receives its own greetings too.
    """

    def __init__(self, here: str) -> None:
        self._here = here
        self.sent = 0
        self.by_topic: Counter[str] = Counter()
        self.by_multicast: Counter[str] = Counter()

    def count_greeting(self, counts: Counter[str], greeting: str) -> None:
        """Count a greeting by the host that sent it; greetings of this host are ignored."""
        words = greeting.split()
        if words and words[-1] != self._here:
            counts[words[-1]] += 1

    def start_period(self) -> None:
        """Reset all counts for a new period."""
        self.sent = 0
        self.by_topic.clear()
        self.by_multicast.clear()

    def document(self, topic: str) -> dict[str, console.Json]:
        """Return the greetings sent, and those received by host, in the period as a JSON object."""
        return {
            "topic": topic,
            "sent": self.sent,
            "received_by_topic": dict(self.by_topic),
            "received_by_multicast": dict(self.by_multicast),
        }

    def table(self, topic: str, period_s: float) -> Iterator[str]:
        """Yield the lines of the table of counts that ros2 prints."""
        yield "MULTIMACHINE COMMUNICATION SUMMARY"
        yield f"Topic: {topic}, Published Msg Count: {self.sent}"
        yield "Subscribed from:"
        yield from _rows(self.by_topic, period_s)
        group = f"{MULTICAST_GROUP}/{MULTICAST_PORT}"
        yield f"Multicast Group/Port: {group}, Sent Msg Count: {self.sent}"
        yield "Received from:"
        yield from _rows(self.by_multicast, period_s)
        yield "-" * 60


def _rows(counts: Counter[str], period_s: float) -> Iterator[str]:
    yield f"{'':<15} {'Hostname':<20} {f'Msg Count /{period_s}s':<10}"
    for host, count in sorted(counts.items()):
        yield f"{'':<15} {host:<20} {count:<10}"
