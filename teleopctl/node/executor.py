"""Executors: they wait for messages, requests, timers and tasks, and run the callbacks.

Everything that becomes ready is put into one queue by the thread that made it ready; spinning
takes from it, so nothing is polled and a message costs one wake-up. What receives is in the queue
at most once, however much has arrived: arrivals wait in its own queue, whose depth its QoS bounds.
"""

from __future__ import annotations

import abc
import functools
import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any, cast

from teleopctl.node.context import Context
from teleopctl.node.endpoints.waitable import Waitable
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.exceptions import ExternalShutdownException, ShutdownException
from teleopctl.node.values.future import Future, ResultT, Task
from teleopctl.node.values.scheduler import Schedulable

if TYPE_CHECKING:
    from teleopctl.node.endpoints.timer import Timer
    from teleopctl.node.node_endpoints import NodeEndpoints

# A blocked wait cannot be interrupted by Ctrl-C on Windows: come up for air there.
_LONGEST_WAIT_S = 0.2 if sys.platform == "win32" else None

# A word to the spinning thread that carries no work: something changed, look at everything again.
_LOOK_AGAIN = object()


class Executor(abc.ABC):
    """Common base of the executors.

    Args:
        context: Whose shutdown ends the spinning; the default one if None.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = context or Context.default()
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._queued: set[Schedulable | Timer] = set()
        # Replaced, never changed, so that spinning may iterate without a lock.
        self._nodes: tuple[NodeEndpoints, ...] = ()
        self._nodes_lock = threading.Lock()
        self._is_shutdown = False
        self._wake_queued = False
        self._timer_was_last = False
        self._context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """The context whose shutdown ends the spinning."""
        return self._context

    @property
    def is_shutdown(self) -> bool:
        """True after `shutdown` (ours)."""
        return self._is_shutdown

    # -- nodes -----------------------------------------------------------------------------------

    def add_node(self, node: NodeEndpoints) -> bool:
        """Serve a node from now on; the executor that served it before lets it go.

        Returns:
            False when it was served already.

        Raises:
            ShutdownException: The executor was shut down.
        """
        if self._is_shutdown:
            raise ShutdownException
        with self._nodes_lock:
            if node in self._nodes:
                return False
            self._nodes = (*self._nodes, node)
        if node.executor is not None:
            node.executor.remove_node(node)
        node.executor = self
        for waitable in node.waitables():
            if waitable.pending():
                self.schedule(waitable)
        if node.failure is not None:
            self.fail(node.failure)
        self.wake()
        return True

    def remove_node(self, node: NodeEndpoints) -> None:
        """Stop serving a node; unknown ones are ignored."""
        with self._nodes_lock:
            if node not in self._nodes:
                return
            self._nodes = tuple(other for other in self._nodes if other is not node)
        if node.executor is self:
            node.executor = None

    def get_nodes(self) -> list[NodeEndpoints]:
        """Return the nodes that are served."""
        return list(self._nodes)

    # -- from other threads ----------------------------------------------------------------------

    def schedule(self, waitable: Schedulable) -> None:
        """Have the arrivals of something taken by whoever spins; any thread may call this."""
        if waitable not in self._queued:
            self._queued.add(waitable)
            self._queue.put(waitable)

    def enqueue(self, work: Callable[[], object]) -> None:
        """Have something done by whoever spins; any thread may call this."""
        self._queue.put(work)

    def fail(self, error: BaseException) -> None:
        """Have whoever spins raise an exception; any thread may call this."""
        self._queue.put(error)

    def wake(self) -> None:
        """Have whoever spins look again at timers, shutdown and what it waits for."""
        if not self._wake_queued:
            self._wake_queued = True
            self._queue.put(_LOOK_AGAIN)

    def create_future(self) -> Future[Any]:
        """Make a future whose callbacks this executor runs."""
        return Future(executor=self)

    def create_task(
        self,
        callback: Callable[..., Coroutine[object, None, ResultT] | ResultT]
        | Coroutine[object, None, ResultT],
        *args: object,
        **kwargs: object,
    ) -> Task[ResultT]:
        """Run a function or coroutine in the executor; returns its future."""
        task = Task(callback, args, kwargs, self)
        self.enqueue(task.step)
        return task

    # -- spinning --------------------------------------------------------------------------------

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down.

        Raises:
            ExternalShutdownException: A signal shut the context down.
        """
        while self._context.ok() and not self._is_shutdown:
            self._spin_once(None, None)
        self._raise_if_ended_by_signal()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for one callback and run it.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None or negative waits for ever.

        Raises:
            ExternalShutdownException: A signal shut the context down.
        """
        self._spin_once(_deadline(timeout_sec), None)
        self._raise_if_ended_by_signal()

    def spin_once_until_future_complete(
        self, future: Future[ResultT], timeout_sec: float | None = None
    ) -> None:
        """Wait for one callback and run it, or until a future has ended or the time is over."""
        future.on_end(self.wake)
        try:
            self._spin_once(_deadline(timeout_sec), future)
        finally:
            future.forget_on_end(self.wake)
        self._raise_if_ended_by_signal()

    def spin_until_future_complete(
        self, future: Future[ResultT], timeout_sec: float | None = None
    ) -> None:
        """Run callbacks until a future has ended or the time is over.

        A time of 0 still runs one callback that is ready.
        """
        deadline = _deadline(timeout_sec)
        future.on_end(self.wake)
        try:
            while self._context.ok() and not future.done() and not self._is_shutdown:
                self._spin_once(deadline, future)
                if deadline is not None and time.monotonic() >= deadline:
                    break
        finally:
            future.forget_on_end(self.wake)
        self._raise_if_ended_by_signal()

    def shutdown(self, timeout_sec: float | None = None) -> bool:  # noqa: ARG002 (rclpy has it)
        """Stop spinning and let go of the nodes."""
        self._is_shutdown = True
        for node in self._nodes:
            self.remove_node(node)
        self._context.forget_on_shutdown(self.wake)
        self.wake()
        return True

    def _raise_if_ended_by_signal(self) -> None:
        if self._context.ended_by_signal:
            raise ExternalShutdownException

    def _spin_once(self, deadline: float | None, future: Future[ResultT] | None) -> None:
        """Run one callback; return without one at the deadline and when something ends."""
        while self._context.ok() and not self._is_shutdown:
            if future is not None and future.done():
                return
            timer, wait_s = self._next_timer()
            # Turn about: a timer that is always due must not keep the messages from being taken.
            if timer is not None and not self._timer_was_last:
                self._timer_was_last = True
                self._run_timer(timer)
                return
            self._timer_was_last = False
            item = self._next_item(wait_s, deadline)
            if item is _LOOK_AGAIN:
                self._wake_queued = False
            elif item is None:
                if timer is None and deadline is not None and time.monotonic() >= deadline:
                    return
            elif self._dispatch(item):
                return

    def _next_timer(self) -> tuple[Timer | None, float | None]:
        """Return the timer that is due longest, or None, and how long to wait for the next one."""
        due: Timer | None = None
        lowest_ns = 1
        wait_s = _LONGEST_WAIT_S
        for node in self._nodes:
            for timer in node.timers:
                left_ns = timer.time_until_next_call()
                if left_ns is None or timer in self._queued:
                    continue
                if left_ns <= 0:
                    if left_ns < lowest_ns:
                        due, lowest_ns = timer, left_ns
                elif not timer.waits_for_event and (wait_s is None or left_ns < wait_s * 1e9):
                    wait_s = left_ns / 1e9
        return due, wait_s if due is None else 0.0

    def _next_item(self, wait_s: float | None, deadline: float | None) -> Any:
        """Wait for the next thing in the queue; None when the time is over."""
        if deadline is not None:
            left_s = max(0.0, deadline - time.monotonic())
            wait_s = left_s if wait_s is None else min(wait_s, left_s)
        try:
            return self._queue.get(timeout=wait_s)
        except queue.Empty:
            return None

    def _dispatch(self, item: Any) -> bool:
        """Run what was taken from the queue; False when it had nothing to do after all."""
        if isinstance(item, Waitable):
            return self._run_waitable(item)
        if isinstance(item, BaseException):
            raise item
        self._run(item)
        return True

    def _take(self, waitable: Waitable) -> Callable[[], object] | None:
        """Take one arrival; what has more comes again, after all others that wait."""
        self._queued.discard(waitable)
        if waitable.node not in self._nodes:
            return None
        handler = waitable.take()
        if waitable.pending():
            self.schedule(waitable)
        return handler

    @abc.abstractmethod
    def _run_waitable(self, waitable: Waitable) -> bool:
        """Take an arrival and run its callback; False when there was none."""

    @abc.abstractmethod
    def _run_timer(self, timer: Timer) -> None:
        """Run the callback of a timer that is due."""

    @abc.abstractmethod
    def _run(self, work: Callable[[], object]) -> None:
        """Run what belongs to no callback group."""

    def _finish(self, outcome: object) -> None:
        """Go on with what a callback returned: a coroutine becomes a task, and begins at once."""
        if outcome is not None and hasattr(outcome, "send") and hasattr(outcome, "throw"):
            Task(cast("Coroutine[object, None, object]", outcome), executor=self).step()

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins, one after the other."""

    def _run_waitable(self, waitable: Waitable) -> bool:
        handler = self._take(waitable)
        if handler is None:
            return False
        self._finish(handler())
        return True

    def _run_timer(self, timer: Timer) -> None:
        if (callback := timer.take()) is not None:
            self._finish(callback())

    def _run(self, work: Callable[[], object]) -> None:
        self._finish(work())


class MultiThreadedExecutor(Executor):
    """Runs callbacks in a pool of threads, as their callback groups allow.

    A message is taken, and a timer counts as called, when a thread begins with the callback.

    Args:
        num_threads: Size of the pool; the number of processors, at least 2, if None.
        context: See `Executor`.
    """

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        from concurrent.futures import ThreadPoolExecutor

        self._pool = ThreadPoolExecutor(
            num_threads or max(2, os.cpu_count() or 2), thread_name_prefix="callback"
        )

    def _run_waitable(self, waitable: Waitable) -> bool:
        def take_and_call() -> object:
            handler = self._take(waitable)
            return None if handler is None else handler()

        if not waitable.pending():
            self._queued.discard(waitable)
            # An arrival in between found it queued still.
            if waitable.pending():
                self.schedule(waitable)
            return False
        # It counts as queued until a thread takes from it.
        self._queued.add(waitable)
        self._run_in_group(take_and_call, waitable.callback_group)
        return True

    def _run_timer(self, timer: Timer) -> None:
        def call() -> object:
            self._queued.discard(timer)
            callback = timer.take()
            # Whoever spins left the timer out while it was on its way here.
            self.wake()
            return None if callback is None else callback()

        self._queued.add(timer)
        self._run_in_group(call, timer.callback_group)

    def _run(self, work: Callable[[], object]) -> None:
        self._submit(functools.partial(self._work, work))

    def _run_in_group(self, work: Callable[[], object], group: CallbackGroup) -> None:
        group.run(functools.partial(self._work, work), self._submit)

    def _work(self, work: Callable[[], object]) -> None:
        """Run a callback in a thread of the pool; whoever spins raises what it raised."""
        if self._is_shutdown:
            return
        try:
            self._finish(work())
        except BaseException as error:  # noqa: BLE001 (sys.exit in a callback ends the program)
            self.fail(error)

    def _submit(self, work: Callable[[], None]) -> bool:
        try:
            self._pool.submit(work)
        except RuntimeError:
            return False
        return True

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop spinning; callbacks that run go on to their end."""
        super().shutdown(timeout_sec)
        self._pool.shutdown(wait=False)
        return True


def _deadline(timeout_sec: float | None) -> float | None:
    """Return the monotonic time at which a wait ends; None or negative waits for ever."""
    return None if timeout_sec is None or timeout_sec < 0 else time.monotonic() + timeout_sec
