"""``launch_testing.actions.ready``."""

from __future__ import annotations

import logging
from collections.abc import Callable

from launch import Action, LaunchContext, LaunchDescriptionEntity

_log = logging.getLogger(__name__)


class ReadyToTest(Action):
    """Lets the tests begin when it is reached."""

    def __init__(self) -> None:
        super().__init__()
        self._callbacks: list[Callable[[], object]] = []

    def add_callback(self, callback: Callable[[], object]) -> None:
        """Have a function called when it is reached."""
        self._callbacks.append(callback)

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:  # noqa: ARG002 -- the word of Action
        """Tell who waits for it."""
        for callback in self._callbacks:
            try:
                callback()
            except Exception:  # noqa: BLE001 -- the launch goes on, whatever a stranger's function does
                _log.exception("a callback of ReadyToTest failed")
        return None
