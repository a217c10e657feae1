"""What the parts of a node know of the executor that runs their callbacks."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import Any, Protocol
from teleopctl.node.values.callback_groups import CallbackGroup


class Schedulable(Protocol):
    """An entity that queues arrivals until an executor takes them."""

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
        """Queue an entity whose arrivals the spinning thread will take."""

    def enqueue(self, work: Callable[[], object]) -> None:
        """Queue a function that the spinning thread will call."""

    def fail(self, error: BaseException) -> None:
        """Raise an exception in the spinning thread."""

    def wake(self) -> None:
        """Wake the spinning thread, so that it checks timers, shutdown and futures again."""

    def create_task(
        self, callback: Callable[..., object], *args: object, **kwargs: object
    ) -> object:
        """Run a function or coroutine; returns its future."""
