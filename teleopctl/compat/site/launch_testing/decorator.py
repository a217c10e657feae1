"""``launch_testing.decorator``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from ._marks import IS_AFTER_SHUTDOWN

_Case = TypeVar("_Case", bound=type)


def post_shutdown_test() -> Callable[[_Case], _Case]:
    """Mark a test class to run after all processes have exited."""

    def mark(test_class: _Case) -> _Case:
        if not isinstance(test_class, type):
            raise TypeError(f"post_shutdown_test() is for classes of tests, not for {test_class!r}")
        setattr(test_class, IS_AFTER_SHUTDOWN, True)
        return test_class

    return mark
