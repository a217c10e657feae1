"""``launch.event_handlers.on_process_exit``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..action import Action
from ..events.process import ProcessExited
from .on_action_event_base import OnActionEventBase

if TYPE_CHECKING:
    from .on_action_event_base import OnEvent


class OnProcessExit(OnActionEventBase):
    """Handles the exit of a process.

    Args:
        target_action: The action of the process, a predicate of actions, or None for all.
        on_exit: Entities to visit, or a function of event and context that may return them.
        kwargs: Further arguments of `BaseEventHandler`.
    """

    # Any: arguments of `BaseEventHandler.`
    def __init__(
        self,
        *,
        target_action: Callable[[Action], bool] | Action | None = None,
        on_exit: OnEvent | None,
        **kwargs: Any,
    ) -> None:
        from ..actions.execute_local import ExecuteLocal

        super().__init__(
            action_matcher=target_action,
            on_event=on_exit,
            target_event_cls=ProcessExited,
            target_action_cls=ExecuteLocal,
            **kwargs,
        )
