"""Starts the processes of a plan, relays what they write, and stops them in order.

One thread decides: everything that happens reaches it through a queue, in the order in which it
happened. Ctrl-C becomes SIGINT for each process, SIGTERM after 5 s and SIGKILL after another 5 s.
"""

from __future__ import annotations

import heapq
import itertools
import os
import queue
import signal
import time
from collections.abc import Callable
from functools import partial
from types import FrameType

from teleopctl.background import Start, start_of
from teleopctl.errors import EXIT_INTERRUPTED
from teleopctl.launch.execution import status
from teleopctl.launch.execution.child import Child
from teleopctl.launch.execution.screen import Screen
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.launch.execution.terminal import Terminal
from teleopctl.launch.model.plan import LaunchPlan

_LAUNCH = "launch"
# Windows lets no signal handler run while the main thread waits without end.
_LONGEST_WAIT_S = 0.2 if os.name == "nt" else None
# Signals that come in one bunch, as from `timeout`, are one request to end.
_SAME_REQUEST_S = 1.0
# When to write the status file again that could not be written.
_TRY_AGAIN_AFTER_S = 1.0
# A process says in a file that it is ready.
_LOOK_EVERY_S = 0.02
_STEPS = (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGKILL", signal.SIGTERM))


class Supervisor:
    """Carries out one plan.

    Args:
        plan: What to start; its log folder and files have been written.
        in_background: Whether the launch's own lines go to the log of the background process
            alone.
        terminal: How the output looks where a person sees it; None writes ROS 2's text.
    """

    def __init__(
        self,
        plan: LaunchPlan,
        *,
        in_background: bool = False,
        terminal: Terminal | None = None,
    ) -> None:
        self._plan = plan
        # SimpleQueue may be filled from a signal handler, other queues may not.
        self._events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._timer_ids = itertools.count()
        log_file = None if in_background else plan.log_directory / "launch.log"
        self._screen = Screen(log_file, terminal)
        self._children = [
            Child(
                process,
                plan.log_directory / f"{process.name}.log",
                self._screen,
                lambda child: self._events.put(lambda: self._exited(child)),
            )
            for process in plan.processes
        ]
        # Those of which something is still to come, and of these those whose process was started.
        self._expected = set(range(len(self._children)))
        self._live: set[int] = set()
        self._others_were_started = False
        self._companions = {
            index for index, process in enumerate(plan.processes) if process.accompanies
        }
        self._starts: dict[int, Start] = {}
        self._status_is_late = False
        self._shutting_down = False
        self._interrupted = False
        self._step = 0
        self._asked_at = 0.0
        self._died = False

    def statuses(self) -> list[ProcessStatus]:
        """What became of the processes so far; any thread may ask."""
        return [
            status.status_of(child, self._starts.get(index, Start()))
            for index, child in enumerate(self._children)
        ]

    def tell(self, level: str, text: str) -> None:
        """Show a line of the launch's own; any thread may call this. An error makes it fail."""
        self._events.put(lambda: self._told(level, text))

    def _told(self, level: str, text: str) -> None:
        self._died = self._died or level == "ERROR"
        if not self._shutting_down:
            self._say(level, text)

    def run(self) -> int:
        """Run until every process has ended.

        Returns:
            The exit status: 130 after Ctrl-C, 1 when a process died, otherwise 0.
        """
        handled = [signal.SIGINT, signal.SIGTERM]
        if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
            # Whoever began with `nohup` wants the launch to outlive the terminal.
            handled.append(signal.SIGHUP)
        previous = {number: signal.signal(number, self._on_signal) for number in handled}
        try:
            self._start()
            while self._expected:
                self._handle_next()
        except BaseException:
            # Nobody else would end them.
            for child in self._children:
                child.signal(_STEPS[-1])
            raise
        finally:
            for number, handler in previous.items():
                signal.signal(number, handler)
            self._screen.close()
        if self._interrupted:
            return EXIT_INTERRUPTED
        return 1 if self._died else 0

    def _start(self) -> None:
        self._say("INFO", f"All log files can be found below {self._plan.log_directory}")
        self._say("INFO", "Default logging verbosity is set to INFO")
        for warning in self._plan.warnings:
            self._say("WARNING", warning)
        for level, message in self._plan.messages:
            self._screen.say(level, "launch.user", message)
        self._publish_status()  # of a launch that starts nothing, too
        for index in sorted(self._companions):
            self._start_child(index)
        self._start_others()

    def _start_others(self) -> None:
        """Start what companions are to see from its first word on, once they are ready for it."""
        if self._shutting_down:
            return
        if not all(self._children[index].is_ready for index in self._companions):
            self._after(_LOOK_EVERY_S, self._start_others)
            return
        self._others_were_started = True
        for index, child in enumerate(self._children):
            if index in self._companions:
                continue
            if child.plan.start_delay > 0:
                self._after(child.plan.start_delay, partial(self._start_child, index))
            else:
                self._start_child(index)

    def _start_child(self, index: int) -> None:
        child = self._children[index]
        if self._shutting_down:
            self._expected.discard(index)
            return
        try:
            child.start()
        except (OSError, ValueError) as error:
            self._died = True
            self._expected.discard(index)
            reason = str(error)
            if isinstance(error, OSError) and error.strerror:
                named = f": {error.filename}" if error.filename else ""
                reason = f"{error.strerror}{named}"
            self._screen.say("ERROR", child.plan.name, f"process failed to start: {reason}")
            if child.plan.shutdown_on_exit:
                self._required_ended(child)
            self._lost_before_the_others(index)
        else:
            self._screen.say("INFO", child.plan.name, f"process started with pid [{child.pid}]")
            child.attend()
            self._live.add(index)
            if child.pid is not None:
                self._starts[index] = start_of(child.pid)
        self._publish_status()

    def _exited(self, child: Child) -> None:
        index = self._children.index(child)
        self._live.discard(index)
        if child.ended_well:
            self._screen.say(
                "INFO", child.plan.name, f"process has finished cleanly [pid {child.pid}]"
            )
        else:
            self._died = True
            self._screen.say(
                "ERROR",
                child.plan.name,
                f"process has died [pid {child.pid}, exit code {child.exit_status}, "
                f"cmd '{' '.join(child.plan.command)}'].",
            )
        if self._respawns(child):
            child.retries += 1
            self._after(child.plan.respawn_delay, partial(self._start_child, index))
        else:
            self._expected.discard(index)
            if child.plan.shutdown_on_exit and not self._shutting_down:
                self._required_ended(child)
            self._lost_before_the_others(index)
        self._end_companions()
        self._publish_status()

    def _lost_before_the_others(self, index: int) -> None:
        """Start nothing that somebody wants to be accompanied and that cannot be."""
        if index in self._companions and not self._others_were_started:
            self._shut_down()

    def _end_companions(self) -> None:
        """Ask those that accompany the others to end, once there is nobody left to accompany."""
        if self._expected <= self._companions:
            for index in sorted(self._companions & self._live):
                self._ask_to_end(self._children[index])

    def _respawns(self, child: Child) -> bool:
        plan = child.plan
        if not plan.respawn or self._shutting_down:
            return False
        if 0 <= plan.respawn_max_retries <= child.retries:
            return False
        return not status.is_marked_stopped(self._plan.log_directory, plan.name)

    def _required_ended(self, child: Child) -> None:
        self._say("INFO", f"process[{child.plan.name}] was required: shutting down launched system")
        self._shut_down()

    def _on_signal(self, number: int, _: FrameType | None) -> None:
        self._events.put(lambda: self._signalled(signal.Signals(number)))

    def _signalled(self, number: signal.Signals) -> None:
        reason = "user interrupted with ctrl-c (SIGINT)"
        if number == signal.SIGINT:
            self._interrupted = True
        else:
            reason = f"asked to end by {number.name}"
        now = time.monotonic()
        if not self._shutting_down:
            self._asked_at = now
            self._say("WARNING", reason)
            self._shut_down()
        elif now - self._asked_at < _SAME_REQUEST_S:
            return
        elif self._step + 1 < len(_STEPS):
            # Whoever asks again does not want to wait for the deadlines.
            self._step += 1
            self._say("WARNING", f"{reason} again, sending {_STEPS[self._step].name}")
            for child in self._children:
                child.signal(_STEPS[self._step])

    def _shut_down(self) -> None:
        """Ask every process to end, and arrange for harder ways."""
        if self._shutting_down:
            return
        self._shutting_down = True
        # What waits for its start, or for its next one, is not started any more.
        self._expected &= self._live
        for index in sorted(self._live - self._companions):
            self._ask_to_end(self._children[index])
        self._end_companions()
        self._publish_status()

    def _ask_to_end(self, child: Child) -> None:
        if not child.was_signalled:
            child.signal(_STEPS[0])
            self._after(child.plan.sigterm_timeout, partial(self._escalate, child, 1))

    def _escalate(self, child: Child, step: int) -> None:
        if not child.is_running:
            return
        waited = child.plan.sigterm_timeout if step == 1 else child.plan.sigkill_timeout
        self._screen.say(
            "ERROR",
            child.plan.name,
            f"process[{child.plan.name}] failed to terminate '{waited:g}' seconds after receiving "
            f"'{_STEPS[step - 1].name}', escalating to '{_STEPS[step].name}'",
        )
        child.signal(_STEPS[step])
        if step + 1 < len(_STEPS):
            self._after(child.plan.sigkill_timeout, partial(self._escalate, child, step + 1))

    def _handle_next(self) -> None:
        """Wait for the next event or timer and handle it."""
        timeout = _LONGEST_WAIT_S
        if self._timers:
            left = max(0.0, self._timers[0][0] - time.monotonic())
            timeout = left if timeout is None else min(left, timeout)
        try:
            event = self._events.get(timeout=timeout)
        except queue.Empty:
            while self._timers and self._timers[0][0] <= time.monotonic():
                heapq.heappop(self._timers)[2]()
        else:
            event()

    def _after(self, seconds: float, action: Callable[[], None]) -> None:
        heapq.heappush(self._timers, (time.monotonic() + seconds, next(self._timer_ids), action))

    def _say(self, level: str, text: str) -> None:
        self._screen.say(level, _LAUNCH, text)

    def _publish_status(self) -> None:
        try:
            status.write(self._plan.log_directory, self.statuses())
        except OSError:
            # A full disk, or on Windows a reader: no reason to end what runs.
            if not self._status_is_late:
                self._status_is_late = True
                self._after(_TRY_AGAIN_AFTER_S, self._publish_late_status)

    def _publish_late_status(self) -> None:
        self._status_is_late = False
        self._publish_status()
