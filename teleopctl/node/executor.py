"""Executors: they wait for messages, requests, timers and tasks, and run the callbacks.

Everything that becomes ready is put into one queue by the thread that made it ready; spinning
takes from it, so nothing is polled and a message costs one wake-up.
"""

from __future__ import annotations

import abc
import concurrent.futures
import os
import queue
import sys
import time
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.node.callback_groups import CallbackGroup
from teleopctl.node.context import Context
from teleopctl.node.exceptions import ExternalShutdownException
from teleopctl.node.future import Future, Task

if TYPE_CHECKING:
    from teleopctl.node.node import Node
    from teleopctl.node.timer import Timer

# A blocked wait cannot be interrupted by Ctrl-C on Windows: come up for air there.
_LONGEST_WAIT_S = 0.2 if sys.platform == "win32" else None


class Waitable(Protocol):
    """Something that receives: it queues what arrives and hands out one handler for each."""

    callback_group: CallbackGroup

    def take(self) -> Callable[[], Any] | None:
        """Return what is to be done for the oldest arrival; None when nothing is left."""

    def pending(self) -> int:
        """Return how many arrivals wait."""


class _Signal:
    """A word to the spinning thread that carries no work."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return self.name


_RECHECK = _Signal("recheck timers")
_RETURN = _Signal("return from spin_once")


class Executor(abc.ABC):
    """Common base of the executors.

    Args:
        context: Whose shutdown ends the spinning; the default one if None.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = context or Context.default()
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._nodes: list[Node] = []
        self._is_shutdown = False
        self._recheck_queued = False
        self._context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """The context whose shutdown ends the spinning."""
        return self._context

    # -- nodes -----------------------------------------------------------------------------------

    def add_node(self, node: Node) -> bool:
        """Serve a node from now on.

        Returns:
            False when it was served already.
        """
        if node in self._nodes:
            return False
        self._nodes.append(node)
        node.executor = self
        for waitable in node.waitables():
            for _ in range(waitable.pending()):
                self.enqueue(waitable)
        self.recheck()
        return True

    def remove_node(self, node: Node) -> None:
        """Stop serving a node; unknown ones are ignored."""
        if node in self._nodes:
            self._nodes.remove(node)
            node.executor = None

    def get_nodes(self) -> list[Node]:
        """Return the nodes that are served."""
        return list(self._nodes)

    # -- from other threads ----------------------------------------------------------------------

    def enqueue(self, item: Waitable | Callable[[], Any]) -> None:
        """Have something done by whoever spins; any thread may call this."""
        self._queue.put(item)

    def wake(self) -> None:
        """Make a waiting ``spin_once`` return."""
        self._queue.put(_RETURN)

    def recheck(self) -> None:
        """Have the timers looked at again: one was added, or simulated time moved."""
        if not self._recheck_queued:
            self._recheck_queued = True
            self._queue.put(_RECHECK)

    def create_task(
        self, handler: Callable[..., Any] | Coroutine[Any, Any, Any], *arguments: Any
    ) -> Task:
        """Run a function or coroutine in the executor; returns its future."""
        task = Task(self, handler, arguments)
        self.enqueue(task.step)
        return task

    # -- spinning --------------------------------------------------------------------------------

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down.

        Raises:
            ExternalShutdownException: A signal shut the context down.
        """
        while self._context.ok() and not self._is_shutdown:
            self.spin_once()
        self._raise_if_ended_by_signal()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for one callback and run it.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None or negative waits for ever.

        Raises:
            ExternalShutdownException: A signal shut the context down.
        """
        if timeout_sec is None or timeout_sec < 0:
            deadline = None
        else:
            deadline = time.monotonic() + timeout_sec
        while self._context.ok():
            if (timer := self._due_timer()) is not None:
                self._call_timer(timer)
                return
            item = self._next_item(deadline)
            if item is _RECHECK:
                self._recheck_queued = False
            elif item is _RETURN:
                break
            elif item is None:
                if deadline is not None and time.monotonic() >= deadline:
                    return
            elif self._dispatch(item):
                return
        self._raise_if_ended_by_signal()

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until a future has ended or the time is over."""
        future.add_done_callback(self._wake_for)
        deadline = (
            None if timeout_sec is None or timeout_sec < 0 else (time.monotonic() + timeout_sec)
        )
        try:
            while self._context.ok() and not future.done() and not self._is_shutdown:
                left = None if deadline is None else deadline - time.monotonic()
                if left is not None and left <= 0:
                    return
                self.spin_once(left)
        finally:
            future.remove_done_callback(self._wake_for)

    def shutdown(self, timeout_sec: float | None = None) -> bool:  # noqa: ARG002 (rclpy has it)
        """Stop spinning and let go of the nodes."""
        self._is_shutdown = True
        for node in self.get_nodes():
            self.remove_node(node)
        self._context.forget_on_shutdown(self.wake)
        self.wake()
        return True

    def _wake_for(self, _: Future) -> None:
        self.wake()

    def _raise_if_ended_by_signal(self) -> None:
        if self._context.ended_by_signal:
            raise ExternalShutdownException

    def _due_timer(self) -> Timer | None:
        for node in self._nodes:
            for timer in node.timers:
                if timer.is_ready():
                    return timer
        return None

    def _next_item(self, deadline: float | None) -> Any:
        """Wait for the next thing in the queue; None when a timer or the deadline may be due."""
        wait_s = _LONGEST_WAIT_S
        if deadline is not None:
            left = max(0.0, deadline - time.monotonic())
            wait_s = left if wait_s is None else min(wait_s, left)
        for node in self._nodes:
            for timer in node.timers:
                until = timer.wall_time_until_next_call_s()
                if until is not None and (wait_s is None or until < wait_s):
                    wait_s = until
        try:
            return self._queue.get(timeout=wait_s)
        except queue.Empty:
            return None

    def _dispatch(self, item: Any) -> bool:
        """Run what was taken from the queue; False when it had nothing to do after all."""
        if isinstance(item, BaseException):
            raise item
        take = getattr(item, "take", None)
        if take is None:
            self._run(item, None)
            return True
        handler = take()
        if handler is None:
            return False
        self._run(handler, item.callback_group)
        return True

    def _call_timer(self, timer: Timer) -> None:
        timer.mark_called()
        if timer.callback is not None:
            self._run(timer.callback, timer.callback_group)

    @abc.abstractmethod
    def _run(self, handler: Callable[[], Any], group: CallbackGroup | None) -> None:
        """Run a callback, now or in a thread of its own."""

    def _finish(self, outcome: Any) -> None:
        """Go on with what a callback returned: a coroutine becomes a task."""
        if hasattr(outcome, "send") and hasattr(outcome, "throw"):
            self.create_task(outcome)

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins, one after the other."""

    def _run(self, handler: Callable[[], Any], group: CallbackGroup | None) -> None:  # noqa: ARG002
        self._finish(handler())


class MultiThreadedExecutor(Executor):
    """Runs callbacks in a pool of threads, as their callback groups allow.

    Args:
        num_threads: Size of the pool; the number of processors, at least 2, if None.
        context: See :class:`Executor`.
    """

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        self._pool = concurrent.futures.ThreadPoolExecutor(
            num_threads or max(2, os.cpu_count() or 2), thread_name_prefix="callback"
        )

    def _run(self, handler: Callable[[], Any], group: CallbackGroup | None) -> None:
        def work() -> None:
            try:
                self._finish(handler())
            except Exception as error:  # noqa: BLE001 (raised again by whoever spins)
                self._queue.put(error)

        if group is None:
            self._pool.submit(work)
        else:
            group.run(work, self._submit)

    def _submit(self, work: Callable[[], None]) -> None:
        self._pool.submit(work)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop spinning; callbacks that run go on to their end."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        return super().shutdown(timeout_sec)
