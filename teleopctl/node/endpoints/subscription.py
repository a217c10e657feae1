"""Subscriptions to topics."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from types import FunctionType, MethodType

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, NamedTuple, TypeAlias, TypedDict
from teleopctl.errors import InvalidMessageError, TeleopctlError
from teleopctl.interfaces import MessageT, deserialize
from teleopctl.node.endpoints.endpoint import (
    LARGE_MESSAGE,
    Endpoint,
    keep_memory_for_large_messages,
)
from teleopctl.node.endpoints.receive_queues import KeepAllQueue, KeepLastQueue
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.exceptions import ContextEndedError, RCLError
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.qos import QoSProfile, ReliabilityPolicy, bound_ns
from teleopctl.wire import EntityKind, InvalidMessageCounter, decode_attachment, direct_callback

if TYPE_CHECKING:
    from teleopctl.node.endpoints.events import EventHandler, SubscriptionEventCallbacks
    from teleopctl.node.node_core import NodeCore


class ContentFilterOptions(NamedTuple):
    """Content filter of a subscription, for rclpy programs; has no effect on Zenoh.

    Attributes:
        filter_expression: Filter expression, such as ``position > %0``.
        expression_parameters: Values of ``%0``, ``%1`` and so on.
    """

    filter_expression: str
    expression_parameters: list[str]


class MessageInfo(TypedDict):
    """Metadata of a received message; times in nanoseconds since the epoch."""

    source_timestamp: int
    received_timestamp: int
    publication_sequence_number: int
    reception_sequence_number: int
    publisher_gid: bytes


# The return value of a callback is ignored, except for a coroutine, which becomes a task.
SubscriptionCallback: TypeAlias = (
    Callable[[MessageT], object] | Callable[[MessageT, MessageInfo], object]
)
# A sample and its time of receipt, in nanoseconds since the epoch.
_Arrival: TypeAlias = tuple[zenoh.Sample, int]
RawCallback: TypeAlias = Callable[[bytes], object] | Callable[[bytes, MessageInfo], object]


class SubscriptionHandle(Handle):
    """Handle of a subscription, with which a program takes messages itself."""

    entity: Subscription[Any]

    # Any: a message of the subscription's type.
    def take_message(
        self,
        msg_type: type[object],  # noqa: ARG002 -- rclpy's; the subscription has the type
        raw: bool,
    ) -> tuple[Any, MessageInfo] | None:
        """Remove and return the oldest message and its metadata; None without a valid message."""
        return self.entity.take_message(raw=raw)


class Subscription(Endpoint, QueuingEntity, Generic[MessageT]):
    """Subscription to a topic; made by ``Node.create_subscription``.

    Samples wait undecoded in a queue of the QoS profile's depth until the executor takes them; the
    oldest is dropped when the queue is full. With KEEP_ALL a full queue blocks a reliable publisher
    instead; see `KeepAllQueue`. A message older than the subscription's lifespan is dropped without
    a report, as under Fast DDS; a publisher's lifespan is announced only, as under rmw_zenoh.

    Args:
        node: Node of the subscription.
        msg_type: Message class. With ``raw`` any class with a ``TYPE_NAME`` and a ``TYPE_HASH``,
            so that messages of unknown types can be received.
        topic: Fully qualified name of the topic.
        callback: ``callback(msg)`` or ``callback(msg, info)`` with a `MessageInfo`.
        callback_group: Callback group of the callback.
        qos: QoS profile.
        raw: Whether the callback receives CDR bytes instead of a message.
        immediate: Whether to call the callback on Zenoh's receiving thread, without an executor.
            The callback must be short and must not wait for other messages. It may raise
            `InvalidMessageError` to reject a message.

    Attributes:
        refusals: Counts and logs dropped messages: malformed ones, and those of a full queue.
    """

    def __init__(
        self,
        node: NodeCore,
        msg_type: type[MessageT],
        topic: str,
        callback: SubscriptionCallback[MessageT] | RawCallback,
        callback_group: CallbackGroup,
        qos: QoSProfile,
        *,
        raw: bool = False,
        immediate: bool = False,
    ) -> None:
        # A raw message class, without fields, has the hash of the type that is received.
        version = getattr(msg_type, "TYPE_HASH", None)
        super().__init__(node, EntityKind.MS, topic, msg_type.TYPE_NAME, qos, version)
        self.msg_type = msg_type
        self.callback = callback
        self.callback_group = callback_group
        self.raw = raw
        self._samples = self._make_queue(qos)
        self.refusals = InvalidMessageCounter(f"a message on '{topic}'", node.get_logger().error)
        self._watching: tuple[EventHandler, ...] = ()
        self._measure: Callable[[int | None], None] | None = None
        self._on_destroy: Callable[[], object] | None = None
        self._on_size: Callable[[int], None] | None = None
        self._is_taken: Callable[[int], bool] | None = None
        self._lifespan_ns = bound_ns(qos.lifespan)
        self._channel = self._declare(qos, immediate=immediate)
        self._announce()

    @property
    def callback(self) -> SubscriptionCallback[MessageT] | RawCallback:
        """Function called with each message; a new one is used from the next message on."""
        return self._callback

    @callback.setter
    def callback(self, callback: SubscriptionCallback[MessageT] | RawCallback) -> None:
        self._wants_info = _takes_two(callback)
        self._callback = callback

    def set_measurement(
        self, on_message: Callable[[int | None], None], on_destroy: Callable[[], object]
    ) -> None:
        """Set functions to call with each taken message's source time, and on destruction (ours).

        Args:
            on_message: Called with the source time in nanoseconds since the epoch; None if unknown.
            on_destroy: Called when the subscription is destroyed.
        """
        self._measure, self._on_destroy = on_message, on_destroy

    def count_bytes(self, on_message: Callable[[int], None]) -> None:
        """Call a function with each message's size in bytes, in place of the callback (ours).

        The messages are not copied: a copy of 300 MB takes a tenth of a second. For a subscription
        that is ``immediate``.
        """
        self._on_size = on_message

    def choose_by_size(self, is_taken: Callable[[int], bool]) -> None:
        """Drop messages by their size in bytes, before they are copied and decoded (ours).

        Args:
            is_taken: Called with a message's size; returns whether the message is taken.
        """
        self._is_taken = is_taken

    def add_event_callbacks(
        self, callbacks: SubscriptionEventCallbacks, group: CallbackGroup
    ) -> None:
        """Create an event handler for each given callback, except ``incompatible_qos``."""
        from teleopctl.node.endpoints.event_handlers import (
            DeadlineHandler,
            LivelinessChangedHandler,
            MessageLostHandler,
            graph_event_handlers,
        )

        watching: list[EventHandler] = []
        if callbacks.deadline is not None:
            watching.append(DeadlineHandler(self, callbacks.deadline, group))
        if callbacks.liveliness is not None:
            watching.append(LivelinessChangedHandler(self, callbacks.liveliness, group))
        if callbacks.message_lost is not None:
            watching.append(MessageLostHandler(self.node, callbacks.message_lost, group))
        self._watching = (*self._watching, *watching)
        self.events = (*self.events, *watching)
        for handler in graph_event_handlers(self, callbacks, group):
            self.events = (*self.events, handler)

    def _make_queue(self, qos: QoSProfile) -> KeepAllQueue[_Arrival] | KeepLastQueue[_Arrival]:
        if qos.queue_depth is not None:
            return KeepLastQueue(qos.queue_depth)
        samples: KeepAllQueue[_Arrival] = KeepAllQueue(
            blocks=qos.reliability != ReliabilityPolicy.BEST_EFFORT
        )
        # A session does not close while a callback waits for room.
        self.node.context.on_shutdown(samples.close)
        return samples

    def _declare(self, qos: QoSProfile, *, immediate: bool) -> Any:
        session = self.node.context.session
        # A subscription that may block the transport does not share its Zenoh subscriber.
        if not (immediate or qos.is_latched or qos.queue_depth is None):
            return self.node.context.shared_subscribers.declare_subscriber(self.key, self._queue)
        receive = self._handle_now if immediate else self._queue
        handler = direct_callback(receive)
        if not qos.is_latched:
            return session.declare_subscriber(self.key, handler)
        from zenoh import ext

        recovery = (
            None
            if qos.reliability == ReliabilityPolicy.BEST_EFFORT
            else ext.RecoveryConfig(periodic_queries=None, heartbeat=True)
        )
        return ext.declare_advanced_subscriber(
            session,
            self.key,
            handler,
            history=ext.HistoryConfig(detect_late_publishers=True, max_samples=qos.queue_depth),
            recovery=recovery,
            subscriber_detection=True,
        )

    @property
    def topic_name(self) -> str:
        """Fully qualified name of the topic."""
        return self.name

    @property
    def is_cft_enabled(self) -> bool:
        """Whether a content filter is active; always False, as under rmw_zenoh."""
        return False

    def set_content_filter(
        self,
        filter_expression: str,  # noqa: ARG002 -- rclpy's
        expression_parameters: list[str],  # noqa: ARG002 -- likewise
    ) -> None:
        """Raise RCLError: content filters are not supported, as under rmw_zenoh.

        Raises:
            RCLError: Always.
        """
        raise RCLError("content filters are not supported by the middleware (Zenoh)")

    def get_content_filter(self) -> ContentFilterOptions:
        """Raise RCLError: content filters are not supported, as under rmw_zenoh.

        Raises:
            RCLError: Always.
        """
        raise RCLError("content filters are not supported by the middleware (Zenoh)")

    @property
    def handle(self) -> SubscriptionHandle:
        """Handle of the subscription, as in rclpy."""
        return SubscriptionHandle(self, self.name)

    def get_publisher_count(self) -> int:
        """Return how many publishers match the subscription's topic name and type."""
        return len(self.node.matched(EntityKind.MP, self.name, self.type_name))

    def pending(self) -> int:
        """Return how many messages wait for the executor."""
        return len(self._samples)

    def take(self) -> Callable[[], object] | None:
        """Remove the oldest message; return the callback bound to that, None if it is invalid."""
        arrival = self._samples.take()
        # A message may have arrived during the destruction of the subscription.
        if arrival is None or self._destroyed:
            return None
        arguments = self._arguments(*arrival)
        if arguments is None:
            return None
        return functools.partial(self._callback, *arguments)

    def _queue(self, sample: zenoh.Sample) -> None:
        size = len(sample.payload) if self._samples.counts_bytes else 0
        if not self._samples.put((sample, time.time_ns()), size):
            self.refusals.refuse("the queue is full, and nothing is taken from it")
        self._notify_event_handlers(sample)
        self.notify_executor()

    def _handle_now(self, sample: zenoh.Sample) -> None:
        self._notify_event_handlers(sample)
        if self._on_size is not None:
            self._on_size(len(sample.payload))
            return
        arguments = self._arguments(sample, time.time_ns())
        if arguments is None:
            return
        try:
            self._callback(*arguments)
        except InvalidMessageError as error:
            self.refusals.refuse(error.message)
        except ContextEndedError:
            pass  # a signal has ended the context during the callback, which publishes
        except Exception:  # noqa: BLE001 (must not end Zenoh's thread)
            import traceback

            self.refusals.refuse(f"the callback failed:\n{traceback.format_exc()}")

    def _notify_event_handlers(self, sample: zenoh.Sample) -> None:
        """Pass a message's publisher and sequence number to the event handlers."""
        if not self._watching or sample.attachment is None:
            return
        meta = decode_attachment(sample.attachment.to_bytes())
        if meta is not None:
            for handler in self._watching:
                handler.on_message(meta.gid, meta.sequence)

    def _has_expired(self, sample: zenoh.Sample) -> bool:
        """Return whether a message is older than the lifespan, by its source time."""
        if self._lifespan_ns is None or sample.attachment is None:
            return False
        meta = decode_attachment(sample.attachment.to_bytes())
        return meta is not None and time.time_ns() - meta.time_ns > self._lifespan_ns

    # Any: a message of the subscription's type, or bytes.
    def take_message(self, *, raw: bool = False) -> tuple[Any, MessageInfo] | None:
        """Remove and return the oldest message and its metadata; None without a valid one (ours).

        Args:
            raw: Whether to return CDR bytes instead of a message.

        Returns:
            The message and its metadata; None if no message is queued, or the oldest one is
            malformed or older than the lifespan.
        """
        arrival = self._samples.take()
        if arrival is None or self._has_expired(arrival[0]):
            return None
        message = self._decode(arrival[0], raw=raw)
        info = None if message is None else self._info(*arrival)
        return None if info is None else (message, info)

    def _arguments(self, sample: zenoh.Sample, received_ns: int) -> tuple[Any, ...] | None:
        """Return the callback's arguments; None if the sample has expired or is malformed."""
        if self._has_expired(sample):
            return None
        message = self._decode(sample, raw=self.raw)
        if self._measure is not None and message is not None:
            meta = decode_attachment(sample.attachment.to_bytes()) if sample.attachment else None
            self._measure(None if meta is None else meta.time_ns)
        if message is None or not self._wants_info:
            return None if message is None else (message,)
        info = self._info(sample, received_ns)
        return None if info is None else (message, info)

    def _decode(self, sample: zenoh.Sample, *, raw: bool) -> MessageT | bytes | None:
        """Decode a sample; count, log and return None if it is malformed."""
        if self._is_taken is not None and not self._is_taken(len(sample.payload)):
            return None
        payload = sample.payload.to_bytes()
        if len(payload) >= LARGE_MESSAGE:
            keep_memory_for_large_messages()
        try:
            return payload if raw else deserialize(payload, self.msg_type)
        except TeleopctlError as error:
            self.refusals.refuse(error.message)
            return None

    def _info(self, sample: zenoh.Sample, received_ns: int) -> MessageInfo | None:
        """Return the metadata of a sample; count, log and return None if it is malformed."""
        meta = decode_attachment(sample.attachment.to_bytes()) if sample.attachment else None
        if meta is None:
            self.refusals.refuse("it came without a readable attachment")
            return None
        return {
            "source_timestamp": meta.time_ns,
            "received_timestamp": received_ns,
            "publication_sequence_number": meta.sequence,
            "reception_sequence_number": 0,  # as under rmw_zenoh, which does not count them
            "publisher_gid": meta.gid,
        }

    def _close(self) -> None:
        if self._on_destroy is not None:
            self._on_destroy()
        # Closed first: undeclaring waits for a callback that waits for room in the queue.
        self._samples.close()
        self._channel.undeclare()
        self._samples.close()
        self.node.context.forget_on_shutdown(self._samples.close)


def _accepted(callback: Callable[..., object]) -> range:
    """Return the possible numbers of arguments of a plain function or method; else none."""
    bound = 0
    if isinstance(callback, MethodType):
        callback, bound = callback.__func__, 1
    if not isinstance(callback, FunctionType) or hasattr(callback, "__wrapped__"):
        return range(0)
    code = callback.__code__
    if code.co_kwonlyargcount:
        return range(0)
    optional = len(callback.__defaults__ or ())
    return range(code.co_argcount - optional - bound, code.co_argcount - bound + 1)


def _takes_two(callback: Callable[..., object]) -> bool:
    """Return whether a callback takes the message's `MessageInfo` as a second argument."""
    accepted = _accepted(callback)  # without inspect, which takes long to import
    if 1 in accepted or 2 in accepted:
        return 1 not in accepted
    import inspect

    try:
        inspect.signature(callback).bind(object())
    except TypeError:
        try:
            inspect.signature(callback).bind(object(), object())
        except TypeError:
            raise RuntimeError(
                "Subscription.__init__(): callback should be either be callable with one argument"
                " (to get only the message) or two (to get message and message info)"
            ) from None
        return True
    except ValueError:
        return False
    return False
