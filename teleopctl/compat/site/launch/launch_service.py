"""``launch.launch_service``."""

from __future__ import annotations

import atexit
import logging
import threading
from collections.abc import Callable, Coroutine, Generator, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.launch import (
    Evaluation,
    LaunchContext as State,
    LaunchPlan,
    LaunchRequest,
    ProcessBuilder,
    new_log_directory,
)

from .event import emit
from .event_handlers import OnIncludeLaunchDescription, OnShutdown
from .events import IncludeLaunchDescription
from .launch_context import LaunchContext
from .logging import launch_config

if TYPE_CHECKING:
    import asyncio

    from .event import Event
    from .launch_description import LaunchDescription

# Longest time for which the end of a program waits for the processes of its launch to end.
_END_S = 12.0


class LaunchService:
    """Runs launch descriptions in the calling program.

    Args:
        argv: Words of the command line, for the context.
        noninteractive: Whether there is no terminal.
        debug: Whether lines for finding mistakes are shown.
    """

    def __init__(
        self,
        *,
        argv: Iterable[str] | None = None,
        noninteractive: bool = False,
        debug: bool = False,
    ) -> None:
        launch_config.level = logging.DEBUG if debug else logging.INFO
        self._log_directory = new_log_directory()
        state = State({}, self._log_directory)
        builder = ProcessBuilder(state, LaunchRequest(file=""))
        self._evaluation = Evaluation(state, builder)
        self._context = LaunchContext.with_launch(self._evaluation)
        self._context.argv = list(argv or ())
        self._context.noninteractive = noninteractive
        self._context.register_event_handler(OnIncludeLaunchDescription())
        self._stay = _Stay()
        self._context.register_event_handler(OnShutdown(on_shutdown=self._stay.end))
        self._lock = threading.Lock()
        self._runs = False
        self._task: asyncio.Task[int] | None = None
        self._thread: int | None = None

    @property
    def context(self) -> LaunchContext:
        """Context of the launch."""
        return self._context

    @property
    def event_loop(self) -> asyncio.AbstractEventLoop | None:
        """Event loop of the launch's coroutines; None while no launch runs."""
        return self._context.asyncio_loop if self._runs else None

    @property
    def task(self) -> asyncio.Task[int] | None:
        """Task that runs the launch, or None."""
        return self._task

    def _is_idle(self) -> bool:
        """Return whether no launch runs; ``launch``'s tests read it."""
        return not self._runs

    def emit_event(self, event: Event) -> None:
        """Emit an event, now or when the launch runs. Thread-safe."""
        emit(event, self._evaluation)

    def include_launch_description(self, launch_description: LaunchDescription) -> None:
        """Include a launch description, now or when the launch runs. Thread-safe."""
        self.emit_event(IncludeLaunchDescription(launch_description))

    def run(self, *, shutdown_when_idle: bool = True) -> int:
        """Run the launch until all processes have ended.

        Args:
            shutdown_when_idle: Whether it ends when nothing is left; else `shutdown` has to end it.

        Returns:
            As in ROS 2: 1 where the launch itself has failed, or a signal other than Ctrl-C has
            ended it, else 0.

        Raises:
            RuntimeError: It runs already, or this is not the main thread.
            TeleopctlError: The log folder cannot be made, or no router started.
        """
        if threading.current_thread() is not threading.main_thread():
            raise RuntimeError("LaunchService can only be run in the main thread.")
        return self._run(shutdown_when_idle)

    async def run_async(self, *, shutdown_when_idle: bool = True) -> int:
        """Run the launch in the current event loop; see `run`. Cancelling shuts it down."""
        import asyncio

        self._task, self._thread = asyncio.current_task(), threading.get_ident()
        running = self._in_thread(asyncio.get_running_loop(), shutdown_when_idle)
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            self.shutdown()
            await running
            raise
        finally:
            self._task = self._thread = None

    def _in_thread(
        self, loop: asyncio.AbstractEventLoop, shutdown_when_idle: bool
    ) -> asyncio.Future[int]:
        """Run the launch in a thread, which also ends with the program; return its result."""
        ended: asyncio.Future[int] = loop.create_future()

        def tell(error: BaseException | None, status: int) -> None:
            if ended.done():
                return
            if error is not None:
                ended.set_exception(error)
            else:
                ended.set_result(status)

        def run() -> None:
            error, status = None, 1
            try:
                status = self._run(shutdown_when_idle)
            except BaseException as raised:  # noqa: BLE001 -- raised where it is awaited
                error = raised
            with suppress(RuntimeError):  # the loop is closed, and no task awaits the result
                loop.call_soon_threadsafe(tell, error, status)

        # A daemon thread, so that a program whose loop ends first reaches `end`.
        thread = threading.Thread(target=run, name="launch", daemon=True)

        def end() -> None:
            if thread.is_alive():
                self.shutdown(force_sync=True)
                thread.join(_END_S)

        atexit.register(end)
        ended.add_done_callback(lambda _: atexit.unregister(end))
        thread.start()
        return ended

    def _run(self, shutdown_when_idle: bool) -> int:
        from teleopctl.launch import Supervisor, prepare

        with self._lock:
            if self._runs:
                raise RuntimeError("LaunchService cannot be run multiple times concurrently.")
            self._runs = True
        try:
            self._evaluation.is_ending = False
            start = self._evaluation.take_follow_up()
            if not shutdown_when_idle:
                start.works.append(self._stay)
            plan = LaunchPlan(log_directory=self._log_directory, start=start)
            prepare(plan)
            supervisor = Supervisor(plan, self._evaluation)
            supervisor.run()
            return supervisor.ros2_exit_status
        finally:
            self._evaluation.disconnect()
            self._context.end_loop()
            self._runs = False

    # Any, twice: what a coroutine may be sent and what it may yield.
    def shutdown(self, force_sync: bool = False) -> Coroutine[Any, Any, None] | None:
        """Shut the launch down, if it runs. Thread-safe.

        Args:
            force_sync: Whether to return None instead of an awaitable.

        Returns:
            What can be awaited or made a task of, in the event loop of `run_async`; nothing
            depends on that. Elsewhere None.
        """
        if self._runs:
            self._evaluation.shut_down("LaunchService.shutdown() called")
            if not force_sync and self._thread == threading.get_ident():
                return _Done()
        return None


class _Done(Coroutine[Any, Any, None]):
    """Completed coroutine, the return value of `shutdown`; awaiting it has no effect."""

    # Any, in what follows: what a coroutine is sent, raises and yields.
    def send(self, value: Any, /) -> Any:  # noqa: ARG002 -- the original's signature
        raise StopIteration

    def throw(self, *error: Any) -> Any:
        raise error[0]

    def close(self) -> None:
        """Do nothing: the coroutine is closed."""

    def __await__(self) -> Generator[Any, Any, None]:
        yield from ()


class _Stay:
    """Task that keeps a launch running until it is shut down."""

    def __init__(self) -> None:
        self._report: Callable[[TeleopctlError | None], None] | None = None

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Start the task."""
        self._report = report

    def end(self, *_: object) -> None:
        """End the task."""
        if self._report is not None:
            self._report(None)
            self._report = None
