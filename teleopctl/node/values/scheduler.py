"""What the parts of a node know of the executor that runs their callbacks."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import Any, Protocol
from teleopctl.node.values.callback_groups import CallbackGroup


class Schedulable(Protocol):
    """An entity that queues arrivals until an executor takes them."""

    callback_group: CallbackGroup

    def take(self) -> Callable[[], object] | None:
        """Return the call for the oldest arrival; None if there is none."""

    def pending(self) -> int:
        """Return how many arrivals are queued."""


class Scheduler(Protocol):
    """Interface of executors; all methods are thread-safe."""

    @property
    def is_shutdown(self) -> bool:
        """Whether the executor was shut down."""

    # Any: a node's class stands above this one.

    def add_node(self, node: Any) -> bool:
        """Add a node; return False if it was added before."""

    def remove_node(self, node: Any) -> None:
        """Remove a node."""

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
        """Run a function or coroutine; return its future."""
