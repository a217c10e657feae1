"""Waits of verbs that print an explanation after a second."""

from __future__ import annotations

import threading

from teleopctl.base.typed import TYPE_CHECKING, Callable
from teleopctl.cli import console
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.base.start_timeouts import StartTimeouts
    from teleopctl.node import BareNode, Node

_PATIENCE_S = 1.0


def wait_with_notice(
    wait: Callable[[float | None], bool], longest_s: float | None, explain: Callable[[], str]
) -> bool:
    """Wait for an event, printing an explanation after a second; return whether the event occurred.

    Args:
        wait: Function that waits for a number of seconds, None for no limit, and returns whether
            the event came.
        longest_s: Longest wait in seconds; None for no limit.
        explain: Function that returns the explanation.
    """
    first_s = _PATIENCE_S if longest_s is None else min(longest_s, _PATIENCE_S)
    if wait(first_s):
        return True
    console.note(explain())
    if longest_s == first_s:
        return False
    return wait(None if longest_s is None else longest_s - first_s)


def start_timeouts(
    timeout_s: float | None, stall_timeout_s: float | None, *, detach: bool
) -> StartTimeouts:
    """Return the start timeouts of ``--timeout`` and ``--stall-timeout``, which need ``detach``.

    Raises:
        UsageError: A time is not above 0, or a time is given without ``--detach``.
    """
    from teleopctl.base.start_timeouts import StartTimeouts

    timeouts = StartTimeouts()
    if timeout_s is not None:
        timeouts = timeouts._replace(total_s=_checked("--timeout", timeout_s, detach=detach))
    if stall_timeout_s is not None:
        stall_s = _checked("--stall-timeout", stall_timeout_s, detach=detach)
        timeouts = timeouts._replace(stall_s=stall_s)
    return timeouts


def _checked(option: str, time_s: float, *, detach: bool) -> float:
    if not detach:
        raise UsageError(
            f"{option} needs --detach: a launch in the foreground has no start to wait for"
        )
    if not time_s > 0:
        raise UsageError(f"{option} is {time_s:g}, expected a number above 0")
    return time_s


def wait_for_clock(node: Node | BareNode) -> None:
    """Wait until a node with ``use_sim_time`` has received ``/clock``."""
    clock = node.get_clock()
    has_come = threading.Event()
    clock.on_time_update(has_come.set)
    try:
        if clock.nanoseconds() == 0:
            wait_with_notice(has_come.wait, None, lambda: "No publisher of the time on /clock yet.")
    finally:
        clock.forget_on_time_update(has_come.set)
