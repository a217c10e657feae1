"""Subscriptions and guard conditions that no executor serves: who waits for them takes himself."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.interfaces import MessageT
from teleopctl.node.endpoints.subscription import Subscription, SubscriptionHandle
from teleopctl.node.endpoints.waitable import Waitable
from teleopctl.node.values.callback_groups import ReentrantCallbackGroup
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore
    from teleopctl.node.values.qos import QoSProfile


class LooseGuardCondition(Waitable):
    """A condition that any thread can trigger, to be added to a wait set."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._triggered = False
        self.is_destroyed = False

    def trigger(self) -> None:
        """End the wait of whoever waits, now or the next time."""
        with self._lock:
            self._triggered = True
        self.tell_executor()

    def pending(self) -> int:
        """Return 1 while a trigger waits."""
        return int(self._triggered)

    def take(self) -> Callable[[], object] | None:
        """Forget a trigger; nothing is to be done for it."""
        with self._lock:
            self._triggered = False
        return None

    def tell_executor(self) -> None:
        """Tell only whoever waits by hand."""
        if (listener := self.listener) is not None:
            listener()

    def destroy(self) -> None:
        """End nobody's wait any more."""
        self.is_destroyed = True


class GuardHandle(Handle):
    """A guard condition of its own (rclpy: of the C library)."""

    entity: LooseGuardCondition

    def __init__(self, context_handle: Handle) -> None:
        del context_handle  # rclpy's: it belongs to no session
        super().__init__(LooseGuardCondition())

    def trigger_guard_condition(self) -> None:
        """End the wait of whoever waits, now or the next time."""
        self.entity.trigger()


class _LooseSubscription(Subscription[MessageT]):
    def tell_executor(self) -> None:
        if (listener := self.listener) is not None:
            listener()


def subscribe_loosely(
    node: NodeCore, msg_type: type[MessageT], topic: str, qos: QoSProfile
) -> SubscriptionHandle:
    """Return a subscription whose messages wait until they are taken from it.

    Raises:
        InvalidTopicNameException: The name breaks a rule.
    """
    name = node.resolve_topic_name(topic)
    group = ReentrantCallbackGroup()
    return _LooseSubscription(node, msg_type, name, _never_called, group, qos).handle


def _never_called(message: object) -> None:
    del message
