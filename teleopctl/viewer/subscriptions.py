"""The page's subscriptions: their QoS, shared ones, and topics of a type that is not installed."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_message, known_types
from teleopctl.node import DurabilityPolicy, QoSProfile, ReliabilityPolicy, add_type_from_graph

if TYPE_CHECKING:
    from teleopctl.node import Node

_DEPTH = 5
_MOST = 100
# While a message is copied out of Zenoh's memory nothing else runs: 300 MB take a third of a second
# and more. So of messages above this size one is taken in this time.
_LARGEST_AT_ANY_RATE = 64_000_000
_PERIOD_OF_LARGER_S = 30.0


# Any: YAML values, messages, and subscriptions to them.
def topic_qos(
    node: Node, topic: str, mapping: Mapping[str, Any], *, latched: bool = False
) -> QoSProfile:
    """Return the QoS to subscribe to a topic: that of ``mapping``, adapted to the publishers.

    RViz subscribes with its file's QoS, and receives nothing from publishers that offer less.

    Args:
        node: Node whose graph is read.
        topic: Name of the topic.
        mapping: The display's mapping in an ``.rviz`` file, which may contain a QoS.
        latched: Whether the QoS is always transient local, regardless of the file.
    """
    said = mapping.get("Topic")
    said = said if isinstance(said, Mapping) else {}
    offered = [one.qos_profile for one in node.get_publishers_info_by_topic(topic)]
    reliable = said.get("Reliability Policy", "Reliable") != "Best Effort" and all(
        profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered
    )
    keeps = any(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    depth = said.get("Depth", _DEPTH)
    depth = depth if isinstance(depth, int) and 0 < depth <= _MOST else _DEPTH
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if latched or keeps
        else DurabilityPolicy.VOLATILE,
    )


@dataclass(slots=True, eq=False)
class _Topic:
    """A subscription, and the functions that are called with its messages."""

    subscription: Any
    depth: int
    next_large_s: float = 0.0
    callbacks: tuple[Callable[[Any], object], ...] = ()


# Any: messages of any type.
class SharedSubscriptions:
    """Subscriptions of a node that any number of displays and panels share.

    A message is decoded once, however many show it: decoding a picture of 100 megapixels takes a
    tenth of a second, in which the page does not answer.

    Args:
        node: The viewer's node.
        guarded: Function that calls a function with a message, and logs what it raises.
        say: Function that shows a title and a text in all browsers.
    """

    def __init__(
        self, node: Node, guarded: Callable[..., object], say: Callable[[str, str], object]
    ) -> None:
        self._node, self._guarded, self._say = node, guarded, say
        self._said: set[str] = set()
        self._topics: dict[tuple[object, ...], _Topic] = {}

    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: QoSProfile
    ) -> Callable[[], None]:
        """Subscribe to a topic of a known type; return a function that unsubscribes.

        Args:
            topic: Name of the topic.
            type_name: Full name of its message type.
            callback: Function called with each message, which it does not change.
            qos: QoS of the subscription.

        Returns:
            A function that ends the calls; after the last one the subscription is destroyed.
        """
        key: tuple[object, ...] = (topic, type_name, qos.reliability, qos.durability)
        if qos.durability == DurabilityPolicy.TRANSIENT_LOCAL:
            # A publisher sends what it has kept once, to each new subscription.
            key = (object(),)
        shared = self._topics.get(key)
        if shared is None:
            shared = self._topics[key] = _Topic(None, -1)
        if qos.depth > shared.depth:
            former, shared.depth = shared.subscription, qos.depth
            shared.subscription = self._node.create_subscription(
                get_message(type_name), topic, lambda message: self._pass_on(shared, message), qos
            )
            shared.subscription.choose_by_size(lambda size: self._is_taken(topic, shared, size))
            if former is not None:
                self._node.destroy_subscription(former)

        def call(message: Any) -> None:
            self._guarded(callback, message)

        shared.callbacks = (*shared.callbacks, call)

        def end() -> None:
            shared.callbacks = tuple(one for one in shared.callbacks if one is not call)
            if not shared.callbacks and self._topics.get(key) is shared:
                del self._topics[key]
                self._node.destroy_subscription(shared.subscription)

        return end

    def _is_taken(self, topic: str, shared: _Topic, size: int) -> bool:
        """Return whether a message is shown; say once for each topic that large ones are not."""
        if size <= _LARGEST_AT_ANY_RATE:
            return True
        now_s = time.monotonic()
        if now_s >= shared.next_large_s:
            shared.next_large_s = now_s + _PERIOD_OF_LARGER_S
            return True
        if topic not in self._said:
            self._said.add(topic)
            text = (
                f"Its messages have {size / 1e6:.0f} MB: one is shown in {_PERIOD_OF_LARGER_S:.0f} "
                "s, since the page stands still meanwhile. Smaller ones, such as compressed "
                "pictures, are shown at any rate."
            )
            self._node.get_logger().warning(f"{topic}: {text}")
            self._say(f"{topic} is left out in part", text)
        return False

    @staticmethod
    def _pass_on(shared: _Topic, message: Any) -> None:
        for call in shared.callbacks:
            if call in shared.callbacks:  # an earlier callback may have ended it
                call(message)


@dataclass(slots=True, eq=False)
class _Pending:
    """A function to call once a type is known, and the function that ends what it began."""

    type_name: str
    begin: Callable[[], Callable[[], None]]
    end: Callable[[], None] | None = None


class UnknownTypes:
    """Requests for definitions of unknown message types, sent to nodes that use the types.

    Args:
        node: The viewer's node.
        run_in_background: See `Stage.run_in_background`.
    """

    # Any: result of a task.
    def __init__(
        self,
        node: Node,
        run_in_background: Callable[[Callable[[], Any], Callable[[Any], object]], object],
    ) -> None:
        self._node = node
        self._run_in_background = run_in_background
        self._pending: list[_Pending] = []
        # The nodes that used a type when it was last requested.
        self._requested: dict[str, frozenset[str]] = {}

    def call_when_known(
        self, type_name: str, begin: Callable[[], Callable[[], None]]
    ) -> Callable[[], None]:
        """Call ``begin`` once a type's definition is received; return a function that cancels.

        Args:
            type_name: Full name of the type.
            begin: Function that subscribes, and returns a function that unsubscribes.

        Returns:
            A function that ends the wait, or unsubscribes.
        """
        pending = _Pending(type_name, begin)
        self._pending.append(pending)
        self.request_missing()

        def end() -> None:
            if pending in self._pending:
                self._pending.remove(pending)
            if pending.end is not None:
                pending.end()
                pending.end = None

        return end

    def request_missing(self) -> None:
        """Request missing definitions from nodes that have appeared; called on graph changes."""
        if not self._pending:
            return
        graph = self._node.graph()
        for type_name in {pending.type_name for pending in self._pending}:
            users = frozenset(
                e.full_name
                for e in graph.endpoints
                if e.type_name == type_name and graph.servers(f"{e.full_name}/get_type_description")
            )
            if users and users != self._requested.get(type_name):
                self._requested[type_name] = users
                self._request(type_name)

    def _request(self, type_name: str) -> None:
        graph = self._node.graph()
        self._run_in_background(
            lambda: add_type_from_graph(self._node, type_name, graph),
            lambda result: self._received(type_name, result),
        )

    # Any: None, or the exception.
    def _received(self, type_name: str, result: Any) -> None:
        if isinstance(result, BaseException):
            self._node.get_logger().warning(
                f"The definition of {type_name} was not received: {result}"
            )
        if known_types().find(type_name) is None:
            return
        for pending in [one for one in self._pending if one.type_name == type_name]:
            self._pending.remove(pending)
            pending.end = pending.begin()
