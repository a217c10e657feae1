"""Temporary changes of this process's environment variables while a launch file is evaluated.

ROS 2's launch changes its own environment, so that functions of a launch file, ``xacro`` and other
code read the variables that earlier actions have set. Here the changes are made only while such
code runs: a process of another group that starts later gets the original environment.
"""

from __future__ import annotations

import os

from teleopctl.base.typed import Mapping


class EnvironmentOverlay:
    """The launch's changes to ``os.environ``, made only while launch files are evaluated."""

    def __init__(self) -> None:
        self._before: dict[str, str | None] = {}
        # Environment at the start of the user code that is running.
        self._seen: dict[str, str] = {}
        self._depth = 0

    def show(self, changes: Mapping[str, str | None]) -> None:
        """Set ``os.environ`` to its original state plus changes; None removes a variable."""
        for name in self._before.keys() - changes.keys():
            self._set(name, self._before.pop(name))
        for name, value in changes.items():
            self._before.setdefault(name, os.environ.get(name))
            self._set(name, value)

    def begin_user_code(self, changes: dict[str, str | None]) -> None:
        """Apply ``changes`` to ``os.environ`` and note the result, before launch file code runs."""
        if self._depth:
            self._take_in(changes)
        self.show(changes)
        self._seen = dict(os.environ)
        self._depth += 1

    def end_user_code(self, changes: dict[str, str | None]) -> None:
        """Add what launch file code changed in ``os.environ`` to ``changes``; keep it set."""
        self._take_in(changes)
        self.show(changes)
        self._depth -= 1

    def _take_in(self, changes: dict[str, str | None]) -> None:
        before, self._seen = self._seen, dict(os.environ)
        if before == self._seen:
            return
        for name in before.keys() | self._seen.keys():
            if before.get(name) != self._seen.get(name):
                self._before.setdefault(name, before.get(name))
                changes[name] = self._seen.get(name)

    def _set(self, name: str, value: str | None) -> None:
        if os.environ.get(name) == value:
            return
        if value is None:
            del os.environ[name]
            self._seen.pop(name, None)
        else:
            self._seen[name] = os.environ[name] = value
