"""``launch.event_handlers.on_execution_complete``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..action import Action
from ..events.execution_complete import ExecutionComplete
from .on_action_event_base import OnActionEventBase

if TYPE_CHECKING:
    from .on_action_event_base import OnEvent


class OnExecutionComplete(OnActionEventBase):
    """Handles the end of an action: a process has exited, or a timer's actions are executed.

    Args:
        target_action: The action, a predicate of actions, or None for all.
        on_completion: What is done, or a function that is called with event and context and may
            say so.
        kwargs: Further arguments of `BaseEventHandler`.
    """

    # Any: arguments of `BaseEventHandler.`
    def __init__(
        self,
        *,
        target_action: Callable[[Action], bool] | Action | None = None,
        on_completion: OnEvent | None,
        **kwargs: Any,
    ) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_completion,
            target_event_cls=ExecutionComplete,
            target_action_cls=Action,
            **kwargs,
        )
