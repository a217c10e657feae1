"""``launch_testing.markers``."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any, TypeVar

from ._marks import MARKERS

# Any: functions of a test description have any arguments and results.
_Description = TypeVar("_Description", bound=Callable[..., Any])


def keep_alive(test_description: _Description) -> _Description:
    """Keep a launch running after all its processes have exited, until its tests have run."""
    if not hasattr(test_description, MARKERS):
        setattr(test_description, MARKERS, {})
    getattr(test_description, MARKERS)["keep_alive"] = True
    return test_description


def retry_on_failure(
    *, times: int, delay: float | None = None
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Repeat a test when it fails, up to a total number of runs.

    Args:
        times: Largest number of runs.
        delay: Seconds to wait before it runs again; None for none.

    Raises:
        ValueError: `times` is below 1.
    """
    if times <= 0:
        raise ValueError(f"retry_on_failure(times={times}): it has to run once at least")

    def decorate(test: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(test)
        def retried(self: Any, *args: Any, **kwargs: Any) -> Any:
            for _ in range(times - 1):
                try:
                    return test(self, *args, **kwargs)
                except AssertionError:
                    if delay is not None:
                        time.sleep(delay)
            return test(self, *args, **kwargs)

        return retried

    return decorate
