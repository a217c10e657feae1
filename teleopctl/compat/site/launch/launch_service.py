"""``launch.launch_service``."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Coroutine, Generator, Iterable
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


class LaunchService:
    """Launches descriptions from a program of one's own.

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
        """What the descriptions are evaluated with."""
        return self._context

    @property
    def event_loop(self) -> asyncio.AbstractEventLoop | None:
        """The event loop of the launch's coroutines; None where nothing runs."""
        return self._context.asyncio_loop if self._runs else None

    @property
    def task(self) -> asyncio.Task[int] | None:
        """The task that runs the launch, where one does."""
        return self._task

    def _is_idle(self) -> bool:
        """Tell whether nothing goes on; tests of what a launch has left ask for that."""
        return not self._runs

    def emit_event(self, event: Event) -> None:
        """Make an event happen, at once or when the launch runs; any thread may do this."""
        emit(event, self._evaluation)

    def include_launch_description(self, launch_description: LaunchDescription) -> None:
        """Launch a description, at once or when the launch runs; any thread may do this."""
        self.emit_event(IncludeLaunchDescription(launch_description))

    def run(self, *, shutdown_when_idle: bool = True) -> int:
        """Launch, and return when everything has ended.

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
        """Launch beside other tasks; see `run`. A cancelled task ends the launch."""
        import asyncio

        self._task, self._thread = asyncio.current_task(), threading.get_ident()
        loop = asyncio.get_running_loop()
        running = loop.run_in_executor(None, self._run, shutdown_when_idle)
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            self.shutdown()
            await running
            raise
        finally:
            self._task = self._thread = None

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
        """End the launch, where it runs; any thread may do this.

        Args:
            force_sync: Whether nothing is wanted that could be awaited.

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
    """A coroutine that is at its end, and that nobody need await."""

    # Any, in what follows: what a coroutine is sent, raises and yields.
    def send(self, value: Any, /) -> Any:  # noqa: ARG002 -- the original's signature
        raise StopIteration

    def throw(self, *error: Any) -> Any:
        raise error[0]

    def close(self) -> None:
        """Do nothing: it is closed."""

    def __await__(self) -> Generator[Any, Any, None]:
        yield from ()


class _Stay:
    """What goes on until the launch is told to end."""

    def __init__(self) -> None:
        self._report: Callable[[TeleopctlError | None], None] | None = None

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Go on."""
        self._report = report

    def end(self, *_: object) -> None:
        """End."""
        if self._report is not None:
            self._report(None)
            self._report = None
