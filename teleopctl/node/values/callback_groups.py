"""Callback groups, and the interface of the executors that follow their rules."""

from __future__ import annotations

import collections
import threading
from _weakref import ref
from collections.abc import Callable

from teleopctl.base.typed import Any, ClassVar, Protocol

Work = Callable[[], None]
# Submits work to a pool; returns False if the pool is closed.
Submit = Callable[[Work], bool]


# Any: entities are timers, subscriptions and the like, whose modules import this one.


class CallbackGroup:
    """Base of callback groups, which decide when callbacks of their entities may run.

    A custom group overrides `can_execute`, `beginning_execution` and `ending_execution`; executors
    call these before and after each callback of its entities.

    Attributes:
        decides: Whether the class has a rule of its own.
    """

    decides: ClassVar[bool] = False

    def __init__(self) -> None:
        self.entities: set[ref[Any]] = set()

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        rule = {"can_execute", "beginning_execution", "ending_execution"}
        cls.decides = cls.decides or (cls.__module__ != __name__ and not rule.isdisjoint(vars(cls)))

    def add_entity(self, entity: Any) -> None:
        """Add a timer, subscription or other entity to the group."""
        self.entities.add(ref(entity, self.entities.discard))

    def has_entity(self, entity: Any) -> bool:
        """Return whether an entity is in the group."""
        return ref(entity) in self.entities

    def can_execute(self, entity: Any) -> bool:
        """Return whether an entity's callback may start now, called by executors; abstract."""
        raise NotImplementedError

    def beginning_execution(self, entity: Any) -> bool:
        """Record that an entity's callback starts, or return False if it may not; abstract."""
        raise NotImplementedError

    def ending_execution(self, entity: Any) -> None:
        """Record that an entity's callback has ended, called by executors; abstract."""
        raise NotImplementedError

    def run(self, work: Work, submit: Submit) -> None:
        """Submit a function to a pool as soon as the group allows; in this base class at once."""
        submit(work)


class ReentrantCallbackGroup(CallbackGroup):
    """Callback group whose callbacks may run in parallel."""

    def can_execute(self, entity: Any) -> bool:  # noqa: ARG002 -- the same for all entities
        """Return True: callbacks of the group may start at any time."""
        return True

    def beginning_execution(self, entity: Any) -> bool:  # noqa: ARG002 -- the same for all entities
        """Return True: callbacks of the group may start at any time."""
        return True

    def ending_execution(self, entity: Any) -> None:
        """Do nothing: no callback of the group waits for another."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Callback group that runs one callback at a time, in the order of submission."""

    def __init__(self) -> None:
        super().__init__()
        self._lock = threading.Lock()
        self._active: Any = None
        self._busy = False
        self._waiting: collections.deque[tuple[Work, Submit]] = collections.deque()

    def can_execute(self, entity: Any) -> bool:
        """Return whether no callback of the group is running."""
        with self._lock:
            assert ref(entity) in self.entities
            return self._active is None

    def beginning_execution(self, entity: Any) -> bool:
        """Record that a callback starts; return False while another one runs."""
        with self._lock:
            assert ref(entity) in self.entities
            if self._active is not None:
                return False
            self._active = entity
            return True

    def ending_execution(self, entity: Any) -> None:
        """Record that the running callback has ended, so that another may start."""
        with self._lock:
            assert self._active is entity
            self._active = None

    def run(self, work: Work, submit: Submit) -> None:
        """Submit a function to a pool, after all earlier ones of the group have ended."""
        with self._lock:
            self._waiting.append((work, submit))
            if self._busy:
                return
            self._busy = True
        self._submit_next()

    def _submit_next(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._busy = False
                    return
                work, submit = self._waiting.popleft()
            # A closed pool accepts nothing; work for another pool still runs.
            if submit(self._run_then_next(work)):
                return

    def _run_then_next(self, work: Work) -> Work:
        def run_and_continue() -> None:
            try:
                work()
            finally:
                self._submit_next()

        return run_and_continue


class Schedulable(Protocol):
    """Interface of entities that queue arrivals until an executor takes them."""

    callback_group: CallbackGroup

    def take(self) -> Callable[[], object] | None:
        """Remove the oldest arrival; return the call that handles it, None if there is none."""

    def pending(self) -> int:
        """Return how many arrivals are queued."""


class Scheduler(Protocol):
    """Interface of executors as entities and nodes use it; all methods are thread-safe."""

    @property
    def is_shutdown(self) -> bool:
        """Whether the executor was shut down."""

    # Any: the module of the node class imports this one.

    def add_node(self, node: Any) -> bool:
        """Add a node to the executor; return False if it was added before."""

    def remove_node(self, node: Any) -> None:
        """Remove a node from the executor."""

    def schedule(self, waitable: Schedulable) -> None:
        """Queue an entity whose arrivals the spinning thread will take."""

    def enqueue(self, work: Callable[[], object]) -> None:
        """Queue a function that the spinning thread will call."""

    def fail(self, error: BaseException) -> None:
        """Raise an exception in the spinning thread."""

    def wake(self) -> None:
        """Wake the spinning thread, to check timers, shutdown and futures again."""

    def create_task(
        self, callback: Callable[..., object], *args: object, **kwargs: object
    ) -> object:
        """Schedule a function or coroutine on the executor; return its future."""
