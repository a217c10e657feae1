"""Starts the processes of a plan, relays what they write, and stops them in order.

One thread decides: everything that happens reaches it through a queue, in the order in which it
happened. Ctrl-C becomes SIGINT for each process, SIGTERM after 5 s and SIGKILL after another 5 s.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from teleopctl.base.background import StartTime, start_of
from teleopctl.errors import TeleopctlError
from teleopctl.launch.execution import status
from teleopctl.launch.execution.child import Child, reason_of
from teleopctl.launch.execution.event_loop import EventLoop, Timers
from teleopctl.launch.execution.restarts import Restarts
from teleopctl.launch.execution.screen import Screen, in_short
from teleopctl.launch.execution.status import ProcessStatus, PublishedStatus
from teleopctl.launch.execution.termination import STEPS, Ending, Interrupts
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

_LAUNCH = "launch"
# A process says in a file that it is ready.
_LOOK_EVERY_S = 0.02


class Supervisor:
    """Runs the processes of a launch plan.

    Args:
        plan: What to start; its log folder and files have been written.
        respondent: Knows what to do on events; None where nothing is to be done.
        in_background: Whether the launch's own lines go to the log of the background process
            alone.
        coloured: Whether levels and names of processes are coloured on the screen.
        debug: Whether to say which events come.
        log_name: Name of the file with all output, without its ending.

    Attributes:
        restarts: Starts again what is saved, where somebody watches that.
    """

    def __init__(
        self,
        plan: LaunchPlan,
        respondent: Respondent | None = None,
        *,
        in_background: bool = False,
        coloured: bool = False,
        debug: bool = False,
        log_name: str = "launch",
    ) -> None:
        self._debug = debug
        self._plan = plan
        self._respondent = respondent
        self._loop = EventLoop()
        self._published = PublishedStatus(plan.log_directory, self._loop, self)
        self._timers = Timers(
            self._loop, self._published.publish, self._time_has_come, self._work_ended
        )
        log_file = None if in_background else plan.log_directory / f"{log_name}.log"
        self._screen = Screen(log_file, coloured=coloured)
        self._ending = Ending(self._loop, self._screen)
        self._interrupts = Interrupts(self._loop, self._asked_to_end, self._hurry)
        self._children: list[Child] = []
        self.restarts = Restarts(
            self._children,
            plan.log_directory,
            loop=self._loop,
            screen=self._screen,
            interrupts=self._interrupts,
            ending=self._ending,
            start=self._start_again,
        )
        # Those of which something is still to come, and of these those whose process was started.
        self._expected: set[int] = set()
        self._live: set[int] = set()
        self._companions: set[int] = set()
        for process in plan.processes:
            self._add(process)
        self._others_were_started = False
        self._starts: dict[int, StartTime] = {}
        if respondent is not None:
            respondent.connect(lambda event: self._loop.put(partial(self._respond, event)))
        self._shutting_down = False
        # Whether something failed, and whether that was the launch and not what it started.
        self._failed = self._failed_itself = False

    def statuses(self) -> list[ProcessStatus]:
        """Return the state of each process; any thread may call this."""
        return [
            status.status_of(child, self._starts.get(index, StartTime()))
            for index, child in enumerate(tuple(self._children))
        ]

    def pending(self) -> int:
        """Return the number of timers that are due soon; any thread may call this."""
        return self._timers.pending()

    def tell(self, level: str, text: str, shown: str | None = None) -> None:
        """Log a line in the launch's name; any thread may call this. An error makes it fail.

        Args:
            level: Its level.
            text: What the log keeps.
            shown: What the screen shows, such as an address with its token; by default the same.
        """
        self._loop.put(lambda: self._told(level, text, shown))

    def _told(self, level: str, text: str, shown: str | None) -> None:
        self._failed = self._failed or level == "ERROR"
        if not self._shutting_down:
            self._say(level, text, shown=shown)

    def run(self) -> int:
        """Run until every process has ended.

        Returns:
            What became of it, as an exit status: 1 when a process died, 128 and the number of the
            signal that ended it, such as 130 after Ctrl-C, otherwise 0.
        """
        try:
            with self._interrupts.heard():
                self._start()
                while self._is_going_on() or self._has_come_to_rest():
                    self._loop.handle_next()
        except BaseException:
            # Nobody else would end them.
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
        """Exit status as of ``ros2 launch``, which does not depend on its processes.

        1 when the launch itself failed, or a signal other than Ctrl-C ended it; otherwise 0.
        """
        was_ended = self._interrupts.first not in (None, signal.SIGINT)
        return int(self._failed_itself or was_ended)

    def _start(self) -> None:
        self._say("INFO", f"All log files can be found below {self._plan.log_directory}")
        verbosity = "DEBUG" if self._debug else "INFO"
        self._say("INFO", f"Default logging verbosity is set to {verbosity}")
        for warning in self._plan.warnings:
            self._say("WARNING", warning)
        self._show(self._plan.start)
        self._published.publish()  # of a launch that starts nothing, too
        for index in sorted(self._companions):
            self._start_child(index)
        self._start_others()

    def _add(self, process: ProcessPlan) -> int:
        """Take a process in, and return its index."""
        index = len(self._children)
        log_file = self._plan.log_directory / f"{process.name}.log"
        self._children.append(
            Child(
                process,
                log_file,
                self._screen,
                lambda child: self._loop.put(lambda: self._exited(child)),
                self._wrote,
            )
        )
        self._expected.add(index)
        if process.accompanies:
            self._companions.add(index)
        return index

    def _is_going_on(self) -> bool:
        return bool(self._expected or self._timers) or self.restarts.keep_launch()

    def _has_come_to_rest(self) -> bool:
        """Tell those who wait for the end that nothing is left; return whether that led to more."""
        if self._loop.is_empty and not self._shutting_down:
            self._shut_down("idle")
        return not self._loop.is_empty

    def _start_others(self) -> None:
        """Start what companions are to see from its first word on, once they are ready for it."""
        if self._shutting_down:
            return
        if not all(self._children[index].is_ready for index in self._companions):
            self._loop.after(_LOOK_EVERY_S, self._start_others)
            return
        self._others_were_started = True
        for index in range(len(self._children)):
            if index not in self._companions:
                self._start_child(index)
        self._go_on(replace(self._plan.start, messages=[], files={}, processes=[]))

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
            return  # it was saved while it waited to be started again
        try:
            child.start()
        except (OSError, ValueError) as error:
            self._failed = True
            self._expected.discard(index)
            text = f"process failed to start: {reason_of(error)}"
            self._screen.say("ERROR", child.plan.name, text)
            if child.plan.shutdown_on_exit:
                self._required_ended(child)
            self._lost_before_the_others(index)
        else:
            self._screen.say("INFO", child.plan.name, f"process started with pid [{child.pid}]")
            child.attend()
            self._live.add(index)
            assert child.pid is not None
            self._starts[index] = start_of(child.pid)
            self._respond(ProcessStarted(child.plan, child.pid, was_saved))
        self._published.publish()

    def _wrote(self, child: Child, line: bytes, is_stdout: bool) -> None:
        """Tell those who want to know it what a process has written; on that one's threads."""
        if self._respondent is not None and self._respondent.wants_output:
            event = ProcessOutput(child.plan, child.pid or 0, line, is_stdout)
            self._loop.put(lambda: self._respond(event))

    def _respond(self, event: object) -> None:
        if self._debug:
            self._say("DEBUG", f"processing event: '{event}'")
        if self._respondent is not None:
            self._take_further(partial(self._respondent.answer, event))

    def _time_has_come(self, timer: LaunchTimer) -> None:
        if self._respondent is not None:
            self._take_further(partial(self._respondent.fire, timer))
        self._end_companions()
        self._published.publish()

    def _work_ended(self, error: TeleopctlError | None) -> None:
        if error is not None:
            self._fail(str(error))
        self._end_companions()

    def _take_further(self, ask: Callable[[], FollowUp]) -> None:
        further = None
        try:
            with self._interrupts.stopping_what_takes_long():
                further = ask()
        except TeleopctlError as error:
            self._fail(str(error))
        if further is not None:
            self._go_on(further)

    def _fail(self, text: str) -> None:
        self._failed = self._failed_itself = True
        self._say("ERROR", f"Caught exception in launch: {text}")
        self._shut_down(text)

    def _show(self, further: FollowUp) -> None:
        for level, logger, message in further.messages:
            self._screen.say(level, logger, message)

    def _go_on(self, further: FollowUp) -> None:
        """Do what an event has led to."""
        self._show(further)
        try:
            further.write_files()
        except OSError as error:
            self._fail(f"Cannot write {error.filename}: {error.strerror}")
            return
        for event in further.events:
            self._loop.put(partial(self._respond, event))
        for request in further.signals:
            for child in self._children:
                if child.plan.name == request.process and child.is_running:
                    self._ending.send(request, child)
        if not self._shutting_down:
            # All of them are known before the first one starts, whose start may lead to more.
            indices = [self._add(process) for process in further.processes]
            self.restarts.take_in(further.processes)
            for index in indices:
                self._start_child(index)
            for seconds, timer in further.timers:
                self._timers.add(seconds, timer)
            for work in further.works:
                self._timers.begin(work)
        if further.shutdown is not None:
            self._shut_down(further.shutdown)

    def _exited(self, child: Child) -> None:
        index = self._children.index(child)
        self._live.discard(index)
        if self.restarts.answers_end_of(child):
            return
        if child.ended_well:
            self._screen.say(
                "INFO", child.plan.name, f"process has finished cleanly [pid {child.pid}]"
            )
        else:
            # Of those that were made to end, some have their own way of doing so.
            self._failed = self._failed or self._interrupts.first is None
            died = f"process has died [pid {child.pid}, exit code {child.exit_status}, cmd '%s']."
            self._screen.say(
                "ERROR",
                child.plan.name,
                died % " ".join(child.plan.command),
                in_short=died % " ".join(map(in_short, child.plan.command)),
            )
            if self.restarts.keeps_dead(child):
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
            self._lost_before_the_others(index)
        self._end_companions()
        self._published.publish()

    def _lost_before_the_others(self, index: int) -> None:
        """Start nothing that somebody wants to be accompanied and that cannot be."""
        if index in self._companions and not self._others_were_started:
            self._shut_down(f"{self._children[index].plan.name} has ended")

    def _end_companions(self) -> None:
        """Ask those that accompany the others to end, once there is nobody left to accompany."""
        if self._expected <= self._companions and not self._timers:
            for index in sorted(self._companions & self._live):
                self._ending.ask(self._children[index])

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

    def _asked_to_end(self, reason: str, by_interrupt: bool) -> bool:
        if self._shutting_down:
            return False
        self._say("WARNING", reason)
        self._shut_down(reason, by_interrupt=by_interrupt)
        return True

    def _hurry(self, reason: str, number: signal.Signals) -> None:
        self._say("WARNING", reason)
        for child in self._children:
            child.signal(number)

    def _shut_down(self, reason: str, *, by_interrupt: bool = False) -> None:
        """Ask every process to end, and arrange for harder ways."""
        if self._shutting_down:
            return
        self._shutting_down = True
        self.restarts.close()
        self._timers.shut_down()
        self._respond(ShutdownBegan(reason, by_interrupt))
        # What waits for its start, or for its next one, is not started any more.
        self._expected &= self._live
        for index in sorted(self._live - self._companions):
            self._ending.ask(self._children[index])
        self._end_companions()
        self._published.publish()

    def _say(self, level: str, text: str, *, shown: str | None = None) -> None:
        self._screen.say(level, _LAUNCH, text, in_short=shown)
