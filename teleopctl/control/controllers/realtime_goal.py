"""Action goal handles for the control cycle, which never block."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.node import InvalidGoalTransitionError

if TYPE_CHECKING:
    from teleopctl.interfaces import ActionType
    from teleopctl.node import ServerGoalHandle


# Any: goals, results and feedback of any action.
class RealtimeServerGoalHandle:
    """Action goal handle for use in ``update``, as in realtime_tools; never blocks there.

    Methods whose names begin with ``try_`` return at once and take effect through the publish
    queue. If the goal is ended several times, the first end takes effect.

    Args:
        handle: Handle of the goal.
        action_type: Action class.
        queue: Publish queue of the control loop, ``params.publish_queue`` of a controller.

    Attributes:
        handle: Handle of the goal.
    """

    def __init__(
        self,
        handle: ServerGoalHandle[Any, Any, Any],
        action_type: type[ActionType[Any, Any, Any]],
        queue: PublishQueue,
    ) -> None:
        self.handle = handle
        self._action: Any = action_type
        self._end_publisher = RealtimePublisher(queue, self._end)

    @property
    def cancel_requested(self) -> bool:
        """Whether a client has requested to cancel the goal."""
        return self.handle.is_cancel_requested

    def start(self) -> None:
        """Set the goal to executing unless canceling; must not be called in ``update``."""
        # A cancel request may arrive first.
        with contextlib.suppress(InvalidGoalTransitionError):
            if not self.handle.is_cancel_requested:
                self.handle.executing()

    def try_succeed(self, **result: object) -> None:
        """End the goal as succeeded after the control cycle, with a result of given fields."""
        self._end_publisher.try_publish(("succeed", result))

    def try_abort(self, **result: object) -> None:
        """End the goal as aborted after the control cycle, with a result of given fields."""
        self._end_publisher.try_publish(("abort", result))

    def try_cancel(self, **result: object) -> None:
        """End the goal as canceled after the control cycle, with a result of given fields."""
        self._end_publisher.try_publish(("canceled", result))

    def abort(self, **result: object) -> None:
        """End the goal as aborted at once, with result fields; must not be called in ``update``."""
        self._end(("abort", result))

    def _end(self, ending: tuple[str, dict[str, object]]) -> None:
        event, fields = ending
        # A new goal or ``update`` may have ended the goal already.
        with contextlib.suppress(InvalidGoalTransitionError):
            getattr(self.handle, event)(self._action.Result(**fields))
