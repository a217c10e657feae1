"""Publishers of topics."""

from __future__ import annotations

import itertools
import time

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, suppress
from teleopctl.interfaces import MessageT, serialize
from teleopctl.node.endpoints.endpoint import (
    LARGE_MESSAGE,
    Endpoint,
    keep_memory_for_large_messages,
)
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.exceptions import (
    ContextEndedError,
    ContextInvalidError,
    InvalidHandle,
)
from teleopctl.node.values.qos import (
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from teleopctl.wire import EntityKind, assertion_key, encode_attachment

if TYPE_CHECKING:
    from teleopctl.node.endpoints.events import EventHandler, PublisherEventCallbacks
    from teleopctl.node.node_core import NodeCore
    from teleopctl.node.values.time import Duration


class _DestroyedPublisher:
    """Replaces the Zenoh publisher after destruction, for threads that are about to publish."""

    @staticmethod
    def put(*_: object, **__: object) -> None:
        raise zenoh.ZError("it was destroyed")


class Publisher(Endpoint, Generic[MessageT]):
    """Publisher on a topic; made by ``Node.create_publisher``.

    Attributes:
        sends_while_ending: Whether messages are still sent after a signal, until the session is
            closed (ours).
    """

    def __init__(
        self, node: NodeCore, msg_type: type[MessageT], topic: str, qos: QoSProfile
    ) -> None:
        # A raw message class, without fields, has the hash of the type that is sent.
        version = getattr(msg_type, "TYPE_HASH", None)
        super().__init__(node, EntityKind.MP, topic, msg_type.TYPE_NAME, qos, version)
        self.msg_type = msg_type
        self._sequence = itertools.count(1)
        self._context_is_ok = node.context.ok
        self.sends_while_ending = node.context.publishes_after_signal
        self._watching: tuple[EventHandler, ...] = ()
        self._matching: Any = None
        self._has_subscribers = False
        self._channel: Any = self._declare(qos)
        self._announce()

    def add_event_callbacks(self, callbacks: PublisherEventCallbacks, group: CallbackGroup) -> None:
        """Create an event handler for each given callback, except ``incompatible_qos``."""
        from teleopctl.node.endpoints.event_handlers import (
            DeadlineHandler,
            LivelinessLostHandler,
            graph_event_handlers,
        )

        watching: list[EventHandler] = []
        if callbacks.deadline is not None:
            watching.append(DeadlineHandler(self, callbacks.deadline, group))
        if callbacks.liveliness is not None:
            watching.append(LivelinessLostHandler(self, callbacks.liveliness, group))
        self._watching = (*self._watching, *watching)
        self.events = (*self.events, *watching)
        for handler in graph_event_handlers(self, callbacks, group):
            self.events = (*self.events, handler)

    def _declare(self, qos: QoSProfile) -> Any:
        session = self.node.context.session
        reliable = qos.reliability != ReliabilityPolicy.BEST_EFFORT
        keep_all = qos.history == HistoryPolicy.KEEP_ALL
        options: dict[str, Any] = {
            "reliability": zenoh.Reliability.RELIABLE
            if reliable
            else zenoh.Reliability.BEST_EFFORT,
            # Only a reliable publisher with KEEP_ALL may block its caller.
            "congestion_control": zenoh.CongestionControl.BLOCK
            if reliable and keep_all
            else zenoh.CongestionControl.DROP,
        }
        if not qos.is_latched:
            return session.declare_publisher(self.key, **options)
        from zenoh import ext

        from teleopctl.node.endpoints.receive_queues import MOST_ITEMS

        if reliable:
            options["sample_miss_detection"] = ext.MissDetectionConfig(
                heartbeat=None, sporadic_heartbeat=0.5
            )
        return ext.declare_advanced_publisher(
            session,
            self.key,
            cache=ext.CacheConfig(qos.queue_depth or MOST_ITEMS),
            publisher_detection=True,
            **options,
        )

    @property
    def topic(self) -> str:
        """Fully qualified name of the topic."""
        return self.name

    @property
    def topic_name(self) -> str:
        """Fully qualified name of the topic."""
        return self.name

    def publish(self, msg: MessageT | bytes | bytearray) -> None:
        """Publish a message, or its CDR bytes; raise TypeError for a message of another type.

        Args:
            msg: Message of the publisher's type, or its CDR bytes.

        Raises:
            TypeError: The message is of another type.
            TeleopctlError: A field has a value that its type cannot hold; the error names the
                field.
            InvalidHandle: The publisher was destroyed.
            RCLError: The context was shut down, or ended by a signal, so that programs that only
                publish end too.
        """
        self._check_alive()
        if not self._context_is_ok() and not self.sends_while_ending:
            raise self._end_of_context()
        if isinstance(msg, self.msg_type):
            payload: bytes | bytearray = serialize(msg)
        elif isinstance(msg, bytes | bytearray):
            payload = msg
        else:
            raise TypeError(f"Expected {self.msg_type}, got {type(msg)}")
        if len(payload) >= LARGE_MESSAGE:
            keep_memory_for_large_messages()
        sequence = next(self._sequence)
        try:
            self._channel.put(
                payload,
                attachment=encode_attachment(sequence, time.time_ns(), self.gid),
            )
        except zenoh.ZError as error:
            if not self._context_is_ok():
                raise self._end_of_context() from error
            raise InvalidHandle(f"publisher of '{self.name}' cannot send: {error}") from error
        for handler in self._watching:
            handler.on_message(self.gid, sequence)

    def _end_of_context(self) -> ContextInvalidError:
        by_signal = self.node.context.ended_by_signal
        return ContextEndedError() if by_signal else ContextInvalidError()

    def get_subscription_count(self) -> int:
        """Return how many subscriptions match the publisher's topic name and type."""
        return len(self.node.matched(EntityKind.MS, self.name, self.type_name))

    @property
    def has_subscribers(self) -> bool:
        """Whether Zenoh would send a message to any subscriber (ours); for use by one thread.

        For publishers that are called so often that preparing unneeded messages costs time. Zenoh
        reports changes, so that it takes as long in a large graph.
        """
        if self._matching is None:
            # The last change alone counts. Without a callback Zenoh starts no thread.
            self._matching = self._channel.declare_matching_listener(zenoh.handlers.RingChannel(1))
            self._has_subscribers = self._channel.matching_status.matching
        if (status := self._matching.try_recv()) is not None:
            self._has_subscribers = status.matching
        return self._has_subscribers

    def wait_for_all_acked(self, timeout: Duration | None = None) -> bool:  # noqa: ARG002 (rclpy's)
        """Return True at once: Zenoh has no acknowledgements to wait for."""
        return True

    def assert_liveliness(self) -> None:
        """Assert the publisher's liveliness; does nothing unless its QoS is manual by topic.

        For other policies, the publisher is alive as long as its token is in the graph.

        Raises:
            InvalidHandle: The publisher was destroyed or the context was shut down.
        """
        self._check_alive()
        if self.qos_profile.liveliness != LivelinessPolicy.MANUAL_BY_TOPIC:
            return
        try:
            self.node.context.session.put(assertion_key(self.key), self.gid)
        except zenoh.ZError as error:
            raise InvalidHandle(f"publisher of '{self.name}' cannot send: {error}") from error
        for handler in self._watching:
            handler.on_assertion(self.gid)

    def _close(self) -> None:
        channel, self._channel = self._channel, _DestroyedPublisher
        # Zenoh refuses while another thread is within `put`; that thread then has the last
        # reference, and Zenoh undeclares the publisher when the thread drops it.
        with suppress(RuntimeError):
            channel.undeclare()
