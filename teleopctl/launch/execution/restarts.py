"""Restarts of a launch's processes after a change of their source files (``launch --watch``)."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from teleopctl.base.typed import Callable, Iterable, Protocol
from teleopctl.launch.execution import status
from teleopctl.launch.execution.child import Child
from teleopctl.launch.execution.event_loop import EventLoop
from teleopctl.launch.execution.screen import Screen
from teleopctl.launch.execution.termination import LaunchSignals, ProcessTerminator
from teleopctl.launch.model.plan import ProcessPlan

_LAUNCH = "launch"


class Watcher(Protocol):
    """Interface of a watcher that restarts processes when their source files are saved."""

    def watch_sources(self, plans: Iterable[ProcessPlan]) -> None:
        """Watch the source files of further processes."""


class Restarts:
    """Manager of the restarts of a launch's processes after changes of their source files.

    Neither ``respawn`` nor ``on_exit`` nor a handler of the launch file responds to a restart. A
    process that dies after a restart waits for the next save, since the last one may have broken
    its program.

    Args:
        children: Processes of the launch; the caller may append to this list.
        folder: Log folder of the launch.
        loop: Event loop on whose thread all methods except `call` are called.
        screen: Screen on which events are logged.
        interrupts: Signal handlers of the launch.
        terminator: Terminator of processes.
        start: Function that starts a process.
    """

    def __init__(
        self,
        children: list[Child],
        folder: Path,
        *,
        loop: EventLoop,
        screen: Screen,
        interrupts: LaunchSignals,
        terminator: ProcessTerminator,
        start: Callable[[Child], None],
    ) -> None:
        self._children = children
        self._folder = folder
        self._loop = loop
        self._screen = screen
        self._interrupts = interrupts
        self._terminator = terminator
        self._start = start
        self._watcher: Watcher | None = None
        # Processes that are terminated for a restart, with their new plans; those restarted so far.
        self._due: dict[Child, ProcessPlan] = {}
        self._made: set[Child] = set()
        self._said_what_it_waits_for = False

    def watch(self, watcher: Watcher) -> None:
        """Start to watch the processes' source files; the launch then runs until a shutdown."""
        self._watcher = watcher
        self.watch_sources(self.plans())

    def watch_sources(self, plans: Iterable[ProcessPlan]) -> None:
        """Watch the source files of further processes, if source files are watched."""
        if self._watcher is not None:
            self._watcher.watch_sources(plans)

    def close(self) -> None:
        """Stop watching and restarting, because the launch shuts down."""
        self._watcher = None
        self._due.clear()
        self._made.clear()

    def call(self, function: Callable[[], None]) -> None:
        """Call a function on the event loop, unless the launch shuts down; thread-safe."""
        self._loop.put(lambda: None if self._watcher is None else function())

    def log(self, level: str, text: str) -> None:
        """Log a line in the launch's name."""
        self._screen.log(level, _LAUNCH, text)

    def evaluating(self) -> AbstractContextManager[None]:
        """Return a context for launch file code, which a signal ends early without an exception."""
        return self._interrupts.interruptible()

    def plans(self) -> list[ProcessPlan]:
        """Return the plans of all processes of the launch."""
        return [child.plan for child in self._children]

    def restart(self, plan: ProcessPlan) -> None:
        """Restart the process of the plan's name with that plan, unless stopped by the user.

        A process that has ended is started; a process that the user has stopped is not.
        """
        child = next(child for child in self._children if child.plan.name == plan.name)
        if status.is_marked_stopped(self._folder, plan.name):
            return
        if child.is_running:
            self._due[child] = plan
            self._terminator.terminate(child)
        else:
            self._begin(child, plan)

    def restart_ended(self, child: Child) -> bool:
        """Start a process again if it was terminated for a restart; return False if it was not."""
        plan = self._due.pop(child, None)
        if plan is None:
            return False
        self._begin(child, plan)
        return True

    def waits_for_save(self, child: Child) -> bool:
        """Return whether a died process was restarted before, so waits for a save; log it if so."""
        if child not in self._made:
            return False
        self.log("INFO", f"{child.plan.name} waits for the next save")
        return True

    def keeps_launch_alive(self) -> bool:
        """Return whether file watching keeps a launch without processes alive; log that once."""
        if self._watcher is None:
            return False
        if not self._said_what_it_waits_for:
            self._said_what_it_waits_for = True
            self.log(
                "INFO", "all processes have ended; saved ones start again, Ctrl-C ends the launch"
            )
        return True

    def _begin(self, child: Child, plan: ProcessPlan) -> None:
        child.plan = plan
        self._made.add(child)
        self._said_what_it_waits_for = False
        self._start(child)
