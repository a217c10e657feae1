"""Futures, and tasks that an executor runs, as in ``rclpy.task``."""

from __future__ import annotations

import sys
import threading
from _weakref import ref
from collections.abc import Callable, Coroutine, Generator, Iterator, Mapping, Sequence
from types import CoroutineType

from teleopctl.base.typed import (
    TYPE_CHECKING,
    Any,
    Generic,
    Protocol,
    TypeVar,
    cast,
    contextmanager,
    suppress,
)

if TYPE_CHECKING:
    import asyncio

    from teleopctl.node.values.callback_groups import Scheduler


ResultT = TypeVar("ResultT")


def _no_executor() -> None:
    """Return None, as the executor of a future without one."""


class Future(Generic[ResultT]):
    """Result of an asynchronous operation, as rclpy's class of this name.

    Args:
        executor: Runs the done callbacks; None runs them on the thread that sets the result.
    """

    def __init__(self, *, executor: Scheduler | None = None) -> None:
        # As in rclpy, whose private names base classes of large programs use: called, it returns
        # the executor, or None.
        self._executor: Callable[[], Scheduler | None] = (
            _no_executor if executor is None else ref(executor)
        )
        self._lock = threading.Lock()
        self._finished = threading.Event()
        self._cancelled = False
        self._result: ResultT | None = None
        self._exception: BaseException | None = None
        self._callbacks: list[Callable[[Future[ResultT]], object]] = []
        self._listeners: list[Callable[[], object]] = []

    def done(self) -> bool:
        """Return whether the future has a result or an exception; False if it was cancelled."""
        return self._finished.is_set() and not self._cancelled

    def ended(self) -> bool:
        """Return whether the future has a result or an exception, or was cancelled (ours)."""
        return self._finished.is_set()

    def cancelled(self) -> bool:
        """Return whether the future was cancelled."""
        return self._cancelled

    def result(self) -> ResultT | None:
        """Return the result, None while there is none; raise the exception if there is one.

        Raises:
            BaseException: The exception of `set_exception`.
        """
        if self._exception is not None:
            raise self._exception
        return self._result

    def exception(self) -> BaseException | None:
        """Return the exception; None if there is none."""
        return self._exception

    def set_result(self, result: ResultT) -> None:
        """Set the result and call the callbacks, unless they were called already."""
        with self._lock:
            self._result = result
            self._cancelled = False
        self._finish()

    def set_exception(self, exception: BaseException) -> None:
        """Set the exception and call the callbacks, unless they were called already."""
        with self._lock:
            self._exception = exception
            self._cancelled = False
        self._finish()

    def cancel(self) -> None:
        """Cancel the future, unless it has ended, and call the callbacks."""
        with self._lock:
            if self._finished.is_set():
                return
            self._cancelled = True
        self._finish()

    def wait(self, timeout_s: float | None = None) -> bool:
        """Block until the future has ended; return False on timeout (ours)."""
        return self._finished.wait(timeout_s)

    def add_done_callback(self, callback: Callable[[Future[ResultT]], object]) -> None:
        """Register a callback for the end of the future; called at once if it has ended."""
        with self._lock:
            if not self._finished.is_set():
                self._callbacks.append(callback)
                return
        self._call(callback)

    def remove_done_callback(self, callback: Callable[[Future[ResultT]], object]) -> None:
        """Unregister a callback of `add_done_callback`; unknown ones are ignored."""
        with self._lock:
            if callback in self._callbacks:
                self._callbacks.remove(callback)

    def on_end(self, listener: Callable[[], object]) -> None:
        """Register a function to call on the thread that ends the future, or at once (ours)."""
        with self._lock:
            if not self._finished.is_set():
                self._listeners.append(listener)
                return
        listener()

    def forget_on_end(self, listener: Callable[[], object]) -> None:
        """Unregister a function of `on_end`; unknown ones are ignored (ours)."""
        with self._lock:
            if listener in self._listeners:
                self._listeners.remove(listener)

    def _finish(self) -> None:
        with self._lock:
            self._finished.set()
            callbacks, self._callbacks = self._callbacks, []
            listeners, self._listeners = self._listeners, []
        # As in rclpy, awaiting tasks continue after the callbacks.
        try:
            for callback in callbacks:
                self._call(callback)
        finally:
            for listener in listeners:
                listener()

    def _call(self, callback: Callable[[Future[ResultT]], object]) -> None:
        executor = self._executor()
        if executor is None:
            callback(self)
        else:
            executor.create_task(callback, self)

    @property
    def _pending(self) -> bool:
        """Whether the future has not ended; rclpy's private name."""
        return not self._finished.is_set()

    @_pending.setter
    def _pending(self, is_pending: bool) -> None:
        if not is_pending:
            self._finished.set()

    def _schedule_or_invoke_done_callbacks(self) -> None:
        """Call the callbacks of the end; rclpy's private name."""
        self._finish()

    # Any: values yielded to an asyncio loop.
    def __await__(self) -> Generator[Any, Any, ResultT | None]:
        while not self.ended():
            loop = _running_loop()
            if loop is None or loop is _stepping.loop:
                yield self
            else:
                yield from self._end_in(loop)
        return self.result()

    def _end_in(self, loop: asyncio.AbstractEventLoop) -> asyncio.Future[None]:
        """Return an asyncio future that completes in its loop when this future ends."""
        ended: asyncio.Future[None] = loop.create_future()

        def end() -> None:
            if not ended.done():
                ended.set_result(None)

        def tell_loop() -> None:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(end)

        self.on_end(tell_loop)
        return ended


class AnyFuture(Protocol):
    """Interface of the futures that an executor can wait for: rclpy's, asyncio's, a pool's."""

    def done(self) -> bool:
        """Return whether the future has a result or an exception."""

    # Any: each kind calls back with itself.
    def add_done_callback(self, callback: Callable[[Any], object], /) -> object:
        """Register a callback for the end of the future."""


class WatchedFuture:
    """Future of any kind, as executors wait for it.

    An asyncio future calls its callbacks by its loop, which may not run while an executor spins; so
    its end is also noticed after each callback of the executor.
    """

    def __init__(self, future: AnyFuture) -> None:
        self._future = future

    def ended(self) -> bool:
        """Return whether the future has ended."""
        if isinstance(self._future, Future):
            return self._future.ended()
        return self._future.done()

    @contextmanager
    def waking(self, wake: Callable[[], object]) -> Iterator[None]:
        """Return a context manager during which the end of the future calls a function."""
        if isinstance(self._future, Future):
            self._future.on_end(wake)
            try:
                yield
            finally:
                self._future.forget_on_end(wake)
            return
        waits = True

        def end(_: object) -> None:
            if waits:
                wake()

        self._future.add_done_callback(end)
        try:
            yield
        finally:
            waits = False


class _Stepping(threading.local):
    """Asyncio loop in whose callback this thread runs a step of a `Task`; None outside of one.

    The executor, not the running loop, waits for the futures that such a task awaits.
    """

    loop: asyncio.AbstractEventLoop | None = None


_stepping = _Stepping()


def _running_loop() -> asyncio.AbstractEventLoop | None:
    """Return the asyncio loop that runs in this thread, without importing asyncio; else None."""
    module = sys.modules.get("asyncio")
    return None if module is None else module._get_running_loop()  # noqa: SLF001 (as documented)


def _send(coroutine: CoroutineType[Any, None, ResultT]) -> object:
    """Run a coroutine until it awaits something that has not ended."""
    before = _stepping.loop
    _stepping.loop = _running_loop()
    try:
        return coroutine.send(None)
    finally:
        _stepping.loop = before


class Task(Future[ResultT]):
    """Future of a function or coroutine that an executor runs in steps.

    Args:
        handler: Function, coroutine function or coroutine.
        args: Positional arguments of the function.
        kwargs: Keyword arguments of the function.
        executor: Executor that runs the task. If None, the caller runs the task, which may only
            await futures that have ended.
    """

    def __init__(
        self,
        handler: Callable[..., Coroutine[object, None, ResultT] | ResultT]
        | Coroutine[object, None, ResultT],
        args: Sequence[object] | None = None,
        kwargs: Mapping[str, object] | None = None,
        executor: Scheduler | None = None,
    ) -> None:
        super().__init__(executor=executor)
        self._runner = executor
        self._handler = handler
        self._args = args or ()
        self._executing = False
        self._task_lock = threading.RLock()  # rclpy's private name
        self._kwargs = kwargs or {}
        self._coroutine = handler if isinstance(handler, CoroutineType) else None

    def __call__(self) -> None:
        """Run until the end or the next ``await``; an exception ends the task and is kept there."""
        with suppress(Exception):
            self.step()

    def executing(self) -> bool:
        """Return whether the task's function or coroutine is running at this moment."""
        return self._executing

    def step(self) -> None:
        """Run the task until its end or the next ``await`` of a pending future.

        An exception of the function ends the task and is raised again, so that spinning raises it;
        the exception of an awaited future reaches the coroutine.
        """
        if self.ended():
            if self._coroutine is not None:
                self._coroutine.close()
            return
        self._executing = True
        try:
            if self._coroutine is None:
                assert callable(self._handler)
                outcome = self._handler(*self._args, **self._kwargs)
                if not isinstance(outcome, CoroutineType):
                    self.set_result(cast("ResultT", outcome))
                    return
                self._coroutine = outcome
            awaited = _send(self._coroutine)
        except StopIteration as end:
            self.set_result(end.value)
        except BaseException as error:
            self.set_exception(error)
            raise
        else:
            if self._runner is None:
                self._coroutine.close()
                raise RuntimeError("A task without an executor awaited a pending future")
            if isinstance(awaited, Future):
                awaited.on_end(self._schedule_step)
            else:
                self._schedule_step()
        finally:
            self._executing = False

    def _schedule_step(self) -> None:
        assert self._runner is not None
        self._runner.enqueue(self.step)
