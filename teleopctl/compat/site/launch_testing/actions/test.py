"""``launch_testing.actions.test``."""

from __future__ import annotations

from typing import Any

from launch import LaunchContext, LaunchDescriptionEntity, SomeSubstitutionsType
from launch.actions import EmitEvent, ExecuteProcess, RegisterEventHandler, TimerAction
from launch.event_handlers import OnProcessExit
from launch.events import matches_action
from launch.events.process import ShutdownProcess


class Test(ExecuteProcess):
    """Starts a process as a test.

    Args:
        timeout: Seconds after which the process is shut down; None for never.
        kill_timeout: Seconds from that to SIGTERM, and from there to SIGKILL.
        kwargs: Further arguments of `ExecuteProcess`.
    """

    __test__ = False  # to pytest

    # Any: arguments of `ExecuteProcess.`
    def __init__(
        self,
        *,
        timeout: float | SomeSubstitutionsType | None = None,
        kill_timeout: float | SomeSubstitutionsType = 5.0,
        **kwargs: Any,
    ) -> None:
        kill = str(kill_timeout) if isinstance(kill_timeout, int | float) else kill_timeout
        super().__init__(**{"sigterm_timeout": kill, "sigkill_timeout": kill, **kwargs})
        self._timeout = timeout

    @property
    def timeout(self) -> float | SomeSubstitutionsType | None:
        """Seconds after which the process is shut down, or None."""
        return self._timeout

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Start the process, and the timer for its timeout."""
        started = super().execute(context)
        if self._timeout is None:
            return started
        end = EmitEvent(event=ShutdownProcess(process_matcher=matches_action(self)))
        timer = TimerAction(period=self._timeout, actions=[end])

        def forget(*_: object) -> None:
            timer.cancel()

        has_ended = RegisterEventHandler(OnProcessExit(target_action=self, on_exit=forget))
        return [*(started or []), has_ended, timer]
