"""Subscription that keeps the newest message of a topic, for programs that poll it."""

from __future__ import annotations

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import MessageT
from teleopctl.node.endpoints.subscription import Subscription
from teleopctl.node.values.qos import QoSProfile

if TYPE_CHECKING:
    from teleopctl.node.node_endpoints import NodeEndpoints


class _Paused:
    """Replaces the Zenoh subscriber of a subscription that receives nothing."""

    @staticmethod
    def undeclare() -> None:
        pass


class NewestMessage(Subscription[MessageT]):
    """Subscription without a callback: Zenoh keeps the newest message until it is read.

    No Python code runs when a message arrives, so a topic of a thousand messages per second costs
    little in a process that reads ten of them. Earlier messages of latched publishers are not
    requested.

    Args:
        node: Node of the subscription, which destroys it.
        msg_type: Message class.
        topic: Relative, absolute or private name of the topic.
        is_paused: Whether nothing is received before the first call of `read`, as after `pause`.
    """

    def __init__(
        self, node: NodeEndpoints, msg_type: type[MessageT], topic: str, *, is_paused: bool = False
    ) -> None:
        self._starts_paused = is_paused
        name = node.resolve_topic_name(topic)
        group = node.default_callback_group
        super().__init__(node, msg_type, name, lambda _: None, group, QoSProfile(depth=1))
        node.add_endpoint(self)

    def _declare(self, qos: QoSProfile, *, immediate: bool) -> Any:
        del qos, immediate
        return _Paused() if self._starts_paused else self._subscribe()

    # Any: a Zenoh subscriber, whose type names its handler.
    def _subscribe(self) -> Any:
        return self.node.context.session.declare_subscriber(self.key, zenoh.handlers.RingChannel(1))

    def pause(self) -> None:
        """Unsubscribe until the next call of `read`."""
        channel, self._channel = self._channel, _Paused()
        channel.undeclare()

    def read(self) -> MessageT | None:
        """Return the newest message; None if none has arrived since the last call or a pause.

        Also None once the node is destroyed.
        """
        sample = self._newest()
        message = None if sample is None else self._decode(sample, raw=False)
        assert not isinstance(message, bytes)
        return message

    def read_raw(self) -> bytes | None:
        """Return the CDR bytes of the newest message; None as from `read`."""
        sample = self._newest()
        data = None if sample is None else self._decode(sample, raw=True)
        assert data is None or isinstance(data, bytes)
        return data

    def _newest(self) -> zenoh.Sample | None:
        if self.is_destroyed:
            return None
        if isinstance(self._channel, _Paused):
            self._channel = self._subscribe()
        sample: zenoh.Sample | None = self._channel.try_recv()
        return sample
