"""Main loop of the simulator: physics, wall clock and controller in lockstep.

At each control tick the loop publishes the state of that time, waits (bounded, in wall time) for
the command computed from that state, applies the command, and steps to the next tick. Without a
controller, and after a controller has stopped answering, the loop runs freely and the joints hold.

The loop has ports, not topics; `teleopctl.sim.node` connects the two.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from teleopctl.sim.pacing import Pacer, PeriodicSchedule
from teleopctl.sim.simulation import Simulation


class Command(NamedTuple):
    """Joint commands of a controller for one control period.

    Attributes:
        stamp_ns: Time of the state that the command answers; 0 for a sender without lockstep.
        names: Joint names.
        position: Positions, one per name, or empty.
        velocity: Velocities, one per name, or empty.
        effort: Efforts, one per name, or empty.
    """

    stamp_ns: int
    names: Sequence[str] = ()
    position: Sequence[float] = ()
    velocity: Sequence[float] = ()
    effort: Sequence[float] = ()


@dataclass(eq=False)
class StepRequest:
    """Request for a number of physics steps while the simulation is paused.

    Attributes:
        left: Number of steps still to be made.
        on_end: Called at the end with whether all steps were made.
        on_begin: Called on the loop's thread before the first step.
    """

    left: int
    on_end: Callable[[bool], None]
    on_begin: Callable[[], None]


def _do_nothing() -> None:
    """Do nothing: default of ``on_begin``."""


class Ports(Protocol):
    """Interface of the lockstep loop's outputs; called on the loop's thread."""

    def publish_clock(self, time_ns: int) -> None:
        """Publish the simulated time."""

    def publish_state(self, time_ns: int) -> None:
        """Publish the joint states of a control tick, which the controller answers."""

    def publish_view(self, time_ns: int) -> None:
        """Publish joint states and free bodies' poses for viewers and cameras, when due."""

    def controller_lost(self, time_ns: int, waited_s: float) -> None:
        """Report that no command arrived for the state of a time within ``waited_s`` seconds."""

    def controller_back(self, time_ns: int) -> None:
        """Report that the controller answers again after it was lost."""

    def fell_behind(self, seconds: float, factor: float) -> None:
        """Report the wall time (s) that the simulation lost, and the real-time factor reached."""

    def diverged(self, time_ns: int) -> None:
        """Report that the robot's physics became unstable and was reset."""

    def commands_cut(self, sentences: Sequence[str]) -> None:
        """Report each joint's first command beyond its limits, one sentence per joint."""

    def objects_reset(self, time_ns: int, things: Sequence[str]) -> None:
        """Report objects whose physics became unstable and which were reset."""


class Sampler(Protocol):
    """Interface by which the loop publishes sensors at their own times, on the loop's thread."""

    def next_ns(self) -> int | None:
        """Return the simulated time of the next measurement; None without subscribers."""

    def sample(self, time_ns: int) -> None:
        """Publish the measurements that are due at a simulated time."""

    def show(self, time_ns: int) -> None:
        """Publish sensors of state, such as contacts, again after a change while paused."""


_CLOCK_RATE_HZ = 100.0

# Simulated time (ns) that the loop steps at once without controller and commands: ten times the
# cost of one cycle of the loop, for the smallest robots, and short enough to serve requests.
_COAST_NS = 50_000_000


class LockstepLoop:
    """Loop that runs a simulation in lockstep with a controller; thread-safe.

    Args:
        simulation: Simulation to step; no other thread may use it while the loop runs.
        ports: Outputs of the loop.
        real_time_factor: Simulated seconds per second of wall time; 0 for as fast as possible.
        lockstep_timeout_s: Longest wait for a command, in seconds of wall time.
        view_rate_hz: Greatest rate of calls of `Ports.publish_view`, in simulated time.
        paused: Whether the simulation starts paused.
        sampler: Sampler of the sensors, or None.
        end_ns: Simulated time at which the simulation ends, in nanoseconds, or None.
    """

    def __init__(
        self,
        simulation: Simulation,
        ports: Ports,
        *,
        real_time_factor: float = 1.0,
        lockstep_timeout_s: float = 1.0,
        view_rate_hz: float = 60.0,
        paused: bool = False,
        sampler: Sampler | None = None,
        end_ns: int | None = None,
    ) -> None:
        self._simulation = simulation
        self._sampler = sampler
        self._end_ns = end_ns
        self._ports = ports
        self._timeout_s = lockstep_timeout_s
        self._pacer = Pacer(real_time_factor)
        self._clock_schedule = PeriodicSchedule(_CLOCK_RATE_HZ)
        self._view_schedule = PeriodicSchedule(view_rate_hz)
        self._changed = threading.Condition()
        # Whether `_ready` has anything to do: at 1 kHz each lock that is not taken counts.
        self._called = True
        self._stopped = False
        self._paused = paused
        self._parked = False
        self._steps: deque[StepRequest] = deque()
        self._requests: deque[Callable[[], None]] = deque()
        # By simulated time, in ascending order.
        self._timed: deque[tuple[int, Callable[[], None]]] = deque()
        self._partner = False
        self._viewed = self._was_viewed = False
        self._clocked = True
        self._attended = True
        self._lost = False
        self._lost_ns = 0
        self._command: Command | None = None
        self._unstamped: Command | None = None
        # Resets that controllers have received, and whether a restart of time is still to be sent.
        self._resets_seen = simulation.resets
        self._began_anew = False
        self._exchanged = False
        self._own_thread = 0

    # --- called from outside ----------------------------------------------------------------

    def receive_command(self, command: Command) -> None:
        """Store a received joint command, which the loop applies at a control tick."""
        if command.stamp_ns and threading.get_ident() == self._own_thread:
            # Of a hosted controller: no thread waits, and at 1 kHz a lock costs time.
            self._command = command
            return
        with self._changed:
            if command.stamp_ns == 0 and self._simulation.time_ns != 0:
                self._unstamped = command
            else:
                self._command = command
            self._changed.notify_all()

    def set_controller_present(self, present: bool) -> None:
        """Set whether there is a controller whose commands the loop waits for."""
        with self._changed:
            self._partner = present
            self._changed.notify_all()

    def set_viewed(self, viewed: bool) -> None:
        """Set whether topics for viewers and cameras have subscribers; only then they are sent."""
        with self._changed:
            self._viewed = viewed

    def set_subscribed(self, *, clock: bool, ticks: bool) -> None:
        """Set whether the clock and the tick states have subscribers, else they may be skipped.

        Args:
            clock: Whether to publish the simulated time.
            ticks: Whether states of control ticks have subscribers, or commands have publishers;
                if neither, the loop may skip control ticks.
        """
        with self._changed:
            self._clocked = clock
            self._attended = ticks

    def set_paused(self, paused: bool, timeout_s: float) -> bool:
        """Pause at the next tick or resume, cancel requested steps; return whether in time.

        Returns:
            Whether the loop has paused or resumed within ``timeout_s``.
        """
        self._give_up_steps()
        with self._changed:
            self._paused, self._called = paused, True
            self._changed.notify_all()
            return self._changed.wait_for(
                lambda: self._stopped or self._parked == paused or self._paused != paused,
                timeout_s,
            )

    @property
    def paused(self) -> bool:
        """Whether the simulation is paused or about to pause."""
        with self._changed:
            return self._paused

    @property
    def reached_factor(self) -> float:
        """Measured real-time factor over the last second; 0 while paused."""
        return 0.0 if self.paused else self._pacer.reached.at(self._simulation.time_ns)

    def step(
        self,
        count: int,
        on_end: Callable[[bool], None],
        on_begin: Callable[[], None] = lambda: None,
    ) -> None:
        """Request physics steps while paused; ``on_end`` is called when they are made or cancelled.

        Args:
            count: Number of steps, at least one; steps of earlier requests are made first.
            on_end: Called on any thread with whether all steps were made. Steps are cancelled
                when the simulation is paused or resumed, and when the loop ends.
            on_begin: Called on the loop's thread before the first step.
        """
        with self._changed:
            self._steps.append(StepRequest(count, on_end, on_begin))
            self._called = True
            self._changed.notify_all()
            stopped = self._stopped
        if stopped:
            self._give_up_steps()

    @property
    def stepping(self) -> bool:
        """Whether requested physics steps are still to be made."""
        return bool(self._steps)

    def call(self, request: Callable[[], None], timeout_s: float) -> bool:
        """Call a function on the loop's thread between two steps; return whether it ran in time.

        Returns:
            Whether the function was called within ``timeout_s``; otherwise it is not called.
        """
        done = threading.Event()

        def run() -> None:
            try:
                request()
            finally:
                with self._changed:
                    done.set()
                    self._changed.notify_all()

        with self._changed:
            self.post(run)
            self._changed.wait_for(lambda: self._stopped or done.is_set(), timeout_s)
            if run in self._requests:
                self._requests.remove(run)
                return False
        return done.wait()  # a call that has begun runs to its end

    def post(self, request: Callable[[], None]) -> None:
        """Queue a function that the loop's thread calls between two steps; return at once."""
        with self._changed:
            self._requests.append(request)
            self._called = True
            self._changed.notify_all()

    def call_at(self, time_ns: int, request: Callable[[], None]) -> None:
        """Queue a function that the loop calls at a simulated time, before that time's exchange.

        Only for a loop that does not run yet; times must not decrease.
        """
        self._timed.append((time_ns, request))

    def set_real_time_factor(self, factor: float) -> None:
        """Set the requested real-time factor, effective from the next block of steps on."""
        self.post(lambda: self._pacer.set_factor(factor, self._simulation.time_ns))

    def restart(self) -> None:
        """Restart schedules and pace after a jump of simulated time; call on the loop's thread."""
        now = self._simulation.time_ns
        for schedule in (self._clock_schedule, self._view_schedule):
            schedule.restart()
        self._pacer.resume(now)
        self._command = self._unstamped = None
        self._lost = False
        self._began_anew, self._exchanged = True, False

    def go_on(self) -> None:
        """Continue the schedules at the present time, which was published, before `run`."""
        now = self._simulation.time_ns
        self._clock_schedule.skip_to(now + 1)
        self._view_schedule.skip_to(now)
        self._was_viewed = True

    def show(self, *, even_running: bool = False) -> None:
        """Publish the present state if the simulation is paused; call on the loop's thread.

        For changes by services, and for new subscribers. After a reset controllers get the state
        too; a command with which they answer at a control tick is not requested again.

        Args:
            even_running: Whether to publish it if the simulation is not paused, too.
        """
        if self._parked or even_running:
            now = self._simulation.time_ns
            if self._began_anew or self._simulation.resets != self._resets_seen:
                # A command for the state before the reset does not answer this state, even if
                # both have the same time.
                self._command = self._unstamped = None
                self._exchange(stepping=True)
                self._exchanged = self._simulation.at_tick and self._answer(now) is not None
            else:
                self._ports.publish_clock(now)
            if self._viewed:
                self._simulation.read()
                self._ports.publish_view(now)
            if self._sampler is not None:
                self._sampler.show(now)

    def stop(self) -> None:
        """Make `run` return after the present block of steps; any thread may call this."""
        with self._changed:
            self._stopped = self._called = True
            self._changed.notify_all()
        self._give_up_steps()

    def _give_up_steps(self) -> None:
        with self._changed:
            given_up, self._steps = self._steps, deque()
        for steps in given_up:
            steps.on_end(False)

    # --- the loop -------------------------------------------------------------------------

    def run(self) -> None:
        """Run the simulation until `stop` is called or its end time is reached."""
        simulation = self._simulation
        self._own_thread = threading.get_ident()
        self._pacer.resume(simulation.time_ns)
        while not self._called or self._ready():
            while self._timed and self._timed[0][0] <= simulation.time_ns:
                self._timed.popleft()[1]()
            if steps := pending[0] if (pending := self._steps) else None:
                begin, steps.on_begin = steps.on_begin, _do_nothing
                begin()
            exchanged, self._exchanged = self._exchanged, False
            if (
                simulation.at_tick
                and not exchanged
                and not self._exchange(stepping=steps is not None)
            ):
                continue
            if self._end_ns is not None and self.at_end:
                self._ports.publish_clock(simulation.time_ns)
                self.stop()
                continue
            count = self._block(steps)
            (simulation.step if steps or self._attended else simulation.coast)(count)
            now = simulation.time_ns
            if not (steps or self._paused):
                self._wait_until_due(now)
            if steps is None:
                self._publish(now)
                continue
            steps.left -= count
            self._publish(now, force=steps.left == 0)
            if steps.left == 0:
                self._end(steps)

    def _end(self, steps: StepRequest) -> None:
        with self._changed:
            if steps not in self._steps:
                return  # the steps were cancelled
            self._steps.remove(steps)
        steps.on_end(True)

    def _next_request(self) -> Callable[[], None] | None:
        with self._changed:
            return self._requests.popleft() if self._requests else None

    @property
    def at_end(self) -> bool:
        """Whether the simulation has reached its end time; false without one."""
        return self._end_ns is not None and self._simulation.time_ns >= self._end_ns

    def _ready(self) -> bool:
        """Run requests, and wait while paused; return False when the loop is to end.

        There is nothing to do unless something was called.
        """
        while self._called:
            while request := self._next_request():
                request()
            with self._changed:
                if self._stopped:
                    self._changed.notify_all()
                    return False
                if self._requests:
                    continue
                at_rest = self._parked or self._simulation.at_tick
                if not (self._paused and at_rest and not self._steps):
                    if self._parked and not self._steps:
                        self._parked = False
                        self._pacer.resume(self._simulation.time_ns)
                        self._changed.notify_all()
                    self._called = self._paused or bool(self._steps)
                    return True
                comes_to_rest = not self._parked
                self._parked = True
                if not comes_to_rest:
                    self._changed.notify_all()
                    self._changed.wait_for(
                        lambda: self._stopped or not self._paused or self._steps or self._requests
                    )
            if comes_to_rest:
                # The last published state may be of an earlier time.
                self.show()
        return True

    def _exchange(self, *, stepping: bool) -> bool:
        """Publish the state of a control tick and apply its command; return False if stopped."""
        now = self._simulation.time_ns
        if self._simulation.diverged:
            self._simulation.reset_state()
            self._ports.diverged(now)
        if self._simulation.put_back:
            self._ports.objects_reset(now, self._simulation.put_back)
            self._simulation.put_back = []
        self._resets_seen, self._began_anew = self._simulation.resets, False
        # Controllers take their time from the state; for other nodes a coarser clock is enough,
        # which at 1 kHz saves each of them 900 messages a second. Requested steps publish the
        # exact time.
        if self._clock_due(now) or stepping:
            self._ports.publish_clock(now)
        if self._attended or stepping:
            self._simulation.read()
            self._ports.publish_state(now)
        command = self._await_command(now)
        # Commands are for whole periods; within a period, an exchange happens only after a reset.
        if command is not None and self._simulation.at_tick:
            self._simulation.apply(
                command.names, command.position, command.velocity, command.effort
            )
            if cut := self._simulation.take_cut_commands():
                self._ports.commands_cut(cut)
        self._publish(now)
        return not self._stopped

    def _await_command(self, now: int) -> Command | None:
        """Return the command for this tick, or None to keep the last one."""
        if self._command is self._unstamped is None and not (self._partner or self._lost):
            return None
        if not (self._lost or self._stopped) and self._unstamped is None:
            # A hosted controller has answered already: at 1 kHz a lock counts.
            answer = self._answer(now)
            if answer is not None:
                return answer
        with self._changed:
            unstamped, self._unstamped = self._unstamped, None
            if self._expected():
                self._changed.wait_for(
                    lambda: self._stopped or not self._partner or self._answer(now) is not None,
                    self._timeout_s,
                )
            answer = self._answer(now)
            missed = answer is None and (self._partner or self._command is not None)
            was_lost, self._lost = self._lost, missed
            waited_s = self._timeout_s if self._partner else 0.0
            if missed and not was_lost:
                self._lost_ns = now
            if missed and not self._partner:
                # Reported now; the next command is that of a new controller.
                self._command = None
            if self._stopped:
                return None
        if missed and not was_lost:
            self._simulation.hold()
            self._ports.controller_lost(now, waited_s)
        elif was_lost and answer is not None:
            self._ports.controller_back(now)
        return answer or unstamped

    def _expected(self) -> bool:
        """Whether to wait for a command; a lost controller must first answer a later state."""
        if not self._partner or not self._lost:
            return self._partner
        return self._command is not None and self._command.stamp_ns > self._lost_ns

    def _answer(self, now: int) -> Command | None:
        command = self._command
        return command if command is not None and command.stamp_ns == now else None

    def _block(self, steps: StepRequest | None) -> int:
        """Return the number of physics steps until something is due or requested steps end."""
        simulation = self._simulation
        count = simulation.steps_to_tick
        if count == 1 and self._attended:
            return count
        if steps is None and not self._attended:
            count = max(count, simulation.steps_until(simulation.time_ns + _COAST_NS))
        if self._clocked:
            count = min(count, simulation.steps_until(self._clock_schedule.next_ns) or count)
        if self._viewed:
            count = min(count, simulation.steps_until(self._view_schedule.next_ns) or 1)
        if self._sampler is not None and (due_ns := self._sampler.next_ns()) is not None:
            count = min(count, simulation.steps_until(due_ns) or 1)
        if self._timed:
            count = min(count, simulation.steps_until(self._timed[0][0]))
        if self._end_ns is not None:
            count = min(count, simulation.steps_until(self._end_ns))
        if steps is not None:
            count = min(count, steps.left)
        return count

    def _clock_due(self, now: int) -> bool:
        return self._clock_schedule.poll(now) and self._clocked

    def _wait_until_due(self, now: int) -> None:
        if self._pacer.real_time_factor <= 0.0:
            self._pacer.reached.record(now)
            return
        if (lag := self._pacer.drop_lag(now)) > 0.0 and not self._lost:
            self._ports.fell_behind(lag, self._pacer.reached.at(now))
        with self._changed:
            while (remaining := self._pacer.remaining_s(now)) > 0.0:
                if self._stopped or self._paused or self._requests:
                    return
                self._changed.wait(remaining)

    def _publish(self, now: int, *, force: bool = False) -> None:
        """Publish clock, view and sensors that are due at a time, at a control tick or not."""
        if not self._simulation.at_tick and (self._clock_due(now) or force):
            self._ports.publish_clock(now)
        viewed, was_viewed, self._was_viewed = self._viewed, self._was_viewed, self._viewed
        if viewed and not was_viewed:
            # The times at which a viewer gets states must not depend on its start.
            self._view_schedule.skip_to(now)
        if viewed and (self._view_schedule.poll(now) or force):
            self._simulation.read()
            self._ports.publish_view(now)
        if self._sampler is not None:
            self._sampler.sample(now)
            if force:
                self._sampler.show(now)
