"""Executors: one thread, or a pool of threads that follows the rules of callback groups."""

from __future__ import annotations

import functools
import os
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Iterator

from teleopctl.base.typed import TYPE_CHECKING, Any, cast, contextmanager, suppress
from teleopctl.node.context import Context
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup, Schedulable
from teleopctl.node.values.exceptions import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
)
from teleopctl.node.values.future import Future, ResultT, Task, WatchedFuture

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor
    from queue import Empty, SimpleQueue

    from teleopctl.node.endpoints.timer import Timer
    from teleopctl.node.node_endpoints import NodeEndpoints
    from teleopctl.node.values.future import AnyFuture

    Ready = tuple[Task[Any], QueuingEntity | Timer | None, NodeEndpoints | None]
else:
    from _queue import Empty, SimpleQueue  # the C module behind queue


class SpinGuard:
    """Lock that admits one spinning thread at a time; re-entrant, raises for other threads.

    Another thread that enters it gets a RuntimeError.
    """

    __slots__ = ("_depth", "_lock", "_owner")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._owner: int | None = None
        self._depth = 0

    @property
    def is_held(self) -> bool:
        """Whether a thread holds the lock."""
        return self._owner is not None

    def __enter__(self) -> None:
        me = threading.get_ident()
        if self._owner != me:
            if not self._lock.acquire(blocking=False):
                raise RuntimeError("Executor is already spinning")
            self._owner = me
        self._depth += 1

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if not self._depth:
            self._owner = None
            self._lock.release()

    @contextmanager
    def until(self, future: AnyFuture, wake: Callable[[], object]) -> Iterator[WatchedFuture]:
        """Return a context manager that holds the lock, and calls ``wake`` when the future ends."""
        watched = WatchedFuture(future)
        with self, watched.waking(wake):
            yield watched


# Limited on Windows, where Ctrl-C cannot interrupt a blocked wait.
_LONGEST_WAIT_S = 0.2 if sys.platform == "win32" else None
# Queue item without work: the spinning thread checks timers, futures and shutdown again.
_WAKE_UP = object()


class Executor:
    """Base of executors, which run the callbacks of their nodes.

    A custom executor overrides `spin_once` and calls the task that `wait_for_ready_callbacks`
    returns.

    Args:
        context: Context whose shutdown ends the spinning; the default context if None.
    """

    # Whether ready callbacks are returned by `wait_for_ready_callbacks` instead of being run.
    _returns_ready = True

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = context or Context.default()
        self._queue: SimpleQueue[Any] = SimpleQueue()
        self._queued: set[Schedulable | Timer] = set()
        # Replaced, never changed, so that spinning may iterate without a lock.
        self._nodes: tuple[NodeEndpoints, ...] = ()
        self._nodes_lock = threading.Lock()
        self._is_shutdown = False
        self._wake_queued = False
        self._timer_was_last = False
        self._held: set[QueuingEntity] = set()  # not admitted by their groups yet
        self._ready: Ready | None = None
        self._spin_guard = SpinGuard()
        self._context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """Context whose shutdown ends the spinning."""
        return self._context

    @property
    def is_shutdown(self) -> bool:
        """Whether `shutdown` was called (ours)."""
        return self._is_shutdown

    @property
    def is_spinning(self) -> bool:
        """Whether a thread spins the executor."""
        return self._spin_guard.is_held

    @property
    def _pending_tasks(self) -> dict[Task[Any], object]:
        """No tasks: those that wait are in the queue. rclpy's private name."""
        return {}

    # -- nodes -----------------------------------------------------------------------------------

    def add_node(self, node: NodeEndpoints) -> bool:
        """Add a node, removing it from its previous executor; False if it was here already.

        Raises:
            ShutdownException: The executor was shut down.
        """
        if self._is_shutdown:
            raise ShutdownException
        node = node.itself
        with self._nodes_lock:
            if node in self._nodes:
                return False
            self._nodes = (*self._nodes, node)
        node.executor = self
        for waitable in node.executor_entities():
            if waitable.pending():
                self.schedule(waitable)
        if node.failure is not None:
            self.fail(node.failure)
        self.wake()
        return True

    def remove_node(self, node: NodeEndpoints) -> None:
        """Remove a node from the executor; unknown ones are ignored."""
        node = node.itself
        with self._nodes_lock:
            if node not in self._nodes:
                return
            self._nodes = tuple(other for other in self._nodes if other is not node)
        if node.executor is self:
            node.executor = None

    def get_nodes(self) -> list[NodeEndpoints]:
        """Return the nodes of the executor."""
        return list(self._nodes)

    def can_execute(self, entity: QueuingEntity | Timer) -> bool:
        """Return whether the callback of an entity may start now: it is not waiting or running."""
        return entity not in self._queued and entity.callback_group.can_execute(entity)

    # -- from other threads ----------------------------------------------------------------------

    def schedule(self, waitable: Schedulable) -> None:
        """Queue an entity, unless queued, whose arrivals the spinning thread takes; thread-safe."""
        if waitable not in self._queued:
            self._queued.add(waitable)
            self._queue.put(waitable)

    def enqueue(self, work: Callable[[], object]) -> None:
        """Queue a function that the spinning thread will call; thread-safe."""
        self._queue.put(work)

    def fail(self, error: BaseException) -> None:
        """Queue an exception, which the spinning thread will raise; thread-safe."""
        self._queue.put(error)

    def wake(self) -> None:
        """Wake the spinning thread, to check timers, shutdown and futures again; thread-safe."""
        if not self._wake_queued:
            self._wake_queued = True
            self._queue.put(_WAKE_UP)

    def create_future(self) -> Future[Any]:  # Any: the caller sets the type
        """Return a new future whose done callbacks this executor runs."""
        return Future(executor=self)

    def create_task(
        self,
        callback: Callable[..., Coroutine[object, None, ResultT] | ResultT]
        | Coroutine[object, None, ResultT],
        *args: object,
        **kwargs: object,
    ) -> Task[ResultT]:
        """Schedule a function or coroutine on the executor; return its future."""
        task = Task(callback, args, kwargs, self)
        self.enqueue(task.step)
        return task

    # -- spinning --------------------------------------------------------------------------------

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down.

        Raises:
            ExternalShutdownException: A signal shut the context down.
        """
        # Call `spin_once` only if a subclass overrides it: ours would take the guard each time.
        once = self._spin_once if type(self).spin_once is Executor.spin_once else self.spin_once
        with self._spin_guard:
            while self._context.ok() and not self._is_shutdown:
                once()
        self._raise_if_ended_by_signal()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for a ready callback and run it; return without one when the timeout expires.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None or negative waits forever.

        Raises:
            ExternalShutdownException: A signal shut the context down.
        """
        with self._spin_guard:
            self._spin_once(_deadline(timeout_sec), None)
        self._raise_if_ended_by_signal()

    def wait_for_ready_callbacks(
        self,
        timeout_sec: float | None = None,
        nodes: object = None,  # noqa: ARG002 -- rclpy has it
        condition: Callable[[], bool] = lambda: False,
    ) -> Ready:
        """Wait for a custom executor's next callback; return task, entity, node; raise on timeout.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None or negative waits forever.
            nodes: Unused: all nodes of the executor are waited for.
            condition: Checked before waiting and after each wake-up; the exception is raised once
                it returns true.

        Returns:
            Task to call, and the entity and the node that the callback belongs to.

        Raises:
            TimeoutException: No callback became ready before the timeout.
            ConditionReachedException: The condition is true.
            ShutdownException: The executor was shut down.
        """
        self._spin_once(_deadline(timeout_sec), condition)
        ready, self._ready = self._ready, None
        if ready is not None:
            return ready
        if condition():
            raise ConditionReachedException
        self._raise_if_ended_by_signal()
        raise ShutdownException if self._is_shutdown else TimeoutException

    def spin_once_until_future_complete(
        self, future: AnyFuture, timeout_sec: float | None = None
    ) -> None:
        """Wait for one callback and run it; return when a future is done or the timeout expires."""
        with self._spin_guard.until(future, self.wake) as watched:
            if self._returns_ready:
                self.spin_once(timeout_sec)
            else:
                self._spin_once(_deadline(timeout_sec), watched.ended)
        self._raise_if_ended_by_signal()

    def spin_until_future_complete(
        self, future: AnyFuture, timeout_sec: float | None = None
    ) -> None:
        """Run callbacks until a future ends, the timeout expires, or the context is shut down.

        Args:
            future: Future of rclpy, asyncio or ``concurrent.futures``.
            timeout_sec: Longest wait in seconds of wall time; None or negative waits forever.
        """
        deadline = _deadline(timeout_sec)
        with self._spin_guard.until(future, self.wake) as watched:
            while self._context.ok() and not watched.ended() and not self._is_shutdown:
                if self._returns_ready:
                    # A subclass runs what is ready in a method of its own.
                    left_s = None if deadline is None else max(0.0, deadline - time.monotonic())
                    self.spin_once_until_future_complete(future, left_s)
                else:
                    self._spin_once(deadline, watched.ended)
                if deadline is not None and time.monotonic() >= deadline:
                    break
        self._raise_if_ended_by_signal()

    def shutdown(self, timeout_sec: float | None = None) -> bool:  # noqa: ARG002 (rclpy has it)
        """End spinning and remove all nodes, without waiting; return True."""
        self._is_shutdown = True
        for node in self._nodes:
            self.remove_node(node)
        self._context.forget_on_shutdown(self.wake)
        self.wake()
        return True

    def _raise_if_ended_by_signal(self) -> None:
        if self._context.ended_by_signal:
            raise ExternalShutdownException

    def _spin_once(
        self, deadline: float | None = None, ended: Callable[[], bool] | None = None
    ) -> None:
        """Run one callback; return without one at the deadline, on shutdown or if a wait ends."""
        while self._context.ok() and not self._is_shutdown:
            if ended is not None and ended():
                return
            timer, wait_s = self._next_timer()
            # Alternate: a timer that is always due must not block messages.
            if timer is not None and not self._timer_was_last:
                self._timer_was_last = True
                self._dispatch_timer(timer)
                self._reschedule_held()
                return
            self._timer_was_last = False
            item = self._next_item(wait_s, deadline)
            if item is _WAKE_UP:
                self._wake_queued = False
                # A group may have been released between its refusal and the entry among the held.
                self._reschedule_held()
            elif item is None:
                if timer is None and deadline is not None and time.monotonic() >= deadline:
                    return
            elif self._dispatch(item):
                self._reschedule_held()
                return

    def _next_timer(self) -> tuple[Timer | None, float | None]:
        """Return the timer that is due longest, or None, and the seconds until the next timer."""
        due: Timer | None = None
        lowest_ns = 1
        wait_s = _LONGEST_WAIT_S
        for node in self._nodes:
            for timer in node.timers:
                left_ns = timer.time_until_next_call()
                if left_ns is None or timer in self._queued:
                    continue
                if self._uses_group_rule(
                    timer.callback_group
                ) and not timer.callback_group.can_execute(timer):
                    continue
                if left_ns <= 0:
                    if left_ns < lowest_ns:
                        due, lowest_ns = timer, left_ns
                elif not timer.waits_for_clock and (wait_s is None or left_ns < wait_s * 1e9):
                    wait_s = left_ns / 1e9
        return due, wait_s if due is None else 0.0

    def _next_item(self, wait_s: float | None, deadline: float | None) -> Any:
        """Return the next item of the queue; None on timeout."""
        if deadline is not None:
            left_s = max(0.0, deadline - time.monotonic())
            wait_s = left_s if wait_s is None else min(wait_s, left_s)
        try:
            return self._queue.get(timeout=wait_s)
        except Empty:
            return None

    def _dispatch(self, item: Any) -> bool:
        """Run an item of the queue; return False if there was nothing to run."""
        if isinstance(item, QueuingEntity):
            if self._uses_group_rule(item.callback_group):
                return self._run_if_group_allows(item)
            return self._run_waitable(item)
        if isinstance(item, BaseException):
            raise item
        self._run(item)
        return True

    def _take(self, waitable: QueuingEntity) -> Callable[[], object] | None:
        """Take one arrival; an entity with further arrivals is queued again, after the others."""
        self._queued.discard(waitable)
        if waitable.node not in self._nodes:
            return None
        handler = waitable.take()
        if waitable.pending():
            self.schedule(waitable)
        return handler

    def _uses_group_rule(self, group: CallbackGroup) -> bool:
        """Return whether to check `can_execute` of a group; not for our groups and executors."""
        return group.decides or self._returns_ready

    def _run_if_group_allows(self, waitable: QueuingEntity) -> bool:
        group = waitable.callback_group
        if not (group.can_execute(waitable) and group.beginning_execution(waitable)):
            self._queued.discard(waitable)
            self._held.add(waitable)
            return False
        handler = self._take(waitable)
        if handler is None:
            group.ending_execution(waitable)
        else:
            self._run_in_custom_group(handler, waitable)
        return handler is not None

    def _dispatch_timer(self, timer: Timer) -> None:
        group = timer.callback_group
        if not self._uses_group_rule(group):
            self._run_timer(timer)
        elif group.beginning_execution(timer):
            self._run_in_custom_group(timer.take() or (lambda: None), timer)

    def _run_in_custom_group(self, handler: Callable[[], object], entity: Any) -> None:
        """Run a callback that its group has admitted, and report its end to the group."""

        def end() -> None:
            entity.callback_group.ending_execution(entity)
            self._reschedule_held()
            self.wake()

        task: Task[Any] = Task(handler, executor=self)
        task.on_end(end)
        if self._returns_ready:
            self._ready = (task, entity, entity.node)
        else:
            self._run(task.step)

    def _reschedule_held(self) -> None:
        """Schedule again the entities whose groups did not admit a callback."""
        while self._held:
            with suppress(KeyError):  # threads of a pool call this too
                self.schedule(self._held.pop())

    def _run_waitable(self, waitable: QueuingEntity) -> bool:
        """Take an arrival and run its callback; return False if there was no arrival."""
        raise NotImplementedError

    def _run_timer(self, timer: Timer) -> None:
        """Run the callback of a timer that is due."""
        raise NotImplementedError

    def _run(self, work: Callable[[], object]) -> None:
        """Run a function that belongs to no callback group."""
        self._ready = (Task(work, executor=self), None, None)

    def _start_if_coroutine(self, outcome: object) -> None:
        """Start a coroutine that a callback returned as a task, at once."""
        if outcome is not None and hasattr(outcome, "send") and hasattr(outcome, "throw"):
            Task(cast("Coroutine[object, None, object]", outcome), executor=self).step()

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()


def _deadline(timeout_sec: float | None) -> float | None:
    """Return the monotonic time at which a wait ends; None or negative waits forever."""
    return None if timeout_sec is None or timeout_sec < 0 else time.monotonic() + timeout_sec


class SingleThreadedExecutor(Executor):
    """Executor that runs callbacks one after the other, in the spinning thread."""

    _returns_ready = False

    def _run_waitable(self, waitable: QueuingEntity) -> bool:
        handler = self._take(waitable)
        if handler is None:
            return False
        self._start_if_coroutine(handler())
        return True

    def _run_timer(self, timer: Timer) -> None:
        if (callback := timer.take()) is not None:
            self._start_if_coroutine(callback())

    def _run(self, work: Callable[[], object]) -> None:
        self._start_if_coroutine(work())


class MultiThreadedExecutor(Executor):
    """Executor that runs callbacks in a thread pool, as their callback groups allow.

    A message is taken, and a timer counts as called, when a thread begins with the callback.

    Args:
        num_threads: Number of threads; the number of processors, at least 2, if None.
        context: Context whose shutdown ends the spinning; the default context if None.
    """

    _returns_ready = False

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        from concurrent.futures import ThreadPoolExecutor

        size = num_threads or max(2, os.cpu_count() or 2)
        self._pool = ThreadPoolExecutor(size, thread_name_prefix="callback")
        # Ctrl-C raises in the main thread. Between a worker's start and its entry in the pool's
        # list, it would leave a worker that is never woken at exit. So another thread starts them.
        self._workers: list[threading.Thread] = []
        starter = threading.Thread(
            target=_start_workers, args=(self._pool, size, self._workers), daemon=True
        )
        starter.start()
        starter.join()

    def _run_waitable(self, waitable: QueuingEntity) -> bool:
        def take_and_call() -> object:
            handler = self._take(waitable)
            return None if handler is None else handler()

        if not waitable.pending():
            self._queued.discard(waitable)
            # An arrival in between did not queue the entity again.
            if waitable.pending():
                self.schedule(waitable)
            return False
        # The entity counts as queued until a thread takes an arrival.
        self._queued.add(waitable)
        self._run_in_group(take_and_call, waitable.callback_group)
        return True

    def _run_timer(self, timer: Timer) -> None:
        def call() -> object:
            # In this order: between the two, the spinning thread would call the timer once more.
            callback = timer.take()
            self._queued.discard(timer)
            # The spinning thread has skipped the timer while it was queued.
            self.wake()
            return None if callback is None else callback()

        self._queued.add(timer)
        self._run_in_group(call, timer.callback_group)

    def _run(self, work: Callable[[], object]) -> None:
        self._submit(functools.partial(self._work, work))

    def _run_in_group(self, work: Callable[[], object], group: CallbackGroup) -> None:
        group.run(functools.partial(self._work, work), self._submit)

    def _work(self, work: Callable[[], object]) -> None:
        """Run a callback in a thread of the pool; pass its exception to the spinning thread."""
        if self._is_shutdown:
            return
        try:
            self._start_if_coroutine(work())
        except BaseException as error:  # noqa: BLE001 (sys.exit in a callback ends the program)
            self.fail(error)

    def _submit(self, work: Callable[[], None]) -> bool:
        try:
            self._pool.submit(work)
        except RuntimeError:
            return False
        return True

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """End spinning; return whether callbacks ended within the timeout, True at once if None.

        Args:
            timeout_sec: Longest wait for running callbacks to end, in seconds of wall time; None
                does not wait.
        """
        super().shutdown(timeout_sec)
        self._pool.shutdown(wait=False)
        if timeout_sec is None:
            return True
        deadline = time.monotonic() + timeout_sec
        for worker in self._workers:
            if worker is not threading.current_thread():
                worker.join(max(0.0, deadline - time.monotonic()))
        return not any(w.is_alive() for w in self._workers if w is not threading.current_thread())


def _start_workers(pool: ThreadPoolExecutor, size: int, workers: list[threading.Thread]) -> None:
    """Start all threads of a pool and collect them in a list, unless the program is ending."""
    together = threading.Barrier(size)

    def note() -> None:
        workers.append(threading.current_thread())
        with suppress(threading.BrokenBarrierError):
            together.wait()

    try:
        for _ in range(size):
            pool.submit(note)
    except RuntimeError:  # a program that ends takes no work; it waits for the threads it has
        together.abort()
