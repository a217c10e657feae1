"""``launch.event_handlers.on_process_io``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..action import Action
from ..event import Event
from ..events.process import ProcessIO
from .on_action_event_base import OnActionEventBase

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_entities_type import SomeEntitiesType

    OnOutput = Callable[[ProcessIO], SomeEntitiesType | None]


class OnProcessIO(OnActionEventBase):
    """Handles output of a process.

    Args:
        target_action: The action of the process, a predicate of actions, or None for all.
        on_stdin: Called for what goes into it.
        on_stdout: Called for what it writes to stdout.
        on_stderr: Called for what it writes to stderr.
        kwargs: Further arguments of `BaseEventHandler`.
    """

    # Any: arguments of `BaseEventHandler.`
    def __init__(
        self,
        *,
        target_action: Callable[[Action], bool] | Action | None = None,
        on_stdin: OnOutput | None = None,
        on_stdout: OnOutput | None = None,
        on_stderr: OnOutput | None = None,
        **kwargs: Any,
    ) -> None:
        from ..actions.execute_local import ExecuteLocal

        def on_event(event: Event, _: LaunchContext) -> SomeEntitiesType | None:
            assert isinstance(event, ProcessIO)
            told = on_stdin
            if event.from_stdout:
                told = on_stdout
            elif event.from_stderr:
                told = on_stderr
            return None if told is None else told(event)

        super().__init__(
            action_matcher=target_action,
            on_event=on_event,
            target_event_cls=ProcessIO,
            target_action_cls=ExecuteLocal,
            **kwargs,
        )
