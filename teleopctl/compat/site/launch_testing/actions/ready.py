"""``launch_testing.actions.ready``."""

from __future__ import annotations

import logging
from collections.abc import Callable

from launch import Action, LaunchContext, LaunchDescriptionEntity

_log = logging.getLogger(__name__)


class ReadyToTest(Action):
    """Starts the tests when the launch reaches it."""

    def __init__(self) -> None:
        super().__init__()
        self._callbacks: list[Callable[[], object]] = []

    def add_callback(self, callback: Callable[[], object]) -> None:
        """Add a function to call when the action is executed."""
        self._callbacks.append(callback)

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:  # noqa: ARG002 -- the signature of Action
        """Call the added functions."""
        for callback in self._callbacks:
            try:
                callback()
            except Exception:  # noqa: BLE001 -- a failing callback does not stop the launch
                _log.exception("a callback of ReadyToTest failed")
        return None
