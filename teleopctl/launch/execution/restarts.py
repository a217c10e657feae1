"""Processes that are started again because what they are made from was saved."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from teleopctl.launch.execution import status
from teleopctl.launch.execution.child import Child
from teleopctl.launch.execution.event_loop import EventLoop
from teleopctl.launch.execution.screen import Screen
from teleopctl.launch.execution.termination import Ending, Interrupts
from teleopctl.launch.model.plan import ProcessPlan

_LAUNCH = "launch"


class Watcher(Protocol):
    """Interface of the watcher that requests restarts when sources are saved."""

    def take_in(self, plans: Iterable[ProcessPlan]) -> None:
        """Watch the source files of further processes."""


class Restarts:
    """Restarts processes without exit events, so that ``respawn`` and handlers do not act.

    So neither ``respawn`` nor ``on_exit`` nor a handler of the launch file answers a restart. What
    dies after one waits for the next save, since the last one may have broken it.

    Args:
        children: The processes of the launch, which become more.
        folder: The launch's log folder.
        loop: The loop on which all this is called, but for `call`.
        screen: Where it is said what happens.
        interrupts: The signals that end the launch.
        ending: Makes processes end.
        start: Starts one.
    """

    def __init__(
        self,
        children: list[Child],
        folder: Path,
        *,
        loop: EventLoop,
        screen: Screen,
        interrupts: Interrupts,
        ending: Ending,
        start: Callable[[Child], None],
    ) -> None:
        self._children = children
        self._folder = folder
        self._loop = loop
        self._screen = screen
        self._interrupts = interrupts
        self._ending = ending
        self._start = start
        self._watcher: Watcher | None = None
        # What is ending, with what comes in its place, and what has come so.
        self._due: dict[Child, ProcessPlan] = {}
        self._made: set[Child] = set()
        self._said_what_it_waits_for = False

    def watch(self, watcher: Watcher) -> None:
        """Watch the processes' source files; the launch then does not end by itself."""
        self._watcher = watcher
        self.take_in(self.plans())

    def take_in(self, plans: Iterable[ProcessPlan]) -> None:
        """Watch the source files of further processes."""
        if self._watcher is not None:
            self._watcher.take_in(plans)

    def close(self) -> None:
        """Stop restarting, because the launch ends."""
        self._watcher = None
        self._due.clear()
        self._made.clear()

    def call(self, function: Callable[[], None]) -> None:
        """Call a function on the event loop while the launch runs; any thread may call this."""
        self._loop.put(lambda: None if self._watcher is None else function())

    def say(self, level: str, text: str) -> None:
        """Log a line in the launch's name."""
        self._screen.say(level, _LAUNCH, text)

    def evaluating(self) -> AbstractContextManager[None]:
        """Allow a signal to leave the block, in which a launch file's own code runs."""
        return self._interrupts.stopping_what_takes_long()

    def plans(self) -> list[ProcessPlan]:
        """Return the plans of the launch's processes."""
        return [child.plan for child in self._children]

    def restart(self, plan: ProcessPlan) -> None:
        """Restart a process with a new plan.

        One that has ended is started, one that a person has stopped stays so.
        """
        child = next(child for child in self._children if child.plan.name == plan.name)
        if status.is_marked_stopped(self._folder, plan.name):
            return
        if child.is_running:
            self._due[child] = plan
            self._ending.ask(child)
        else:
            self._begin(child, plan)

    def answers_end_of(self, child: Child) -> bool:
        """Start a process again if it ended for a restart; return whether that is so."""
        plan = self._due.pop(child, None)
        if plan is None:
            return False
        self._begin(child, plan)
        return True

    def keeps_dead(self, child: Child) -> bool:
        """Return whether a dead process waits for the next save."""
        if child not in self._made:
            return False
        self.say("INFO", f"{child.plan.name} waits for the next save")
        return True

    def keep_launch(self) -> bool:
        """Return whether the launch continues, to wait for saved sources, with no process left."""
        if self._watcher is None:
            return False
        if not self._said_what_it_waits_for:
            self._said_what_it_waits_for = True
            self.say("INFO", "everything has ended; what is saved starts again, Ctrl-C ends this")
        return True

    def _begin(self, child: Child, plan: ProcessPlan) -> None:
        child.plan = plan
        self._made.add(child)
        self._said_what_it_waits_for = False
        self._start(child)
