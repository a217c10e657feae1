"""Supervisor of a launch: starts processes, relays their output, handles events, shuts down.

One thread handles all events, which a queue delivers in the order in which they happened. On
Ctrl-C, each process receives SIGINT, SIGTERM after 5 s and SIGKILL after another 5 s.
"""

from __future__ import annotations

import signal
import time
from functools import partial

from teleopctl.base.background import StartTime, start_time_of
from teleopctl.base.typed import Callable
from teleopctl.errors import TeleopctlError
from teleopctl.launch.execution import status
from teleopctl.launch.execution.child import Child, start_error_text
from teleopctl.launch.execution.event_loop import EventLoop, Timers
from teleopctl.launch.execution.restarts import Restarts
from teleopctl.launch.execution.screen import Screen, in_short
from teleopctl.launch.execution.standby import StandbyProcess
from teleopctl.launch.execution.status import ProcessStatus, StatusWriter
from teleopctl.launch.execution.termination import STEPS, LaunchSignals, ProcessTerminator
from teleopctl.launch.model.events import (
    ProcessExited,
    ProcessOutput,
    ProcessStarted,
    ShutdownBegan,
)
from teleopctl.launch.model.plan import (
    REQUIRED,
    FollowUp,
    LaunchPlan,
    LaunchTimer,
    ProcessPlan,
    Respondent,
)
from teleopctl.launch.model.records import replace

_LAUNCH = "launch"
# Interval at which the progress files of companions and simulators are read.
_LOOK_EVERY_S = 0.02
# Longest time for which processes give way to a simulator, which may compile a model for minutes.
_GIVE_WAY_S = 1.5


class Supervisor:
    """Runner of a launch plan: starts processes, handles events, and shuts down at the end.

    Args:
        plan: Plan of the launch, whose log folder and files have been written.
        respondent: Evaluation that handles events; None if no events are handled.
        in_background: Whether stdout is the log of a background process, so that no other log file
            is written.
        coloured: Whether levels and process names are coloured on the screen.
        is_terse: Whether the screen gets only warnings and errors of quiet processes.
        debug: Whether to log all events.
        log_name: Name of the log file with all output, without its suffix.
        standby: Process that waits for its arguments, for the first plan that it fits.

    Attributes:
        restarts: Restarts of processes whose sources are saved, if the launch watches sources.
    """

    def __init__(
        self,
        plan: LaunchPlan,
        respondent: Respondent | None = None,
        *,
        in_background: bool = False,
        coloured: bool = False,
        is_terse: bool = False,
        debug: bool = False,
        log_name: str = "launch",
        standby: StandbyProcess | None = None,
    ) -> None:
        self._debug = debug
        self._standby = standby
        self._plan = plan
        self._respondent = respondent
        self._loop = EventLoop()
        self._published = StatusWriter(plan.log_directory, self._loop, self)
        self._timers = Timers(
            self._loop, self._published.publish, self._timer_fired, self._work_ended
        )
        log_file = None if in_background else plan.log_directory / f"{log_name}.log"
        self._screen = Screen(log_file, coloured=coloured, is_terse=is_terse)
        self._terminator = ProcessTerminator(self._loop, self._screen)
        self._interrupts = LaunchSignals(self._loop, self._shutdown_requested, self._send_to_all)
        self._children: list[Child] = []
        self.restarts = Restarts(
            self._children,
            plan.log_directory,
            loop=self._loop,
            screen=self._screen,
            interrupts=self._interrupts,
            terminator=self._terminator,
            start=self._start_again,
        )
        # Indices of processes that run or will be started; those that run; recorders and such.
        self._expected: set[int] = set()
        self._live: set[int] = set()
        self._companions: set[int] = set()
        for process in plan.processes:
            self._add(process)
        self._others_were_started = False
        self._starts: dict[int, StartTime] = {}
        if respondent is not None:
            respondent.connect(lambda event: self._loop.put(partial(self._respond, event)))
        self._shutting_down = self._tells_shutdown = False
        # Whether anything failed, and whether the launch itself failed, not only a process.
        self._failed = self._failed_itself = False

    def statuses(self) -> list[ProcessStatus]:
        """Return the state of each process of the launch; any thread may call this."""
        return [
            status.status_of(child, self._starts.get(index, StartTime()))
            for index, child in enumerate(tuple(self._children))
        ]

    def pending(self) -> int:
        """Return the number of running service calls plus that of timers due within 30 s."""
        return self._timers.pending()

    def log(self, level: str, text: str, shown: str | None = None) -> None:
        """Log a line unless the launch shuts down; ERROR makes its exit status 1; thread-safe.

        Args:
            level: Log level, such as ``INFO``.
            text: Message for the log.
            shown: Message for the screen, such as an address with its token; by default ``text``.
        """
        self._loop.put(lambda: self._log_now(level, text, shown))

    def _log_now(self, level: str, text: str, shown: str | None) -> None:
        self._failed = self._failed or level == "ERROR"
        if not self._shutting_down:
            self._say(level, text, shown=shown)

    def run(self) -> int:
        """Run the launch until every process has ended, and return the exit status.

        Returns:
            1 when a process died or the launch failed; 128 plus the number of the signal that ended
            the launch, such as 130 after Ctrl-C; otherwise 0.
        """
        try:
            with self._interrupts.handling():
                self._start()
                while self._has_work() or self._becomes_idle():
                    self._loop.handle_next()
        except BaseException:
            # Otherwise the processes would outlive the launch.
            for child in self._children:
                child.signal(STEPS[-1])
            raise
        finally:
            self._screen.close()
        if self._failed:
            return 1
        ended_by = self._interrupts.first
        return 0 if ended_by is None else 128 + ended_by

    @property
    def ros2_exit_status(self) -> int:
        """Exit status as of ``ros2 launch``: 1 after a launch error or a signal but SIGINT, else 0.

        A process that died does not count.
        """
        was_ended = self._interrupts.first not in (None, signal.SIGINT)
        return int(self._failed_itself or was_ended)

    def _start(self) -> None:
        self._say("INFO", f"All log files can be found below {self._plan.log_directory}")
        verbosity = "DEBUG" if self._debug else "INFO"
        self._screen.log(
            "INFO",
            _LAUNCH,
            f"Default logging verbosity is set to {verbosity}",
            is_detail=all(process.is_quiet for process in self._plan.processes),
        )
        for warning in self._plan.warnings:
            self._say("WARNING", warning)
        self._show(self._plan.start)
        self._published.publish()  # also for a launch without processes
        for index in sorted(self._companions):
            self._start_child(index)
        self._start_others()

    def _add(self, process: ProcessPlan) -> int:
        """Add a process to the launch, and return its index."""
        index = len(self._children)
        log_file = self._plan.log_directory / f"{process.name}.log"
        self._children.append(
            Child(
                process,
                log_file,
                self._screen,
                lambda child: self._loop.put(lambda: self._exited(child)),
                self._output_written,
            )
        )
        self._expected.add(index)
        if process.accompanies:
            self._companions.add(index)
        return index

    def _has_work(self) -> bool:
        return bool(self._expected or self._timers) or self.restarts.keeps_launch_alive()

    def _becomes_idle(self) -> bool:
        """Begin the shutdown of a launch without work; return whether that queued more work."""
        if self._loop.is_empty and not self._shutting_down:
            self._shut_down("idle")
        return not self._loop.is_empty

    def _start_others(self) -> None:
        """Start all other processes once the companions, such as a recorder, are ready."""
        if self._shutting_down:
            return
        if not all(self._children[index].is_ready for index in self._companions):
            self._loop.after(_LOOK_EVERY_S, self._start_others)
            return
        self._others_were_started = True
        others = [index for index in range(len(self._children)) if index not in self._companions]
        simulators = [index for index in others if self._children[index].plan.simulates]
        later = [index for index in others if simulators and self._children[index].plan.gives_way]
        for index in others:
            if index not in later:
                self._start_child(index)
        if self._standby is not None:
            self._standby.close()
        self._execute(replace(self._plan.start, messages=[], files={}, processes=[]))
        self._start_later(later, simulators, time.monotonic() + _GIVE_WAY_S)

    def _start_later(self, indices: list[int], simulators: list[int], latest_s: float) -> None:
        """Start processes once no simulator starts any more, or at a time of the monotonic clock.

        Five interpreters on two cores: processes that only display it would double the time
        until there is one.
        """
        is_starting = any(self._children[index].is_starting for index in simulators)
        if indices and is_starting and time.monotonic() < latest_s and not self._shutting_down:
            self._loop.after(
                _LOOK_EVERY_S, partial(self._start_later, indices, simulators, latest_s)
            )
            return
        for index in indices:
            self._start_child(index)

    def _start_again(self, child: Child) -> None:
        index = self._children.index(child)
        self._expected.add(index)
        self._start_child(index, was_saved=True)

    def _start_child(self, index: int, *, was_saved: bool = False) -> None:
        child = self._children[index]
        if self._shutting_down:
            self._expected.discard(index)
            return
        if child.is_running:
            return  # restarted after a save while it waited for its respawn
        try:
            child.start(self._standby)
        except (OSError, ValueError) as error:
            self._failed = True
            self._expected.discard(index)
            text = f"process failed to start: {start_error_text(error)}"
            self._screen.log("ERROR", child.plan.name, text)
            if child.plan.shutdown_on_exit:
                self._required_ended(child)
            self._companion_lost(index)
        else:
            self._screen.log("INFO", child.plan.name, f"process started with pid [{child.pid}]")
            child.relay_output()
            self._live.add(index)
            assert child.pid is not None
            self._starts[index] = start_time_of(child.pid)
            self._respond(ProcessStarted(child.plan, child.pid, was_saved))
        self._published.publish()

    def _output_written(self, child: Child, line: bytes, is_stdout: bool) -> None:
        """Queue an output event, if a handler takes these; called on the threads of the process."""
        if self._respondent is not None and self._respondent.wants_output:
            event = ProcessOutput(child.plan, child.pid or 0, line, is_stdout)
            self._loop.put(lambda: self._respond(event))

    def _respond(self, event: object) -> None:
        if self._debug:
            self._say("DEBUG", f"processing event: '{event}'")
        if self._respondent is not None:
            self._execute_follow_up(partial(self._respondent.handle_event, event))

    def _timer_fired(self, timer: LaunchTimer) -> None:
        if self._respondent is not None:
            self._execute_follow_up(partial(self._respondent.handle_timer, timer))
        self._end_companions()
        self._published.publish()

    def _work_ended(self, error: TeleopctlError | None) -> None:
        if error is not None:
            self._fail(str(error))
        self._end_companions()

    def _execute_follow_up(self, ask: Callable[[], FollowUp]) -> None:
        follow_up = None
        try:
            with self._interrupts.interruptible():
                follow_up = ask()
        except TeleopctlError as error:
            self._fail(str(error))
        if follow_up is not None:
            self._execute(follow_up)

    def _fail(self, text: str) -> None:
        self._failed = self._failed_itself = True
        self._say("ERROR", f"Caught exception in launch: {text}")
        self._shut_down(text)

    def _show(self, follow_up: FollowUp) -> None:
        for level, logger, message in follow_up.messages:
            self._screen.log(level, logger, message)

    def _execute(self, follow_up: FollowUp) -> None:
        """Execute the steps that follow an event."""
        self._show(follow_up)
        try:
            follow_up.write_files()
        except OSError as error:
            self._fail(f"Cannot write {error.filename}: {error.strerror}")
            return
        for event in follow_up.events:
            self._loop.put(partial(self._respond, event))
        for request in follow_up.signals:
            for child in self._children:
                if child.plan.name == request.process and child.is_running:
                    self._terminator.send(request, child)
        if not self._shutting_down:
            # All are added before the first one starts, since its start may add more.
            indices = [self._add(process) for process in follow_up.processes]
            self.restarts.watch_sources(follow_up.processes)
            for index in indices:
                self._start_child(index)
            for seconds, timer in follow_up.timers:
                self._timers.add(seconds, timer)
            for work in follow_up.works:
                self._timers.begin(work)
        if follow_up.shutdown is not None:
            if self._shutting_down:
                self._tell_shutdown(follow_up.shutdown)
            else:
                self._shut_down(follow_up.shutdown)

    def _exited(self, child: Child) -> None:
        index = self._children.index(child)
        self._live.discard(index)
        if self.restarts.restart_ended(child):
            return
        if child.ended_cleanly:
            self._screen.log(
                "INFO",
                child.plan.name,
                f"process has finished cleanly [pid {child.pid}]",
                is_detail=child.plan.is_quiet and child.plan.ends_by_itself,
            )
        else:
            # A process that the launch has signalled may end with any status.
            self._failed = self._failed or self._interrupts.first is None
            died = f"process has died [pid {child.pid}, exit code {child.exit_status}, cmd '%s']."
            self._screen.log(
                "ERROR",
                child.plan.name,
                died % " ".join(child.plan.command),
                in_short=died % " ".join(map(in_short, child.plan.command)),
            )
            if self.restarts.waits_for_save(child):
                self._expected.discard(index)
                self._end_companions()
                self._published.publish()
                return
        assert child.exit_status is not None
        self._respond(ProcessExited(child.plan, child.pid or 0, child.exit_status))
        if self._respawns(child):
            child.retries += 1
            self._loop.after(child.plan.respawn_delay, partial(self._start_child, index))
        else:
            self._expected.discard(index)
            if child.plan.shutdown_on_exit and not self._shutting_down:
                self._required_ended(child)
            self._companion_lost(index)
        self._end_companions()
        self._published.publish()

    def _companion_lost(self, index: int) -> None:
        """Shut down if a companion has ended before the other processes were started."""
        if index in self._companions and not self._others_were_started:
            self._shut_down(f"{self._children[index].plan.name} has ended")

    def _end_companions(self) -> None:
        """Terminate the companions once all other processes and timers have ended."""
        if self._expected <= self._companions and not self._timers:
            for index in sorted(self._companions & self._live):
                self._terminator.terminate(self._children[index])

    def _respawns(self, child: Child) -> bool:
        plan = child.plan
        if not plan.respawn or self._shutting_down:
            return False
        if 0 <= plan.respawn_max_retries <= child.retries:
            return False
        return not status.is_marked_stopped(self._plan.log_directory, plan.name)

    def _required_ended(self, child: Child) -> None:
        text = REQUIRED.format(name=child.plan.name)
        self._say("INFO", text)
        self._shut_down(text)

    def _shutdown_requested(self, reason: str, by_interrupt: bool) -> bool:
        if self._shutting_down:
            return False
        self._say("WARNING", reason)
        self._shut_down(reason, by_interrupt=by_interrupt)
        return True

    def _send_to_all(self, reason: str, number: signal.Signals) -> None:
        self._say("WARNING", reason)
        for child in self._children:
            child.signal(number)

    def _shut_down(self, reason: str, *, by_interrupt: bool = False) -> None:
        """Begin the shutdown: cancel timers, emit the event, and terminate all processes."""
        if self._shutting_down:
            return
        self._shutting_down = True
        self.restarts.close()
        self._timers.shut_down()
        self._tell_shutdown(reason, by_interrupt=by_interrupt)
        # Processes that wait for their start or respawn are not started any more.
        self._expected &= self._live
        for index in sorted(self._live - self._companions):
            self._terminator.terminate(self._children[index])
        self._end_companions()
        self._published.publish()

    def _tell_shutdown(self, reason: str, *, by_interrupt: bool = False) -> None:
        """Emit the event; further requests have one of their own, but not those of its handlers."""
        if self._tells_shutdown:
            return
        self._tells_shutdown = True
        try:
            self._respond(ShutdownBegan(reason, by_interrupt))
        finally:
            self._tells_shutdown = False

    def _say(self, level: str, text: str, *, shown: str | None = None) -> None:
        self._screen.log(level, _LAUNCH, text, in_short=shown)
