"""What the parts of a node know of the executor that runs their callbacks."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import Any, Protocol
from teleopctl.node.values.callback_groups import CallbackGroup


class Schedulable(Protocol):
    """What queues arrivals until whoever spins takes them."""

    callback_group: CallbackGroup

    def take(self) -> Callable[[], object] | None:
        """Return what is to be done for the oldest arrival; None when nothing is left."""

    def pending(self) -> int:
        """Return how many arrivals wait."""


class Scheduler(Protocol):
    """Runs callbacks; all methods may be called from any thread."""

    @property
    def is_shutdown(self) -> bool:
        """Whether it runs no callbacks any more."""

    # Any: a node's class stands above this one.

    def add_node(self, node: Any) -> bool:
        """Serve a node from now on; False when it was served already."""

    def remove_node(self, node: Any) -> None:
        """Stop serving a node."""

    def schedule(self, waitable: Schedulable) -> None:
        """Have the arrivals of something taken by whoever spins."""

    def enqueue(self, work: Callable[[], object]) -> None:
        """Have something done by whoever spins."""

    def fail(self, error: BaseException) -> None:
        """Have whoever spins raise an exception."""

    def wake(self) -> None:
        """Have whoever spins look again at timers, shutdown and what it waits for."""

    def create_task(
        self, callback: Callable[..., object], *args: object, **kwargs: object
    ) -> object:
        """Run a function or coroutine; returns its future."""
