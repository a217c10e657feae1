"""Callbacks of goals, run as tasks of the executor outside any callback group."""

from __future__ import annotations

import collections
from collections.abc import Awaitable, Callable, Coroutine

from teleopctl.base.typed import TYPE_CHECKING, TypeVar, cast
from teleopctl.node.values.callback_groups import ReentrantCallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_endpoints import NodeEndpoints

OutcomeT = TypeVar("OutcomeT")


class Executions:
    """Coroutines queued for a node's executor, which may be set later.

    So they also begin where a program spins its node now and then, and starts a goal in between.
    """

    def __init__(self, node: NodeEndpoints) -> None:
        self._node = node
        self._waiting: collections.deque[Callable[[], Coroutine[object, None, None]]]
        self._waiting = collections.deque()
        self._guard = node.create_guard_condition(self._begin_next, ReentrantCallbackGroup())

    def add(self, begin: Callable[[], Coroutine[object, None, None]]) -> None:
        """Queue a function whose coroutine the executor will run; any thread may call this."""
        self._waiting.append(begin)
        self._guard.trigger()

    def _begin_next(self) -> Coroutine[object, None, None] | None:
        try:
            begin = self._waiting.popleft()
        except IndexError:
            return None
        if self._waiting:
            self._guard.trigger()
        return begin()

    def destroy(self) -> None:
        """Drop the queued coroutines."""
        self._waiting.clear()
        self._guard.destroy()
        self._node.destroy_guard_condition(self._guard)


async def outcome_of(
    callback: Callable[..., OutcomeT | Awaitable[OutcomeT]], *args: object
) -> OutcomeT:
    """Return the result of a function or coroutine function."""
    outcome = callback(*args)
    if hasattr(outcome, "__await__"):
        return await cast("Awaitable[OutcomeT]", outcome)
    return outcome
