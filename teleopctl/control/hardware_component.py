"""Hardware components: plug-ins with lifecycle state and statistics."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.base.exception_origin import with_origin
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.lifecycle import (
    CallbackReturn,
    OnException,
    ReturnType,
    State,
    handle_exception,
)
from teleopctl.control.statistics import WorkStatistics

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger

# Names of the lifecycle transitions, in logs and in the plug-in's callbacks.
_STEPS: dict[tuple[State, State], str] = {
    (State.UNCONFIGURED, State.INACTIVE): "configure",
    (State.INACTIVE, State.ACTIVE): "activate",
    (State.ACTIVE, State.INACTIVE): "deactivate",
    (State.INACTIVE, State.UNCONFIGURED): "cleanup",
}
_ORDER = (State.UNCONFIGURED, State.INACTIVE, State.ACTIVE)


class HardwareComponent:
    """Loaded hardware plug-in with lifecycle state, interfaces and statistics.

    Args:
        hardware: Instance of the plug-in.
        logger: Logger for lifecycle transitions and errors.
        update_rate: Update rate of the controller manager in Hz.
        rw_rate: Rate of reads and writes in Hz; by default that of the controller manager.

    Attributes:
        on_exception: Called with each exception of the plug-in, after it was logged, and with what
            was logged; by default it does nothing.
        lifecycle_state: Lifecycle state of the component.
        group: Name of the group of components that fail together; empty for none.
        rw_rate: Rate of reads and writes in Hz.
        is_async: Whether the component is read and written in a thread of its own.
        reads: Statistics of the duration and rate of reads.
        writes: Statistics of the duration and rate of writes.
    """

    is_async = False

    def __init__(
        self,
        hardware: HardwareComponentInterface,
        logger: RcutilsLogger,
        update_rate: int,
        rw_rate: int | None = None,
    ) -> None:
        self.hardware = hardware
        self.on_exception: OnException = handle_exception
        self.name: str = hardware.info.name
        self.group: str = hardware.info.group
        self.rw_rate = rw_rate or update_rate
        self.state_interfaces: list[StateInterface] = list(hardware.state_interfaces.values())
        self.command_interfaces: list[CommandInterface] = list(hardware.command_interfaces.values())
        self.lifecycle_state = State.UNCONFIGURED
        self.reads = WorkStatistics(self.rw_rate)
        self.writes = WorkStatistics(self.rw_rate)
        self._logger = logger

    def initialize(self) -> bool:
        """Call the plug-in's ``on_init``; return False unless it succeeds."""
        self._logger.info(f"Initialize hardware '{self.name}' ")
        if self._call(self.hardware.on_init) is not CallbackReturn.SUCCESS:
            self._logger.error(f"Failed to initialize hardware '{self.name}'")
            return False
        self._logger.info(f"Successful initialization of hardware '{self.name}'")
        return True

    def take_state_jumped(self) -> bool:
        """Return whether the plug-in has set ``state_jumped`` since the last call; clear that."""
        jumped, self.hardware.state_jumped = self.hardware.state_jumped, False
        return jumped

    def pause(self) -> None:
        """Wait until an asynchronous component is neither read nor written, until `resume`."""

    def resume(self) -> None:
        """Read and write again after `pause`."""

    def before_mode_switch(self) -> None:
        """Called before the plug-in prepares or performs a command mode switch; does nothing."""

    def after_mode_switch(self) -> None:
        """Called after the plug-in has prepared or performed a mode switch; does nothing."""

    def change_state(self, target: State) -> bool:
        """Change to a lifecycle state, transition by transition; return False if one fails."""
        if target is State.FINALIZED:
            return self._finalize()
        while self.lifecycle_state is not target:
            if self.lifecycle_state not in _ORDER or target not in _ORDER:
                return False
            here = _ORDER.index(self.lifecycle_state)
            step = 1 if _ORDER.index(target) > here else -1
            if not self._take(_ORDER[here + step]):
                return False
        return True

    def _take(self, following: State) -> bool:
        step = _STEPS[self.lifecycle_state, following]
        self._logger.info(f"'{step}' hardware '{self.name}' ")
        outcome = self._call(getattr(self.hardware, f"on_{step}"))
        if outcome is CallbackReturn.SUCCESS:
            self._enter(following)
            self._logger.info(f"Successful '{step}' of hardware '{self.name}'")
            return True
        self._logger.error(f"Failed to '{step}' hardware '{self.name}'")
        if outcome is CallbackReturn.ERROR:
            self.recover()
        return False

    def _finalize(self) -> bool:
        self._call(self.hardware.on_shutdown)
        self._enter(State.FINALIZED)
        return True

    def recover(self) -> None:
        """Call ``on_error``: the component is unconfigured after SUCCESS, else finalized."""
        recovered = self._call(self.hardware.on_error) is CallbackReturn.SUCCESS
        self._enter(State.UNCONFIGURED if recovered else State.FINALIZED)

    def _enter(self, state: State) -> None:
        self.lifecycle_state = state
        available = state in (State.INACTIVE, State.ACTIVE)
        for interface in (*self.state_interfaces, *self.command_interfaces):
            interface.available = available

    def read(self, time_ns: int, period: float) -> ReturnType:
        """Call ``read`` if inactive or active, on failure also ``on_error``; return the result."""
        if self.lifecycle_state not in (State.INACTIVE, State.ACTIVE):
            return ReturnType.OK
        began_ns = time.perf_counter_ns()
        outcome = self._call_in_cycle(self.hardware.read, time_ns, period)
        self.reads.add(began_ns, period)
        if outcome is not ReturnType.OK:
            if outcome is ReturnType.DEACTIVATE:
                self._logger.warning(
                    f"Hardware '{self.name}': DEACTIVATE returned from read cycle is treated the "
                    "same as ERROR."
                )
            self.recover()
            return ReturnType.ERROR
        return outcome

    def write(self, time_ns: int, period: float) -> ReturnType:
        """Call ``write`` if active, on failure also ``on_error``; return the result."""
        if self.lifecycle_state is not State.ACTIVE:
            return ReturnType.OK
        began_ns = time.perf_counter_ns()
        outcome = self._call_in_cycle(self.hardware.write, time_ns, period)
        self.writes.add(began_ns, period)
        if outcome is not ReturnType.OK:
            self.leave(outcome)
        return outcome

    def leave(self, outcome: ReturnType) -> None:
        """Change to the state after ERROR (by ``on_error``) or DEACTIVATE (inactive)."""
        if outcome is ReturnType.ERROR:
            self.recover()
        elif self.lifecycle_state is State.ACTIVE:
            self._take(State.INACTIVE)

    def _call_in_cycle(
        self, function: Callable[[int, float], ReturnType | None], time_ns: int, period: float
    ) -> ReturnType:
        try:
            outcome = function(time_ns, period) or ReturnType.OK
            if not isinstance(outcome, ReturnType):
                raise TypeError(f"it returned {outcome!r} in the place of a ReturnType")
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a plug-in's failure must not end the loop
            self._report_raised(function.__name__, error)
            outcome = ReturnType.ERROR
        return outcome

    def _call(self, function: Callable[[], CallbackReturn | None]) -> CallbackReturn:
        try:
            return function() or CallbackReturn.SUCCESS
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a plug-in's failure is the component's
            self._report_raised(function.__name__, error)
            return CallbackReturn.ERROR

    def _report_raised(self, function: str, error: BaseException) -> None:
        sentence = f"Hardware '{self.name}' raised in {function}: {with_origin(error)}"
        self._logger.error(sentence)
        self.on_exception(sentence, error)


class Pace:
    """Selection of the cycles in which a component with a rate of its own takes part.

    Args:
        rate: Rate of the component in Hz.
        update_rate: Rate of the cycles in Hz.
    """

    def __init__(self, rate: int, update_rate: int) -> None:
        self._rate = float(rate)
        self._always = rate >= update_rate
        self._cycle_s = 1.0 / update_rate
        self._since_s: float | None = None

    def restart(self) -> None:
        """Make the component take part in the next cycle, with the period of its rate."""
        self._since_s = None

    def elapsed(self, period: float) -> float:
        """Return the seconds since the last cycle with the component; 0 if not in this cycle.

        A component takes part in the cycle that is nearest to the time at which it is due.

        Args:
            period: Seconds since the last cycle.
        """
        since = 1.0 / self._rate if self._since_s is None else self._since_s + period
        self._since_s = since
        skipped = (since + self._cycle_s) * self._rate
        if not self._always and abs(since * self._rate - 1.0) > abs(skipped - 1.0):
            return 0.0
        self._since_s = 0.0
        return since

    def postpone(self, elapsed: float) -> None:
        """Make the component take part in the next cycle, since it could not in this one.

        Args:
            elapsed: Seconds that `elapsed` has returned in this cycle.
        """
        self._since_s = elapsed


class RatedHardwareComponent(HardwareComponent):
    """Hardware component that is read and written at a lower rate than the controllers' updates.

    Args:
        hardware: Instance of the plug-in.
        logger: Logger for lifecycle transitions and errors.
        update_rate: Update rate of the controller manager in Hz.
        rw_rate: Rate of reads and writes in Hz, below ``update_rate``.
    """

    def __init__(
        self,
        hardware: HardwareComponentInterface,
        logger: RcutilsLogger,
        update_rate: int,
        rw_rate: int,
    ) -> None:
        super().__init__(hardware, logger, update_rate, rw_rate)
        self._reading, self._writing = Pace(rw_rate, update_rate), Pace(rw_rate, update_rate)

    def _enter(self, state: State) -> None:
        super()._enter(state)
        self._writing.restart()
        if state not in (State.INACTIVE, State.ACTIVE):
            self._reading.restart()

    def read(self, time_ns: int, period: float) -> ReturnType:
        """Read as `HardwareComponent.read`, in the cycles of the component's rate."""
        elapsed = self._reading.elapsed(period)
        return super().read(time_ns, elapsed) if elapsed else ReturnType.OK

    def write(self, time_ns: int, period: float) -> ReturnType:
        """Write as `HardwareComponent.write`, in the cycles of the component's rate."""
        elapsed = self._writing.elapsed(period)
        return super().write(time_ns, elapsed) if elapsed else ReturnType.OK
