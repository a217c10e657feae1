"""Subscriptions."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from types import FunctionType, MethodType

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, NamedTuple, TypeAlias, TypedDict
from teleopctl.errors import InvalidMessageError, TeleopctlError
from teleopctl.interfaces import MessageT, deserialize
from teleopctl.node.endpoints.arrivals import KeepAll, KeepLast
from teleopctl.node.endpoints.endpoint import LARGE_MESSAGE, Endpoint, expect_large_messages
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.exceptions import RCLError
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.qos import QoSProfile, ReliabilityPolicy, bound_ns
from teleopctl.wire import EntityKind, Refusals, decode_attachment, direct_callback

if TYPE_CHECKING:
    from teleopctl.node.endpoints.events import EventHandler, SubscriptionEventCallbacks
    from teleopctl.node.node_core import NodeCore


class ContentFilterOptions(NamedTuple):
    """Content filter of a subscription; Zenoh does not filter, so filters have no effect.

    Attributes:
        filter_expression: Such as ``position > %0``.
        expression_parameters: What stands for ``%0`` and so on.
    """

    filter_expression: str
    expression_parameters: list[str]


class MessageInfo(TypedDict):
    """Metadata of a received message; times in nanoseconds since the epoch."""

    source_timestamp: int
    received_timestamp: int
    publication_sequence_number: int
    reception_sequence_number: None
    publisher_gid: bytes


# Whatever a callback returns is dropped, but for a coroutine, which becomes a task.
SubscriptionCallback: TypeAlias = (
    Callable[[MessageT], object] | Callable[[MessageT, MessageInfo], object]
)
# A sample and when it came, in nanoseconds since the epoch.
_Arrival: TypeAlias = tuple[zenoh.Sample, int]
RawCallback: TypeAlias = Callable[[bytes], object] | Callable[[bytes, MessageInfo], object]


class SubscriptionHandle(Handle):
    """Handle of a subscription whose messages the program takes itself."""

    entity: Subscription[Any]

    # Any: a message of the subscription's type.
    def take_message(
        self,
        msg_type: type[object],  # noqa: ARG002 -- rclpy's; the subscription knows
        raw: bool,
    ) -> tuple[Any, MessageInfo] | None:
        """Take the oldest queued message; see `Subscription.take_message`."""
        return self.entity.take_message(raw=raw)


class Subscription(Endpoint, QueuingEntity, Generic[MessageT]):
    """Subscription of one topic; made by ``Node.create_subscription``.

    Samples wait undecoded in a queue as deep as the QoS says (the oldest falls out) until the
    executor takes them. Where all are to be kept, a full queue holds a reliable publisher up; see
    `KeepAll`. A message that is older than the profile's lifespan is dropped without a word, as
    under Fast DDS; the lifespan of a publisher is announced and binds nobody, as under rmw_zenoh.

    Args:
        node: Owner.
        msg_type: Message class. With ``raw`` any class with a ``TYPE_NAME`` and a ``TYPE_HASH``,
            so that messages of unknown types can be received.
        topic: Fully qualified name.
        callback: ``callback(msg)`` or ``callback(msg, info)`` with a `MessageInfo`.
        callback_group: For multi-threaded executors.
        qos: Quality of service.
        raw: Hand over the CDR bytes instead of a message.
        immediate: Call back on the transport's receiving thread, without an executor. The
            callback must be short and must not wait for other messages. It may raise
            `InvalidMessageError` to refuse a message.

    Attributes:
        refusals: What was dropped: bytes that are no message, and what found no room.
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
        # A class that only stands for a type says which version of it is received.
        version = getattr(msg_type, "TYPE_HASH", None)
        super().__init__(node, EntityKind.MS, topic, msg_type.TYPE_NAME, qos, version)
        self.msg_type = msg_type
        self.callback = callback
        self.callback_group = callback_group
        self.raw = raw
        self._wants_info = _takes_two(callback)
        self._samples = self._make_queue(qos)
        self.refusals = Refusals(f"a message on '{topic}'", node.get_logger().error)
        self._watching: tuple[EventHandler, ...] = ()
        self._measure: Callable[[int | None], None] | None = None
        self._stop_measuring: Callable[[], object] | None = None
        self._lifespan_ns = bound_ns(qos.lifespan)
        self._channel = self._declare(qos, immediate=immediate)
        self._announce()

    def measure(self, saw: Callable[[int | None], None], stop: Callable[[], object]) -> None:
        """Set a function that receives the source time of each message that is taken (ours).

        Args:
            saw: Told in nanoseconds since the epoch; None where it is not known.
            stop: Called when the subscription is destroyed.
        """
        self._measure, self._stop_measuring = saw, stop

    def watch(self, callbacks: SubscriptionEventCallbacks, group: CallbackGroup) -> None:
        """Register event callbacks."""
        from teleopctl.node.endpoints.event_handlers import (
            DeadlineHandler,
            IncompatibleTypeHandler,
            LivelinessChangedHandler,
            MatchedHandler,
            MessageLostHandler,
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
        if callbacks.incompatible_type is not None:
            handler = IncompatibleTypeHandler(self, callbacks.incompatible_type, group)
            self.events = (*self.events, handler)
        if callbacks.matched is not None:
            self.events = (*self.events, MatchedHandler(self, callbacks.matched, group))

    def _make_queue(self, qos: QoSProfile) -> KeepAll[_Arrival] | KeepLast[_Arrival]:
        if qos.queue_depth is not None:
            return KeepLast(qos.queue_depth)
        samples: KeepAll[_Arrival] = KeepAll(
            is_patient=qos.reliability != ReliabilityPolicy.BEST_EFFORT
        )
        # A session does not close while a callback waits for room.
        self.node.context.on_shutdown(samples.close)
        return samples

    def _declare(self, qos: QoSProfile, *, immediate: bool) -> Any:
        session = self.node.context.session
        # What may keep the transport waiting keeps nobody else's samples waiting.
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
        """The fully qualified name of the topic."""
        return self.name

    @property
    def is_cft_enabled(self) -> bool:
        """Return False: content filters are not supported, as under rmw_zenoh."""
        return False

    def set_content_filter(
        self,
        filter_expression: str,  # noqa: ARG002 -- rclpy's
        expression_parameters: list[str],  # noqa: ARG002 -- likewise
    ) -> None:
        """Raise: content filters are not supported, as under rmw_zenoh.

        Raises:
            RCLError: Always.
        """
        raise RCLError("content filters are not supported by the middleware (Zenoh)")

    def get_content_filter(self) -> ContentFilterOptions:
        """Raise: content filters are not supported, as under rmw_zenoh.

        Raises:
            RCLError: Always.
        """
        raise RCLError("content filters are not supported by the middleware (Zenoh)")

    @property
    def handle(self) -> SubscriptionHandle:
        """Handle of the subscription as rclpy has it, from which messages can be taken."""
        return SubscriptionHandle(self, self.name)

    def get_publisher_count(self) -> int:
        """Return how many publishers the topic has, of the same type."""
        return len(self.node.matched(EntityKind.MP, self.name, self.type_name))

    def pending(self) -> int:
        """Return how many messages are queued."""
        return len(self._samples)

    def take(self) -> Callable[[], object] | None:
        """Return the call of the callback with the oldest queued message; None if there is none."""
        arrival = self._samples.take()
        # One may have come while the subscription was being destroyed.
        if arrival is None or self._destroyed:
            return None
        arguments = self._arguments(*arrival)
        if arguments is None:
            return None
        return functools.partial(self.callback, *arguments)

    def _queue(self, sample: zenoh.Sample) -> None:
        size = len(sample.payload) if self._samples.counts_bytes else 0
        if not self._samples.put((sample, time.time_ns()), size):
            self.refusals.refuse("the queue is full, and nothing is taken from it")
        self._tell_of(sample)
        self.tell_executor()

    def _handle_now(self, sample: zenoh.Sample) -> None:
        self._tell_of(sample)
        arguments = self._arguments(sample, time.time_ns())
        if arguments is None:
            return
        try:
            self.callback(*arguments)
        except InvalidMessageError as error:
            self.refusals.refuse(error.message)
        except Exception:  # noqa: BLE001 (the transport's thread must live on)
            import traceback

            self.refusals.refuse(f"the callback failed:\n{traceback.format_exc()}")

    def _tell_of(self, sample: zenoh.Sample) -> None:
        """Tell the handlers of events that a message came."""
        if not self._watching or sample.attachment is None:
            return
        meta = decode_attachment(sample.attachment.to_bytes())
        if meta is not None:
            for handler in self._watching:
                handler.saw(meta.gid, meta.sequence)

    def _has_expired(self, sample: zenoh.Sample) -> bool:
        """Whether a message is older than the lifespan, by its publisher's stamp."""
        if self._lifespan_ns is None or sample.attachment is None:
            return False
        meta = decode_attachment(sample.attachment.to_bytes())
        return meta is not None and time.time_ns() - meta.time_ns > self._lifespan_ns

    # Any: a message of the subscription's type, or bytes.
    def take_message(self, *, raw: bool = False) -> tuple[Any, MessageInfo] | None:
        """Take the oldest queued message, without an executor (ours).

        Args:
            raw: Return its bytes instead of a message.

        Returns:
            The message and what is known of it; None when none waits.
        """
        arrival = self._samples.take()
        if arrival is None or self._has_expired(arrival[0]):
            return None
        message = self._decode(arrival[0], raw=raw)
        info = None if message is None else self._info(*arrival)
        return None if info is None else (message, info)

    def _arguments(self, sample: zenoh.Sample, received_ns: int) -> tuple[Any, ...] | None:
        """Return what the callback gets; None when the sample has expired or cannot be read."""
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
        """Decode a sample; None, counted and reported, when it is not what its key says."""
        payload = sample.payload.to_bytes()
        if len(payload) >= LARGE_MESSAGE:
            expect_large_messages()
        try:
            return payload if raw else deserialize(payload, self.msg_type)
        except TeleopctlError as error:
            self.refusals.refuse(error.message)
            return None

    def _info(self, sample: zenoh.Sample, received_ns: int) -> MessageInfo | None:
        """Read the attachment of a sample; None, counted and reported, when it cannot be read."""
        meta = decode_attachment(sample.attachment.to_bytes()) if sample.attachment else None
        if meta is None:
            self.refusals.refuse("it came without a readable attachment")
            return None
        return {
            "source_timestamp": meta.time_ns,
            "received_timestamp": received_ns,
            "publication_sequence_number": meta.sequence,
            "reception_sequence_number": None,
            "publisher_gid": meta.gid,
        }

    def _close(self) -> None:
        if self._stop_measuring is not None:
            self._stop_measuring()
        # First: undeclaring waits for a callback that waits for room.
        self._samples.close()
        self._channel.undeclare()
        self._samples.close()
        self.node.context.forget_on_shutdown(self._samples.close)


def _accepted(callback: Callable[..., object]) -> range:
    """Return how many arguments a plain function or method takes; no number for the others."""
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
    """Tell whether a callback wants the message's information besides the message."""
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
