"""Exchange of joint states and commands with a robot, shared by hardware components.

All components of a robot share the exchange: each state is read by all components, and answered by
one message with the commands of all, since a simulator in lockstep continues after the first one.
States arrive, and commands leave, by a channel: two topics, or memory if the simulator is in the
same process.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol
from weakref import WeakKeyDictionary

from teleopctl.interfaces import get_message, set_stamp, to_nanoseconds
from teleopctl.node import Node
from teleopctl.robot import RESET_FRAME

JOINT_STATE_FIELDS = ("position", "velocity", "effort")

# Any: message classes are generated at run time from definitions.


class ExchangeMember(Protocol):
    """Interface of hardware components that share a `JointStateExchange`."""

    def commands(self) -> tuple[list[str], dict[str, list[float]]]:
        """Return joint names, and commands of these joints by JointState field; empty if none."""


class ReceivedJointStates(Protocol):
    """Joint states as in ``sensor_msgs/msg/JointState``, valid until the next ones arrive."""

    @property
    def name(self) -> Sequence[str]:
        """Names of the joints."""

    @property
    def position(self) -> Sequence[float]:
        """Positions (rad or m), one per name, or empty."""

    @property
    def velocity(self) -> Sequence[float]:
        """Velocities (rad/s or m/s), one per name, or empty."""

    @property
    def effort(self) -> Sequence[float]:
        """Efforts (N m or N), one per name, or empty."""


class JointStateChannel(Protocol):
    """Way by which joint states arrive from a robot, and commands leave to it."""

    def open(self, on_state: Callable[[ReceivedJointStates, int, bool], None]) -> None:
        """Start to receive states.

        Args:
            on_state: Called with each state, its time in nanoseconds, and whether the robot was
                moved other than by commands since the last one (a reset).
        """

    def close(self) -> None:
        """Stop receiving states."""

    def start_sending(self) -> None:
        """Announce that commands will be sent."""

    def stop_sending(self) -> None:
        """Announce that no more commands will be sent."""

    def absence(self) -> str:
        """Return why no states can arrive, as a sentence without a period; empty if they can."""

    def send(self, time_ns: int, names: list[str], columns: Mapping[str, list[float]]) -> None:
        """Send the commands for the state of a time.

        Args:
            time_ns: Time of the state, nanoseconds.
            names: Names of the commanded joints.
            columns: Commands by JointState field, one per name.
        """


class TopicChannel:
    """Channel over two topics of ``sensor_msgs/msg/JointState``; implements JointStateChannel.

    Args:
        node: Node of the subscription and the publisher.
        states_topic: Topic of the joint states.
        commands_topic: Topic of the joint commands.
    """

    def __init__(self, node: Node, states_topic: str, commands_topic: str) -> None:
        self._node = node
        self._states_topic = states_topic
        self._commands_topic = commands_topic
        self._subscription: Any = None
        self._publisher: Any = None
        self._joint_state: Any = get_message("sensor_msgs/msg/JointState")
        # The message is reused: creating one takes longer than the rest of a cycle.
        self._command: Any = self._joint_state()

    @property
    def is_sending(self) -> bool:
        """Whether the commands have a publisher."""
        return self._publisher is not None

    def get_subscription_count(self) -> int:
        """Return the number of subscriptions to the commands; 0 without a publisher."""
        publisher = self._publisher
        return 0 if publisher is None else int(publisher.get_subscription_count())

    def absence(self) -> str:
        """Return a message if the topic of the states has no publisher; empty if it has."""
        subscription = self._subscription
        if subscription is None or subscription.get_publisher_count() > 0:
            return ""
        return f"Nothing publishes {self._states_topic} any more"

    def open(self, on_state: Callable[[ReceivedJointStates, int, bool], None]) -> None:
        """Subscribe to the joint states."""

        def receive(message: Any) -> None:
            header = message.header
            on_state(message, to_nanoseconds(header.stamp), header.frame_id == RESET_FRAME)

        # Called in the transport's thread: in lockstep the simulator waits for the answer.
        self._subscription = self._node.create_subscription(
            self._joint_state, self._states_topic, receive, 10, immediate=True
        )

    def close(self) -> None:
        """Unsubscribe from the joint states."""
        subscription, self._subscription = self._subscription, None
        self._node.destroy_subscription(subscription)

    def start_sending(self) -> None:
        """Create the publisher of the commands."""
        self._publisher = self._node.create_publisher(self._joint_state, self._commands_topic, 10)

    def stop_sending(self) -> None:
        """Destroy the publisher of the commands."""
        publisher, self._publisher = self._publisher, None
        self._node.destroy_publisher(publisher)

    def send(self, time_ns: int, names: list[str], columns: Mapping[str, list[float]]) -> None:
        """Publish the commands, stamped with the time of the state."""
        publisher = self._publisher
        if publisher is None:
            return
        message = self._command
        set_stamp(message.header.stamp, time_ns)
        message.name = names
        for field in JOINT_STATE_FIELDS:
            setattr(message, field, columns.get(field, []))
        publisher.publish(message)


class JointStateExchange:
    """Joint states received and joint commands sent, which hardware components share.

    Args:
        channel: Way by which states arrive and commands leave.

    Attributes:
        message: Last received state, or None.
        resets: Number of received states that were marked as the first after a reset.
        received: Number of received states.
        cycle: Function that runs a control cycle for each state, in lockstep; else None.
    """

    def __init__(self, channel: JointStateChannel) -> None:
        self.message: ReceivedJointStates | None = None
        self.resets = 0
        self.received = self._received_before = 0
        self.cycle: Callable[[int], None] | None = None
        self._channel = channel
        self._readers: list[ExchangeMember] = []
        self._writers: list[ExchangeMember] = []
        self._written: list[ExchangeMember] = []
        self._answered_ns = -1

    def open(self, member: ExchangeMember) -> None:
        """Add a hardware component as reader; with the first one, states are received."""
        self._readers.append(member)
        if len(self._readers) == 1:
            self.message = None
            self._channel.open(self._on_state)

    def close(self, member: ExchangeMember) -> None:
        """Remove a component as reader; after the last one, no states are received."""
        self._readers.remove(member)
        if not self._readers:
            self._channel.close()

    def activate(self, member: ExchangeMember) -> None:
        """Add a component as writer; from the first one on, commands are sent."""
        self._writers.append(member)
        if len(self._writers) == 1:
            self._channel.start_sending()

    def deactivate(self, member: ExchangeMember) -> None:
        """Remove a component as writer; after the last one, no commands are sent."""
        if member not in self._writers:
            return
        self._writers.remove(member)
        if not self._writers:
            self._channel.stop_sending()

    def write(self, member: ExchangeMember, time_ns: int) -> None:
        """Record that a component has written; send all commands once all writers have."""
        self._written.append(member)
        if all(writer in self._written for writer in self._writers):
            self._answer(time_ns)

    def absence(self) -> str:
        """Return why no states arrive; empty if some arrived since the last call, or can arrive.

        Before the first state, they may.
        """
        before, self._received_before = self._received_before, self.received
        if self.message is None or self.received != before:
            return ""
        return self._channel.absence()

    def _on_state(self, message: ReceivedJointStates, time_ns: int, reset: bool) -> None:
        self.received += 1
        self.message = message
        if reset:
            self.resets += 1
        if self.cycle is None:
            return
        try:
            self.cycle(time_ns)
        finally:
            if self._answered_ns != time_ns:
                self._answer(time_ns)

    def _answer(self, time_ns: int) -> None:
        """Send the commands of all writers; without written commands, a message of no joints."""
        writers = self._writers if self._written else []
        self._written = []
        if not self._writers:
            return
        self._answered_ns = time_ns
        if len(writers) == 1:
            self._channel.send(time_ns, *writers[0].commands())
            return
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
        self._channel.send(time_ns, names, columns)


_exchanges: WeakKeyDictionary[Node, dict[tuple[str, str], JointStateExchange]] = WeakKeyDictionary()


def exchange_of(node: Node, states_topic: str, commands_topic: str) -> JointStateExchange:
    """Return the `JointStateExchange` of a node and two topics, created on first use."""
    of_node = _exchanges.setdefault(node, {})
    topics = (states_topic, commands_topic)
    if topics not in of_node:
        of_node[topics] = JointStateExchange(TopicChannel(node, *topics))
    return of_node[topics]


def replace_topics(
    node: Node, states_topic: str, commands_topic: str, channel: JointStateChannel
) -> None:
    """Make a node's hardware components use a channel instead of two topics.

    Call it before the components are initialized.
    """
    exchange = JointStateExchange(channel)
    _exchanges.setdefault(node, {})[states_topic, commands_topic] = exchange
