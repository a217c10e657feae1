"""Topic ``teleop/lease``: the nodes that teleoperate a robot, and their subscribers.

It is in the namespace of the robot, so that several robots of a graph have each its own. The topic
is latched (teleopctl_msgs/TeleopLease). A holder publishes its claim twice a second, and
its end. `teleopctl.node.values.command_lease` has the rule.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_message, set_stamp, to_nanoseconds
from teleopctl.node.values.command_lease import CommandLease, LeaseClaim
from teleopctl.node.values.qos import DurabilityPolicy, QoSProfile, qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.node.node import Node

LEASE_TOPIC = "teleop/lease"
LEASE_TYPE = "teleopctl_msgs/msg/TeleopLease"
# Time between two claims of a holder, s.
_PERIOD_S = 0.5
_MOST_WAITING = 100
_MOST_SENDERS = 1000

# Any, here and below: message classes are generated at run time from definitions.


class LeaseWatch:
    """Subscription to ``teleop/lease``: which node drives, and which nodes may command.

    Args:
        node: Node that subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lease = CommandLease()
        self._senders: dict[bytes, str] = {}
        node.create_subscription(
            get_message(LEASE_TYPE),
            LEASE_TOPIC,
            self._received,
            # The claim of one node must not replace that of another before it is taken.
            QoSProfile(depth=_MOST_WAITING, durability=DurabilityPolicy.TRANSIENT_LOCAL),
        )

    @property
    def holder(self) -> LeaseClaim | None:
        """The valid claim; None if no node holds the lease."""
        return self._lease.holder(time.monotonic())

    @property
    def term(self) -> int:
        """Highest term of all claims so far."""
        return self._lease.term

    def end(self) -> None:
        """End the lease, since the robot is stopped."""
        self._lease.end()

    def refusal(self, sender: bytes) -> str:
        """Return why an endpoint of another node may not command now; empty if it may.

        Args:
            sender: GID of the publisher or client; empty for one of this process.
        """
        holder = self.holder
        if holder is None or not sender:
            return ""
        refused = self._lease.refusal(self._name_of(bytes(sender)), time.monotonic())
        if refused and holder.holder not in self._node.get_fully_qualified_node_names():
            # A node that ends publishes nothing more.
            self._lease.end()
            return ""
        return refused

    def _name_of(self, sender: bytes) -> str:
        """Return the full name of an endpoint's node; empty for one that is not in the graph."""
        name = self._senders.get(sender)
        if name is None:
            found = (token for token in self._node.graph().endpoints if token.gid == sender)
            name = next((token.full_name for token in found), "")
            if name:
                if len(self._senders) >= _MOST_SENDERS:
                    self._senders.clear()
                self._senders[sender] = name
        return name

    def _received(self, message: Any) -> None:
        claim = LeaseClaim(
            str(message.holder),
            str(message.device),
            str(message.host),
            to_nanoseconds(message.since),
            int(message.term),
            tuple(message.through),
        )
        self._lease.receive(claim, time.monotonic(), is_held=bool(message.is_held))


class LeaseHolder:
    """Lease of a node that teleoperates a robot.

    Args:
        node: The node.
        through: Full names of the nodes that carry out its commands.
        on_loss: Called when another node has taken the lease over.
    """

    def __init__(
        self, node: Node, through: Sequence[str], on_loss: Callable[[], object] = lambda: None
    ) -> None:
        self._node, self._on_loss = node, on_loss
        self._name = node.get_fully_qualified_name()
        self._through = tuple(through)
        self._host = socket.gethostname()
        self._own: LeaseClaim | None = None
        self._published_s = 0.0
        self._type: Any = get_message(LEASE_TYPE)
        self.watch = LeaseWatch(node)
        self._publisher = node.create_publisher(self._type, LEASE_TOPIC, qos_profile_latched)

    @property
    def is_held(self) -> bool:
        """Whether this node holds the lease."""
        return self._own is not None and not self.is_lost()

    def is_lost(self) -> bool:
        """Return whether another node has taken the lease over; then call ``on_loss`` once."""
        own, present = self._own, self.watch.holder
        taken = own is not None and self.watch.term > own.term
        if own is None or not (taken or (present is not None and present.goes_before(own))):
            return False
        self._own = None
        self._on_loss()
        return True

    def take(self, device: str, *, by_force: bool = False) -> str:
        """Take or keep the lease; return why not, empty if this node holds it.

        Args:
            device: Name of the device that drives.
            by_force: Whether to take it over from another node.
        """
        if self.is_lost() and not by_force:
            return "another node has taken over"
        if self._own is None:
            present = self.watch.holder
            others = present is not None and present.holder != self._name
            if others and not by_force:
                return f"{present} drives the robot"
            self._own = LeaseClaim(
                self._name,
                device,
                self._host,
                time.time_ns(),
                self.watch.term + 1,
                self._through,
            )
            self._published_s = 0.0
        now_s = time.monotonic()
        if now_s - self._published_s >= _PERIOD_S:
            self._published_s = now_s
            self._publish(self._own, is_held=True)
        return ""

    def release(self) -> None:
        """End the lease of this node, if it holds it."""
        own, self._own = self._own, None
        if own is not None:
            self._publish(own, is_held=False)

    def end_any(self) -> LeaseClaim | None:
        """End the lease of whichever node holds it; return its claim, None if none does."""
        present = self.watch.holder
        if present is not None:
            ended = LeaseClaim(self._name, host=self._host, term=self.watch.term + 1)
            self._publish(ended, is_held=False)
        return present

    def _publish(self, claim: LeaseClaim, *, is_held: bool) -> None:
        message = self._type(
            holder=claim.holder,
            device=claim.device,
            host=claim.host,
            term=claim.term,
            is_held=is_held,
            through=list(claim.through),
        )
        set_stamp(message.stamp, time.time_ns())
        set_stamp(message.since, claim.since_ns)
        self._publisher.publish(message)
