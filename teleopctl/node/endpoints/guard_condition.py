"""Guard conditions: any thread has an executor run a callback."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.waitable import Waitable
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore


class GuardCondition(Waitable):
    """Made by ``Node.create_guard_condition``; triggers that come close together are one call."""

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
        """Have the callback called."""
        with self._lock:
            if self._destroyed:
                return
            self._triggered = True
        self.tell_executor()

    @property
    def handle(self) -> Handle:
        """Handle of the guard condition as rclpy has it."""
        return Handle(self)

    @property
    def is_destroyed(self) -> bool:
        """Whether it was destroyed (ours)."""
        return self._destroyed

    def destroy(self) -> None:
        """Call back no more."""
        self._destroyed = True
        self._triggered = False

    def pending(self) -> int:
        """Return 1 while a trigger waits."""
        return int(self._triggered)

    def take(self) -> Callable[[], object] | None:
        """Return the callback if it was triggered."""
        with self._lock:
            if not self._triggered:
                return None
            self._triggered = False
        return self.callback
