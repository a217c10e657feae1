"""Exchange of joint states and commands over two topics, shared by hardware components.

All components of a robot share the topics: each state is read by all components, and answered by
one message with the commands of all, since a simulator in lockstep continues after the first one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol
from weakref import WeakKeyDictionary

from teleopctl.interfaces import get_message, set_stamp, to_nanoseconds
from teleopctl.node import Node
from teleopctl.robot import RESET_FRAME

FIELDS = ("position", "velocity", "effort")

# Any: message classes are generated at run time from definitions.


class ExchangeMember(Protocol):
    """Interface of hardware components that share a `JointStateExchange`."""

    def commands(self) -> tuple[list[str], dict[str, list[float]]]:
        """Return joint names, and commands of these joints by JointState field; empty if none."""


class JointStateExchange:
    """Joint state subscription and joint command publisher that hardware components share.

    Attributes:
        message: Last received state, or None.
        resets: Number of received states that were marked as the first after a reset.
        cycle: Function that runs a control cycle for each state, in lockstep; else None.
    """

    def __init__(self, node: Node, states_topic: str, commands_topic: str) -> None:
        self.message: Any = None
        self.resets = 0
        self.cycle: Callable[[int], None] | None = None
        self._node = node
        self._states_topic = states_topic
        self._commands_topic = commands_topic
        self._readers: list[ExchangeMember] = []
        self._writers: list[ExchangeMember] = []
        self._written: list[ExchangeMember] = []
        self._subscription: Any = None
        self._publisher: Any = None
        self._answered_ns = -1
        self._joint_state: Any = get_message("sensor_msgs/msg/JointState")
        # The message is reused: creating one takes longer than the rest of a cycle.
        self._command: Any = self._joint_state()

    def open(self, member: ExchangeMember) -> None:
        """Add a hardware component as reader; the first one subscribes to the joint states."""
        self._readers.append(member)
        if self._subscription is None:
            self.message = None
            # Called in the transport's thread: in lockstep the simulator waits for the answer.
            self._subscription = self._node.create_subscription(
                self._joint_state, self._states_topic, self._received, 10, immediate=True
            )

    def close(self, member: ExchangeMember) -> None:
        """Remove a component as reader; unsubscribe after the last reader."""
        self._readers.remove(member)
        if not self._readers:
            subscription, self._subscription = self._subscription, None
            self._node.destroy_subscription(subscription)

    def activate(self, member: ExchangeMember) -> None:
        """Add a component as writer; create the command publisher for the first writer."""
        self._writers.append(member)
        if self._publisher is None:
            self._publisher = self._node.create_publisher(
                self._joint_state, self._commands_topic, 10
            )

    def deactivate(self, member: ExchangeMember) -> None:
        """Remove a component as writer; destroy the command publisher after the last writer."""
        if member not in self._writers:
            return
        self._writers.remove(member)
        if not self._writers:
            publisher, self._publisher = self._publisher, None
            self._node.destroy_publisher(publisher)

    def write(self, member: ExchangeMember, time_ns: int) -> None:
        """Record that a component has written; publish all commands once all writers have."""
        self._written.append(member)
        if all(writer in self._written for writer in self._writers):
            self._answer(time_ns)

    def _received(self, message: Any) -> None:
        self.message = message
        if message.header.frame_id == RESET_FRAME:
            self.resets += 1
        if self.cycle is None:
            return
        time_ns = to_nanoseconds(message.header.stamp)
        try:
            self.cycle(time_ns)
        finally:
            if self._answered_ns != time_ns:
                self._answer(time_ns)

    def _answer(self, time_ns: int) -> None:
        """Publish the commands of all writers; without written commands, a message of no joints."""
        writers = self._writers if self._written else []
        self._written = []
        publisher = self._publisher
        if publisher is None:
            return
        message = self._command
        set_stamp(message.header.stamp, time_ns)
        names: list[str] = []
        columns: dict[str, list[float]] = {}
        for member in writers:
            joints, values = member.commands()
            for field in {*columns, *values}:
                column = columns.setdefault(field, [])
                # Joints of previous components without this field get NaN.
                column += [float("nan")] * (len(names) - len(column))
                column += values.get(field) or [float("nan")] * len(joints)
            names += joints
        message.name = names
        for field in FIELDS:
            setattr(message, field, columns.get(field, []))
        self._answered_ns = time_ns
        publisher.publish(message)


_exchanges: WeakKeyDictionary[Node, dict[tuple[str, str], JointStateExchange]] = WeakKeyDictionary()


def exchange_of(node: Node, states_topic: str, commands_topic: str) -> JointStateExchange:
    """Return the `JointStateExchange` of a node and two topics, created on first use."""
    of_node = _exchanges.setdefault(node, {})
    topics = (states_topic, commands_topic)
    if topics not in of_node:
        of_node[topics] = JointStateExchange(node, *topics)
    return of_node[topics]
