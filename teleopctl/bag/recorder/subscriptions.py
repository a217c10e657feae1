"""Subscriptions of a recording: to topics as they appear, and to all of the domain at once."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import zenoh

from teleopctl.bag.recorder.definitions import DefinitionFinder
from teleopctl.bag.records import BagMessage, BagTopic, TypeText
from teleopctl.bag.type_definitions import known_definition
from teleopctl.interfaces import type_hash
from teleopctl.node import (
    DurabilityPolicy,
    HistoryPolicy,
    MessageInfo,
    QoSProfile,
    qos_for_publishers,
    raw_message_class,
)
from teleopctl.wire import decode_attachment, direct_callback

if TYPE_CHECKING:
    from collections.abc import Mapping

    from teleopctl.bag.recorder.losses import LossCounter
    from teleopctl.bag.recorder.selection import Selection
    from teleopctl.bag.recorder.writing import MessageQueue
    from teleopctl.node import MessageInfo, Node, RcutilsLogger, Subscription
    from teleopctl.wire import EndpointToken, Graph


Receiver = Callable[[bytes, MessageInfo], object]

# Limit of the kept messages; beyond it, those of the oldest topic are dropped.
_MOST_BYTES = 64 * 2**20


class DomainSubscription:
    """Zenoh subscription to all topics of a ROS domain; keeps messages until a receiver is set.

    Args:
        node: Node whose session subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._lock = threading.Lock()
        self._receivers: dict[str, Receiver | None] = {}
        self._held: dict[str, list[tuple[bytes, MessageInfo]]] = {}
        self._bytes = 0
        session = node.context.session
        self._subscriber = session.declare_subscriber(
            f"{node.context.domain_id}/**", direct_callback(self._take)
        )

    def set_receiver(self, key_expression: str, receiver: Receiver) -> None:
        """Call a receiver with the kept and all new messages of a Zenoh key expression.

        Args:
            key_expression: Key expression of a topic with one type and type hash.
            receiver: Called on threads of the transport, with messages of the same publisher one
                after the other.
        """
        with self._lock:
            for data, info in self._held.pop(key_expression, ()):
                self._bytes -= len(data)
                receiver(data, info)
            self._receivers[key_expression] = receiver

    def ignore(self, key_expression: str) -> None:
        """Drop the kept messages and all new ones of a Zenoh key expression."""
        with self._lock:
            for data, _ in self._held.pop(key_expression, ()):
                self._bytes -= len(data)
            self._receivers[key_expression] = None

    def close(self) -> None:
        """Undeclare the Zenoh subscription."""
        self._subscriber.undeclare()

    def _take(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        if self._receivers.get(key, key) is None:
            return
        attachment = sample.attachment
        meta = None if attachment is None else decode_attachment(attachment.to_bytes())
        if meta is None:
            return  # not a ROS message
        data = sample.payload.to_bytes()
        info: MessageInfo = {
            "source_timestamp": meta.time_ns,
            "received_timestamp": time.time_ns(),
            "publication_sequence_number": meta.sequence,
            "reception_sequence_number": 0,
            "publisher_gid": meta.gid,
        }
        if key in self._receivers:
            receiver = self._receivers[key]
        else:
            with self._lock:
                # `set_receiver` or `ignore` may have been called while this waited for the lock.
                if key not in self._receivers:
                    self._hold(key, data, info)
                    return
                receiver = self._receivers[key]
        if receiver is not None:
            receiver(data, info)

    def _hold(self, key: str, data: bytes, info: MessageInfo) -> None:
        self._held.setdefault(key, []).append((data, info))
        self._bytes += len(data)
        while self._bytes > _MOST_BYTES:
            oldest = next(iter(self._held))
            self._bytes -= sum(len(held) for held, _ in self._held.pop(oldest))


_LOG = "/rosout"

# Depth that rosbag2 requests for a topic without publishers.
_DEFAULT_DEPTH = 10


class PauseGate:
    """Pause state of a recorder, with the number of messages skipped while paused.

    Attributes:
        is_open: False while the recorder is paused.
        skipped: Number of messages received while paused.
    """

    def __init__(self, *, is_open: bool) -> None:
        self.is_open = is_open
        self.skipped = 0


class _Topic:
    """State of a recorded topic: subscription, sequence numbers and kept messages."""

    def __init__(self, name: str, type_name: str, version: str) -> None:
        self.name = name
        self.type_name = type_name
        self.version = version
        self.is_described = False
        self.is_latched = False
        self.subscription: Subscription[Any] | None = None
        # Sequence number of the last message of each publisher.
        self.last: dict[bytes, int] = {}
        # Last message of each publisher of a latched topic while the recorder was paused.
        self.kept: dict[bytes, BagMessage] = {}
        # Number of messages that all publishers are known to have sent; see `BagTopic`.
        self.count = 0
        self.lock = threading.Lock()
        # After a second subscription to the topic, a message may be received twice.
        self.was_renewed = False


class RecordedTopics:
    """Subscriptions of a recording, updated as topics appear in the graph.

    Args:
        node: Node that the subscriptions belong to.
        selection: Topics to record, with absolute names.
        qos: QoS profiles by topic that replace those chosen for the publishers.
        queue: Queue that received messages are added to.
        gate: Pause state of the recorder.
        losses: Counter of the lost messages.
        add_topic: Called with each topic when its definition is available.
        uses_simulated_time: Whether messages get the time of the node's clock.
        domain_subscription: Subscription that keeps the first messages of topics; None for none.
        logger: Logger of the subscriptions.
    """

    def __init__(
        self,
        node: Node,
        selection: Selection,
        qos: Mapping[str, QoSProfile],
        queue: MessageQueue,
        gate: PauseGate,
        losses: LossCounter,
        add_topic: Callable[[BagTopic], object],
        *,
        uses_simulated_time: bool,
        domain_subscription: DomainSubscription | None = None,
        logger: RcutilsLogger,
    ) -> None:
        self._domain_subscription = domain_subscription
        self._node = node
        self._logger = logger
        self._selection = selection
        self._qos = qos
        self._queue = queue
        self._gate = gate
        self._losses = losses
        self._add_topic = add_topic
        self._uses_simulated_time = uses_simulated_time
        self._definitions = DefinitionFinder(node)
        self._topics: dict[str, _Topic] = {}
        self._warned: set[str] = set()

    @property
    def names(self) -> list[str]:
        """Names of the subscribed topics, sorted."""
        return sorted(self._topics)

    def update(self, graph: Graph) -> None:
        """Subscribe to selected topics new in the graph; add those with known types to the bag."""
        named = graph.topic_names_and_types(include_hidden=True)
        # /rosout first, so that it has the recorder's log messages about the other topics.
        for name, types in sorted(named, key=lambda topic: topic[0] != _LOG):
            topic = self._topics.get(name)
            if topic is not None:
                self._renew_if_latched_now(topic, graph)
            elif self._wants(name, types, graph):
                self._begin(name, types[0], graph)
        for name, type_name in self._selection.static_topics.items():
            if name not in self._topics and self._wants(name, [type_name], graph):
                self._subscribe_unlisted(name, type_name)
        for topic in tuple(self._topics.values()):
            if not topic.is_described:
                self._describe(topic, graph)

    def request_definition(self, graph: Graph) -> bool:
        """Request one missing type definition, add its topic to the bag; False if none is left."""
        topic = next((topic for topic in self._topics.values() if not topic.is_described), None)
        if topic is None:
            return False
        text = self._definitions.request(topic.type_name, topic.version, graph)
        if not text.text:
            self._warn_once(
                f"No definition of {topic.type_name} is known here and no node explains "
                f"it: '{topic.name}' is recorded without, and can be played but not read."
            )
        self._add_described_topic(topic, graph, text)
        return True

    def record_kept_messages(self) -> None:
        """Record what latched topics received while paused; called when recording resumes."""
        now_ns = self._node.get_clock().nanoseconds()
        for topic in tuple(self._topics.values()):
            for publisher in tuple(topic.kept):
                self._put(topic.kept.pop(publisher)._replace(log_time_ns=now_ns))

    def close(self) -> None:
        """Unsubscribe from all topics; add topics without a known definition to the bag."""
        for topic in self._topics.values():
            if topic.subscription is not None:
                self._node.destroy_subscription(topic.subscription)
        graph = self._node.graph()
        for topic in self._topics.values():
            if not topic.is_described:
                self._add_described_topic(topic, graph, TypeText())

    def _wants(self, name: str, types: list[str], graph: Graph) -> bool:
        if not self._selection.chooses(name, types[0]):
            return False
        if len(types) > 1:
            self._warn_once(
                f"Topic '{name}' has more than one type associated. "
                "Only topics with one type are supported"
            )
            return False
        if not self._selection.passes_hidden_rule(name, types[0]):
            self._warn_once(
                "Hidden topics are not recorded. Enable them with --include-hidden-topics"
            )
            return False
        return self._selection.is_ready(name, graph)

    def _begin(self, name: str, type_name: str, graph: Graph) -> None:
        publishers = graph.publishers(name, type_name)
        endpoints = publishers or graph.subscriptions(name, type_name)
        if not endpoints:
            return
        version = endpoints[0].type_hash
        others = {p.type_hash for p in publishers} - {version}
        if others:
            self._warn_once(
                f"type description hashes for topic type '{type_name}' conflict: "
                f"'{version}' != '{min(others)}': of '{name}' only the first one is recorded"
            )
        self._add(_Topic(name, type_name, version), publishers)

    def _subscribe_unlisted(self, name: str, type_name: str) -> None:
        """Subscribe to a topic that the graph does not show, if its type is known here."""
        if known_definition(type_name) is None:
            self._warn_once(
                f"'{type_name}' is not known here: '{name}' is recorded from when a node shows it"
            )
            return
        self._add(_Topic(name, type_name, type_hash(type_name)), [])

    def _add(self, topic: _Topic, publishers: list[EndpointToken]) -> None:
        self._topics[topic.name] = topic
        self._subscribe(topic, publishers)
        self._logger.info(f"Subscribed to topic '{topic.name}'")

    def _subscribe(self, topic: _Topic, publishers: list[EndpointToken]) -> None:
        qos = self._qos.get(topic.name)
        if qos is None:
            qos = recording_qos(publishers)
        else:
            self._logger.info(f"Overriding subscription profile for {topic.name}")
        topic.is_latched = qos.is_latched
        receiver = self._receiver(topic)
        # Only a separate subscription receives the history of a transient local publisher.
        comes_early = self._domain_subscription is not None and not qos.is_latched
        subscription = topic.subscription = self._node.create_subscription(
            raw_message_class(topic.type_name, topic.version),
            topic.name,
            _ignore if comes_early else receiver,
            qos,
            raw=True,
            immediate=True,
        )
        if self._domain_subscription is not None and comes_early:
            self._domain_subscription.set_receiver(subscription.key, receiver)
        elif self._domain_subscription is not None:
            self._domain_subscription.ignore(subscription.key)

    def _renew_if_latched_now(self, topic: _Topic, graph: Graph) -> None:
        """Subscribe again with transient local QoS once a publisher of the topic is latched."""
        if topic.is_latched or topic.name in self._qos:
            return
        publishers = graph.publishers(topic.name, topic.type_name)
        if any(publisher.qos.is_transient_local for publisher in publishers):
            before = topic.subscription
            topic.was_renewed = True
            self._subscribe(topic, publishers)
            if before is not None:
                self._node.destroy_subscription(before)

    def _receiver(self, topic: _Topic) -> Callable[[bytes, MessageInfo], None]:
        last, gate, put, losses = topic.last, self._gate, self._put, self._losses
        clock = self._node.get_clock() if self._uses_simulated_time else None

        def receive(data: bytes, info: MessageInfo) -> None:
            publisher = info["publisher_gid"]
            number = info["publication_sequence_number"]
            before = last.get(publisher)
            lost = 0
            if before is not None and number != before + 1:
                if number > before:
                    lost = number - before - 1
                    losses.add_lost_in_transport(topic.name, lost)
                elif topic.was_renewed:
                    return
            last[publisher] = number
            if not gate.is_open:
                gate.skipped += 1
                if not topic.is_latched:
                    return
            if clock is None:
                received_ns, sent_ns = info["received_timestamp"], info["source_timestamp"]
            else:
                # One clock for both times, so that they can be compared.
                received_ns = sent_ns = clock.nanoseconds()
            if not gate.is_open:
                topic.kept[publisher] = BagMessage(
                    topic.name, received_ns, sent_ns, data, 0, publisher
                )
                return
            with topic.lock:
                topic.count = count = topic.count + 1 + lost
            put(BagMessage(topic.name, received_ns, sent_ns, data, count, publisher))

        return receive

    def _put(self, message: BagMessage) -> None:
        # Messages that arrive after the end of a recording do not count as lost.
        if not self._queue.put(message) and not self._queue.is_closed:
            self._losses.add_dropped(message.topic)

    def _describe(self, topic: _Topic, graph: Graph) -> None:
        text = self._definitions.find_local(topic.type_name, topic.version)
        if text is not None:
            self._add_described_topic(topic, graph, text)

    def _add_described_topic(self, topic: _Topic, graph: Graph, text: TypeText) -> None:
        topic.is_described = True
        offers = dict.fromkeys(p.qos for p in graph.publishers(topic.name, topic.type_name))
        self._add_topic(
            BagTopic(
                topic.name,
                topic.type_name,
                topic.version,
                text,
                tuple(offers),
                is_counted=True,
            )
        )

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            self._logger.warning(text)


def _ignore(_: bytes) -> None:
    """Ignore a message: `DomainSubscription` delivers it; the subscription is for the graph."""


def recording_qos(publishers: list[EndpointToken]) -> QoSProfile:
    """Return a QoS compatible with all publishers; transient local if any publisher is.

    The choice is that of rosbag2 with two differences, which Zenoh allows and DDS does not: earlier
    messages are requested if any publisher keeps them, and if there is no publisher yet.
    """
    if not publishers:
        return QoSProfile(depth=_DEFAULT_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    offers = [publisher.qos for publisher in publishers]
    depth = max(offer.depth for offer in offers)
    qos = qos_for_publishers(offers, depth)
    if any(offer.is_transient_local for offer in offers):
        qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
    if depth <= 1 or any(offer.history == HistoryPolicy.KEEP_ALL for offer in offers):
        qos.history = HistoryPolicy.KEEP_ALL
    return qos
