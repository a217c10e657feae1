"""Where the messages of a bag go: publishers of their bytes, and services that are asked."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import ExitStack
from typing import TYPE_CHECKING

from teleopctl.bag.player.bag_types import hash_of, learn_types
from teleopctl.bag.player.offers import default_offer, keeping_all, offer_for
from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.request_sender import RequestSender
from teleopctl.bag.player.selection import SERVICE_EVENT, TopicKind, kind_of
from teleopctl.bag.player.source import Split
from teleopctl.bag.records import CDR, BagMessage, BagTopic
from teleopctl.errors import TeleopctlError, UnsupportedError
from teleopctl.interfaces import get_message
from teleopctl.node import QoSProfile, raw_message_class

if TYPE_CHECKING:
    from teleopctl.node import Node

_SPLITS = "events/read_split"
_SPLIT_EVENT = "rosbag2_interfaces/msg/ReadSplitEvent"
# As rosbag2's.
_SPLIT_QOS = QoSProfile(depth=3)

_Send = Callable[[BagMessage], bool]


class Outputs:
    """Publishers and service clients of the played topics.

    Args:
        node: The node that has them.
        topics: The topics of the bag.
        options: Which are played, and how.
    """

    def __init__(self, node: Node, topics: Collection[BagTopic], options: PlayOptions) -> None:
        self._node = node
        self._options = options
        self._log = node.get_logger()
        selection = options.selection.expanded(self._absolute)
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
        """Publish a message, or send its request; return False if it is not played."""
        return self._sends[message.topic](message)

    def tell_of_split(self, split: Split) -> None:
        """Publish the event of a file boundary."""
        self._splits.publish(
            get_message(_SPLIT_EVENT)(
                closed_file=str(split.closed_file),
                opened_file=str(split.opened_file),
                node_name=self._node.get_fully_qualified_name(),
            )
        )

    def close(self) -> None:
        """Destroy the publishers and clients."""
        self._undo.close()

    def _add(self, topic: BagTopic) -> None:
        if topic.serialization_format != CDR:
            raise UnsupportedError(f"its messages are {topic.serialization_format}, not {CDR}")
        learn_types(topic)
        kind, _ = kind_of(topic.name, topic.type_name)
        asks = (kind is TopicKind.SERVICE and self._options.publishes_requests) or (
            kind is TopicKind.ACTION and self._options.sends_actions
        )
        if not asks:
            self._sends[topic.name] = self._publisher(topic)
        elif topic.name.endswith(SERVICE_EVENT):
            sender = RequestSender(self._node, topic, self._options.request_source)
            self._undo.callback(sender.close)
            self._sends[topic.name] = sender.send
        # Feedback and status of an action are its server's to publish.

    def _publisher(self, topic: BagTopic) -> _Send:
        message_class = raw_message_class(topic.type_name, hash_of(topic))
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
        offer = offer_for(topic)
        if offer is None:
            self._log.warning(
                f"Not all original publishers on topic {topic.name} offered the same QoS "
                "profiles. Falling back to the default profile."
            )
        offer = offer or default_offer()
        return keeping_all(offer) if self._options.is_lossless else offer

    def _absolute(self, name: str) -> str:
        return self._node.resolve_topic_name(name, only_expand=True)
