"""How processes are made to end: SIGINT, then SIGTERM, then SIGKILL."""

from __future__ import annotations

import signal
from functools import partial

from teleopctl.launch.execution.child import Child
from teleopctl.launch.execution.event_loop import EventLoop
from teleopctl.launch.execution.screen import Screen
from teleopctl.launch.model.plan import SignalPlan

STEPS = (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGKILL", signal.SIGTERM))
"""The signals, each harder than the one before."""


class Ending:
    """Ends processes by signals of increasing force.

    Args:
        loop: The loop on which this is called.
        screen: Where it is said that harder ways are needed.
    """

    def __init__(self, loop: EventLoop, screen: Screen) -> None:
        self._loop = loop
        self._screen = screen

    def ask(self, child: Child) -> None:
        """Send a process SIGINT, and SIGTERM and SIGKILL if it does not end in time."""
        if not child.was_signalled:
            child.signal(STEPS[0])
            self._loop.after(
                child.plan.sigterm_timeout, partial(self._escalate, child, child.pid, 1)
            )

    def _escalate(self, child: Child, pid: int | None, step: int) -> None:
        if not child.is_running or child.pid != pid:
            return  # or it has been started again since
        waited = child.plan.sigterm_timeout if step == 1 else child.plan.sigkill_timeout
        self._screen.say(
            "ERROR",
            child.plan.name,
            f"process[{child.plan.name}] failed to terminate '{waited:g}' seconds after receiving "
            f"'{STEPS[step - 1].name}', escalating to '{STEPS[step].name}'",
        )
        child.signal(STEPS[step])
        if step + 1 < len(STEPS):
            harder = partial(self._escalate, child, pid, step + 1)
            self._loop.after(child.plan.sigkill_timeout, harder)

    def send(self, request: SignalPlan, child: Child) -> None:
        """Send a process the signal that an event requests."""
        if request.number is None:
            self.ask(child)
            return
        number = signal.Signals(request.number)
        name = child.plan.name
        self._screen.say("INFO", name, f"sending signal '{number.name}' to process[{name}]")
        child.signal(number)
