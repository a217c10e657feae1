"""``ros2cli.helpers``. Waiting for a condition."""

import time
from collections.abc import Callable

__all__ = ["wait_for"]


def wait_for(predicate: Callable[[], bool], timeout: float, period: float = 0.1) -> bool:
    """Call a function until it returns true; return False at the end of a timeout.

    Args:
        predicate: Function that returns whether the condition holds.
        timeout: Longest wait in seconds; negative waits forever.
        period: Seconds between two calls.
    """
    deadline = None if timeout < 0 else time.monotonic() + timeout
    while not predicate():
        if deadline is not None and time.monotonic() >= deadline:
            return predicate()
        time.sleep(period)
    return True
