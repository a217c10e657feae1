"""Publishers and service clients through which a player sends the messages of bags."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from teleopctl.bag.player.options import PlayOptions, RequestSource
from teleopctl.bag.player.source import FileSplit, latched_depth_of
from teleopctl.bag.records import CDR, BagMessage, BagTopic
from teleopctl.bag.topic_kinds import EVENT_TOPIC_SUFFIX, TopicKind, kind_of
from teleopctl.bag.type_definitions import register_types, topic_type_hash
from teleopctl.errors import InvalidMessageError, TeleopctlError, UnsupportedError
from teleopctl.interfaces import deserialize, get_message, get_service
from teleopctl.node import HistoryPolicy, QoSProfile, ReliabilityPolicy, raw_message_class
from teleopctl.wire import EndpointQos

if TYPE_CHECKING:
    from teleopctl.node import Node


# Depth for a topic without recorded QoS profiles, as in rosbag2.
_DEPTH = 10


def publisher_qos(topic: BagTopic) -> QoSProfile | None:
    """Return the QoS profile to publish a recorded topic with; None if recorded ones differ.

    Profiles differ if a policy that QoS compatibility depends on differs; history, depth and
    lifespan may differ.
    """
    if not topic.qos:
        return QoSProfile(depth=_DEPTH)
    if len({_decisive(profile) for profile in topic.qos}) > 1:
        return None
    profile = QoSProfile.from_wire(topic.qos[0])
    return QoSProfile(
        depth=max(latched_depth_of(topic), _depth(topic.qos)),
        reliability=profile.reliability,
        durability=profile.durability,
        deadline=profile.deadline,
        lifespan=profile.lifespan,
        liveliness=profile.liveliness,
        liveliness_lease_duration=profile.liveliness_lease_duration,
    )


def default_publisher_qos() -> QoSProfile:
    """Return the default QoS (depth 10), for topics whose publishers offered different ones."""
    return QoSProfile(depth=_DEPTH)


def as_keep_all(profile: QoSProfile) -> QoSProfile:
    """Return a reliable, non-latched QoS profile with keep-all history; other profiles unchanged.

    Latched profiles are unchanged because late subscribers should receive the last messages, not
    all.
    """
    if profile.reliability == ReliabilityPolicy.BEST_EFFORT or profile.is_latched:
        return profile
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL,
        reliability=profile.reliability,
        durability=profile.durability,
        deadline=profile.deadline,
        lifespan=profile.lifespan,
        liveliness=profile.liveliness,
        liveliness_lease_duration=profile.liveliness_lease_duration,
    )


def _depth(profiles: Sequence[EndpointQos]) -> int:
    return max(profile.depth for profile in profiles) or _DEPTH


def _decisive(profile: EndpointQos) -> tuple[object, ...]:
    return (
        *(profile.reliability, profile.durability, profile.deadline_ns),
        *(profile.liveliness, profile.lease_ns),
    )


_FIRST_LOOK_S = 1.0
# Event types of requests in service_msgs/msg/ServiceEventInfo, by the side that published them.
_EVENTS = {"client_introspection": 0, "service_introspection": 1}


class RequestSender:
    """Service client that sends the requests recorded in a service's introspection events.

    Args:
        node: Node of the service client.
        topic: Topic of the introspection events.
        source: Side whose events are used, since a bag may hold each request once for each side.

    Raises:
        TeleopctlError: The type of the service is unknown.
    """

    def __init__(self, node: Node, topic: BagTopic, source: RequestSource) -> None:
        self._node = node
        self._event_class = get_message(topic.type_name)
        self._event_type = _EVENTS[source]
        self._log = node.get_logger()
        self._warned: set[str] = set()
        self._discovery_wait_s = _FIRST_LOOK_S
        # Any: the request and response types of the service.
        self._client: Any = node.create_client(
            get_service(topic.type_name.removesuffix("_Event")),
            topic.name.removesuffix(EVENT_TOPIC_SUFFIX),
        )

    def send(self, message: BagMessage) -> bool:
        """Send the request in a recorded event; return False without request or server."""
        try:
            event = deserialize(message.data, self._event_class)
        except InvalidMessageError as error:
            self._log.error(
                f"Failed to deserialize service event message for '{self._name}' service! "
                f"{error.message}"
            )
            return False
        if event.info.event_type != self._event_type:
            return False
        if not event.request:
            self._warn_once(
                f"Can't send service request. The configuration of introspection for "
                f"'{self._name}' was metadata only!"
            )
            return False
        if not self._is_served():
            self._log.error(
                f"Service request hasn't been sent. The '{self._name}' service isn't ready !"
            )
            return False
        self._client.call_async(event.request[0])
        return True

    def _is_served(self) -> bool:
        # A player that has just started may not have discovered the service yet.
        wait_s, self._discovery_wait_s = self._discovery_wait_s, 0.0
        ready: bool = self._client.service_is_ready() or (
            wait_s > 0 and self._client.wait_for_service(timeout_sec=wait_s)
        )
        return ready

    def close(self) -> None:
        """Destroy the service client."""
        self._node.destroy_client(self._client)

    @property
    def _name(self) -> str:
        return str(self._client.srv_name)

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            self._log.warning(text)


_SPLITS = "events/read_split"
_SPLIT_EVENT = "rosbag2_interfaces/msg/ReadSplitEvent"
# As in rosbag2.
_SPLIT_QOS = QoSProfile(depth=3)

_Send = Callable[[BagMessage], bool]


class PlayerOutputs:
    """Publishers and service clients through which a player sends the messages of bags.

    Args:
        node: Node of the publishers and clients.
        topics: Topics of the bags.
        options: Options with selection, QoS and handling of requests.
    """

    def __init__(self, node: Node, topics: Collection[BagTopic], options: PlayOptions) -> None:
        self._node = node
        self._options = options
        self._log = node.get_logger()
        selection = options.selection.with_absolute_names(self._absolute)
        self._overrides = {
            self._absolute(name): profile for name, profile in options.qos_overrides.items()
        }
        self._sends: dict[str, _Send] = {}
        self._undo = ExitStack()
        split_qos = self._overrides.get(self._absolute(_SPLITS), _SPLIT_QOS)
        self._splits = node.create_publisher(get_message(_SPLIT_EVENT), _SPLITS, split_qos)
        self._undo.callback(node.destroy_publisher, self._splits)
        for topic in topics:
            if selection.chooses(topic.name, topic.type_name):
                try:
                    self._add(topic)
                except TeleopctlError as error:
                    self._log.warning(f"Ignoring a topic '{topic.name}', reason: {error.message}.")

    @property
    def topics(self) -> Collection[str]:
        """Names of the played topics, as in the bag."""
        return self._sends.keys()

    def send(self, message: BagMessage) -> bool:
        """Publish a message, or send the service request in it; return False if nothing is sent."""
        return self._sends[message.topic](message)

    def publish_split(self, split: FileSplit) -> None:
        """Publish rosbag2's ReadSplitEvent for the boundary between two files."""
        self._splits.publish(
            get_message(_SPLIT_EVENT)(
                closed_file=str(split.closed_file),
                opened_file=str(split.opened_file),
                node_name=self._node.get_fully_qualified_name(),
            )
        )

    def close(self) -> None:
        """Destroy the publishers and service clients."""
        self._undo.close()

    def _add(self, topic: BagTopic) -> None:
        if topic.serialization_format != CDR:
            raise UnsupportedError(f"its messages are {topic.serialization_format}, not {CDR}")
        register_types(topic)
        kind, _ = kind_of(topic.name, topic.type_name)
        sends_requests = (kind is TopicKind.SERVICE and self._options.publishes_requests) or (
            kind is TopicKind.ACTION and self._options.sends_actions
        )
        if not sends_requests:
            self._sends[topic.name] = self._publisher(topic)
        elif topic.name.endswith(EVENT_TOPIC_SUFFIX):
            sender = RequestSender(self._node, topic, self._options.request_source)
            self._undo.callback(sender.close)
            self._sends[topic.name] = sender.send
        # Feedback and status of an action are published by the action server.

    def _publisher(self, topic: BagTopic) -> _Send:
        message_class = raw_message_class(topic.type_name, topic_type_hash(topic))
        publisher = self._node.create_publisher(message_class, topic.name, self._offer(topic))
        self._undo.callback(self._node.destroy_publisher, publisher)

        def send(message: BagMessage) -> bool:
            publisher.publish(message.data)
            return True

        return send

    def _offer(self, topic: BagTopic) -> QoSProfile:
        if topic.name in self._overrides:
            self._log.info(f"Overriding QoS profile for topic {topic.name}")
            return self._overrides[topic.name]
        offer = publisher_qos(topic)
        if offer is None:
            self._log.warning(
                f"Not all original publishers on topic {topic.name} offered the same QoS "
                "profiles. Falling back to the default profile."
            )
        offer = offer or default_publisher_qos()
        return as_keep_all(offer) if self._options.is_lossless else offer

    def _absolute(self, name: str) -> str:
        return self._node.resolve_topic_name(name, only_expand=True)
