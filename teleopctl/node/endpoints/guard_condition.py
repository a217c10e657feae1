"""Guard conditions, by which any thread schedules a callback on the executor."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore


class GuardCondition(QueuingEntity):
    """Guard condition, whose callback the executor calls once after one or more triggers."""

    def __init__(
        self, node: NodeCore, callback: Callable[[], object], callback_group: CallbackGroup
    ) -> None:
        self.node = node
        self.callback = callback
        self.callback_group = callback_group
        self._lock = threading.Lock()
        self._triggered = False
        self._destroyed = False

    def trigger(self) -> None:
        """Schedule one call of the callback on the executor; thread-safe."""
        with self._lock:
            if self._destroyed:
                return
            self._triggered = True
        self.notify_executor()

    @property
    def handle(self) -> Handle:
        """Handle of the guard condition, as in rclpy."""
        return Handle(self)

    @property
    def is_destroyed(self) -> bool:
        """Whether the guard condition was destroyed (ours)."""
        return self._destroyed

    def destroy(self) -> None:
        """Destroy the guard condition, dropping a pending trigger."""
        self._destroyed = True
        self._triggered = False

    def pending(self) -> int:
        """Return 1 while a trigger is pending, else 0."""
        return int(self._triggered)

    def take(self) -> Callable[[], object] | None:
        """Reset a pending trigger and return the callback; None without a trigger."""
        with self._lock:
            if not self._triggered:
                return None
            self._triggered = False
        return self.callback
