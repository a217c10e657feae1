"""``launch_testing.event_handlers.stdout_ready_listener``."""

from __future__ import annotations

from collections.abc import Iterable

from launch import SomeEntitiesType
from launch.actions import ExecuteLocal
from launch.event_handlers import OnProcessIO
from launch.events.process import ProcessIO


class StdoutReadyListener(OnProcessIO):
    """Handles a line on a process's stdout that marks it as ready.

    Args:
        target_action: The action that starts it; None for any process.
        ready_txt: Text in the line that marks it as ready.
        actions: Actions to execute then.
    """

    def __init__(
        self,
        *,
        target_action: ExecuteLocal | None = None,
        ready_txt: str,
        actions: SomeEntitiesType,
    ) -> None:
        self._said = ready_txt
        self._actions = list(actions) if isinstance(actions, Iterable) else [actions]
        super().__init__(target_action=target_action, on_stdout=self._heard)

    def _heard(self, event: ProcessIO) -> SomeEntitiesType | None:
        return self._actions if self._said in event.text.decode(errors="replace") else None

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return a readable form of the handler, and its entities."""
        return super().describe()[0], list(self._actions)
