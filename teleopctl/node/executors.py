"""The executors: one thread, or a pool of threads that follows the rules of callback groups."""

from __future__ import annotations

import functools
import os
import threading
import time
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.context import Context
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.executor import Executor
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

    from teleopctl.node.endpoints.timer import Timer


class SingleThreadedExecutor(Executor):
    """Runs callbacks one after the other, in the thread that spins."""

    _hands_over = False

    def _run_waitable(self, waitable: QueuingEntity) -> bool:
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
    """Runs callbacks in a thread pool, as their callback groups allow.

    A message is taken, and a timer counts as called, when a thread begins with the callback.

    Args:
        num_threads: Size of the pool; the number of processors, at least 2, if None.
        context: See `Executor`.
    """

    _hands_over = False

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        from concurrent.futures import ThreadPoolExecutor

        size = num_threads or max(2, os.cpu_count() or 2)
        self._pool = ThreadPoolExecutor(size, thread_name_prefix="callback")
        # Ctrl-C raises in the main thread. Between a worker's start and its entry in the pool's
        # books it would leave one that nobody wakes at exit, so another thread starts them all.
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
        """Stop spinning; running callbacks are finished.

        Args:
            timeout_sec: How long to wait for that end, in seconds of wall time; None does not wait.

        Returns:
            False where a callback was waited for and still runs.
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
    """Have a pool start all its threads, and note them: none is idle until the last one runs."""
    together = threading.Barrier(size)

    def note() -> None:
        workers.append(threading.current_thread())
        together.wait()

    for _ in range(size):
        pool.submit(note)
