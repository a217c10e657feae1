"""Termination of a launch: signals that it receives, and those that it sends to its processes."""

from __future__ import annotations

import signal
import threading
import time
from contextlib import contextmanager
from functools import partial
from types import FrameType

from teleopctl.base.interrupts import wake_on_signals
from teleopctl.base.typed import Callable, Iterator
from teleopctl.launch.execution.child import Child
from teleopctl.launch.execution.event_loop import EventLoop
from teleopctl.launch.execution.screen import Screen
from teleopctl.launch.model.plan import SignalPlan

STEPS = (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGKILL", signal.SIGTERM))
"""Signals that end a process, each harder than the one before."""


class ProcessTerminator:
    """Terminator of child processes: SIGINT, and after timeouts SIGTERM and SIGKILL.

    Args:
        loop: Event loop on whose thread the methods are called.
        screen: Screen on which escalations to harder signals are logged.
    """

    def __init__(self, loop: EventLoop, screen: Screen) -> None:
        self._loop = loop
        self._screen = screen

    def terminate(self, child: Child) -> None:
        """Send SIGINT to a process not signalled yet; if it still runs, SIGTERM, then SIGKILL."""
        if not child.was_signalled:
            child.signal(STEPS[0])
            self._loop.after(
                child.plan.sigterm_timeout, partial(self._escalate, child, child.pid, 1)
            )

    def _escalate(self, child: Child, pid: int | None, step: int) -> None:
        if not child.is_running or child.pid != pid:
            return  # the process has ended, or was restarted since
        waited = child.plan.sigterm_timeout if step == 1 else child.plan.sigkill_timeout
        self._screen.log(
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
        """Send a process the requested signal; without a signal number, terminate the process."""
        if request.number is None:
            self.terminate(child)
            return
        number = signal.Signals(request.number)
        name = child.plan.name
        self._screen.log("INFO", name, f"sending signal '{number.name}' to process[{name}]")
        child.signal(number)


# Signals within this time, in seconds, are one request to end, as from `timeout`.
_SAME_REQUEST_S = 1.0


class LaunchSignals:
    """Handlers of SIGINT, SIGTERM, SIGHUP: end the launch; repeated, send SIGTERM, then SIGKILL.

    Args:
        loop: Event loop on whose thread the functions below are called.
        end: Called with the reason and whether the signal was Ctrl-C; returns False if the launch
            is already shutting down.
        hurry: Called on a repeated signal, with a reason and the harder signal to send to the
            processes before the timeouts.

    Attributes:
        first: First signal that was received, or None.
    """

    def __init__(
        self,
        loop: EventLoop,
        end: Callable[[str, bool], bool],
        hurry: Callable[[str, signal.Signals], None],
    ) -> None:
        self.first: signal.Signals | None = None
        self._loop = loop
        self._end = end
        self._hurry = hurry
        self._step = 0
        self._requested_at = 0.0
        # Whether code of a launch file may be running.
        self._is_interruptible = False

    @contextmanager
    def handling(self) -> Iterator[None]:
        """Install the signal handlers for the ``with`` block, if this is the main thread."""
        numbers = [signal.SIGINT, signal.SIGTERM]
        if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
            # Under `nohup` the launch outlives the terminal.
            numbers.append(signal.SIGHUP)
        if threading.current_thread() is threading.main_thread():
            wake_on_signals()
        else:
            numbers.clear()  # only the main thread may set signal handlers
        previous = {number: signal.signal(number, self._on_signal) for number in numbers}
        try:
            yield
        finally:
            for number, before in previous.items():
                signal.signal(number, before)

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let a signal end the ``with`` block of launch file code early, without an exception."""
        try:
            self._is_interruptible = True
            yield
        except KeyboardInterrupt:
            pass  # raised by the handler, which has queued the request
        finally:
            self._is_interruptible = False

    def _on_signal(self, number: int, _: FrameType | None) -> None:
        self._loop.put(lambda: self._handle_signal(signal.Signals(number)))
        if self._is_interruptible:
            self._is_interruptible = False
            raise KeyboardInterrupt

    def _handle_signal(self, number: signal.Signals) -> None:
        is_interrupt = number == signal.SIGINT
        reason = f"asked to end by {number.name}"
        if is_interrupt:
            reason = "user interrupted with ctrl-c (SIGINT)"
        self.first = self.first or number
        now = time.monotonic()
        if self._end(reason, is_interrupt):
            self._requested_at = now
        elif now - self._requested_at >= _SAME_REQUEST_S and self._step + 1 < len(STEPS):
            self._step += 1
            self._hurry(f"{reason} again, sending {STEPS[self._step].name}", STEPS[self._step])
