"""``launch_testing.ready_to_test_action_timeout``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from ._marks import TIMEOUT

# object: a launch description, with a test's context or without.
_Description = TypeVar("_Description", bound=Callable[..., object])


def ready_to_test_action_timeout(timeout: float) -> Callable[[_Description], _Description]:
    """Set the timeout until ``ReadyToTest`` is reached, by default 15 s.

    Args:
        timeout: Seconds.
    """

    def mark(function: _Description) -> _Description:
        setattr(function, TIMEOUT, timeout)
        return function

    return mark
