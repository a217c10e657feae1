"""Base of publishers, subscriptions, service servers and service clients."""

from __future__ import annotations

import abc
import functools

from teleopctl.base.typed import TYPE_CHECKING, Self
from teleopctl.interfaces import type_hash
from teleopctl.node.values.exceptions import InvalidHandle
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.qos import QoSProfile
from teleopctl.wire import EndpointToken, EntityKind, format_token, gid, topic_key

if TYPE_CHECKING:
    import zenoh

    from teleopctl.node.endpoints.events import EventHandler
    from teleopctl.node.node_core import NodeCore


LARGE_MESSAGE = 256 * 1024
"""Size of a message, in bytes, from which freed memory is kept for the next one."""


def keep_memory_for_large_messages() -> None:
    """Make the allocator keep freed memory; called when a large message is sent or received."""
    # Imported here, since few commands handle large messages.
    from teleopctl.base.kept_memory import keep_freed_memory

    keep_freed_memory()


class Endpoint(abc.ABC):
    """Base of publishers, subscriptions, services and clients: key, liveliness token and GID.

    Subclasses declare their data channel first and call `_announce` last, so that an endpoint in
    the graph is always functional; they close in the reverse order.

    Args:
        node: Node of the endpoint.
        kind: Kind of the endpoint.
        name: Fully qualified, remapped topic or service name.
        type_name: ROS name of the type, such as ``std_msgs/msg/String``.
        qos: QoS profile, which the liveliness token contains.
        version: Hash of the type; that of the known type if None.

    Attributes:
        events: Handlers of the endpoint's events.
    """

    def __init__(
        self,
        node: NodeCore,
        kind: EntityKind,
        name: str,
        type_name: str,
        qos: QoSProfile,
        version: str | None = None,
    ) -> None:
        context = node.context
        session = context.session
        self.node = node
        self.kind = kind
        self.name = name
        self.type_name = type_name
        self.type_hash = version or type_hash(type_name)
        self.qos_profile = qos
        self.key = topic_key(context.domain_id, name, type_name, self.type_hash)
        self._token_key = format_token(
            EndpointToken(
                domain=context.domain_id,
                zid=str(session.zid()),
                nid=node.entity_id,
                eid=context.next_id(),
                kind=kind,
                enclave=node.enclave,
                namespace=node.get_namespace(),
                node=node.get_name(),
                name=name,
                type_name=type_name,
                type_hash=self.type_hash,
                qos=qos.to_wire(),
            )
        )
        self.events: tuple[EventHandler, ...] = ()
        self._token: zenoh.LivelinessToken | None = None
        self._destroyed = False

    @functools.cached_property
    def gid(self) -> bytes:
        """GID of the endpoint, 16 bytes; its hash is imported where it is needed."""
        return gid(self._token_key)

    @property
    def handle(self) -> Handle:
        """Handle of the endpoint, as in rclpy."""
        return Handle(self, self.name)

    @property
    def is_destroyed(self) -> bool:
        """Whether the endpoint was destroyed (ours)."""
        return self._destroyed

    @property
    def logger_name(self) -> str:
        """Name of the logger of the endpoint's node."""
        return self.node.get_logger().name

    @property
    def event_handlers(self) -> list[EventHandler]:
        """Handlers of the endpoint's events."""
        return list(self.events)

    def _announce(self) -> None:
        """Declare the endpoint's liveliness token."""
        self._token = self.node.context.announce(self._token_key)

    def _check_alive(self) -> None:
        if self._destroyed:
            raise InvalidHandle(f"{type(self).__name__} of '{self.name}' was destroyed")

    def destroy(self) -> None:
        """Remove the endpoint from the graph and close its Zenoh channel. Idempotent."""
        if self._destroyed:
            return
        self._destroyed = True
        for event in self.events:
            event.destroy()
        token, self._token = self._token, None
        if self.node.context.session_is_open:
            if token is not None:
                self.node.context.withdraw(token, self._token_key)
            self._close()

    @abc.abstractmethod
    def _close(self) -> None:
        """Undeclare what the subclass declared."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()
