"""Hardware components that are read and written in threads of their own.

The plug-in and the controllers have interfaces of their own. Values pass between them in the
control cycle: measured values after the plug-in has returned from a call, commands before the next
call. So controllers never get a part of a read, and the plug-in gets the commands of one cycle.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.control.asynchronous.function_handler import LONGEST_CALL_S, AsyncFunctionHandler
from teleopctl.control.handles import CommandInterface
from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.hardware_component import HardwareComponent, Pace
from teleopctl.control.lifecycle import CallbackReturn, ReturnType, State

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger

_ACCESSIBLE = (State.INACTIVE, State.ACTIVE)


class AsyncHardwareComponent(HardwareComponent):
    """Hardware component that reads and writes in a thread of its own, once per trigger.

    Each trigger reads and, if the component is active, writes. The control cycle triggers at the
    component's rate and never waits; a detached thread keeps that rate by itself.

    Args:
        hardware: Instance of the plug-in.
        logger: Logger for lifecycle transitions and errors.
        update_rate: Update rate of the controller manager in Hz.
        rw_rate: Rate of reads and writes in Hz, at most ``update_rate``.
        uses_threads: Function that returns False in lockstep, where the cycle reads and writes, and
            the values pass one cycle later all the same.
    """

    is_async = True

    def __init__(
        self,
        hardware: HardwareComponentInterface,
        logger: RcutilsLogger,
        update_rate: int,
        rw_rate: int,
        uses_threads: Callable[[], bool],
    ) -> None:
        super().__init__(hardware, logger, update_rate, rw_rate)
        self._own_states, self._own_commands = self.state_interfaces, self.command_interfaces
        self.state_interfaces = [copy.copy(state) for state in self._own_states]
        self.command_interfaces = [copy.copy(command) for command in self._own_commands]
        # Values of the last read and how often they have jumped, replaced by the thread; and those
        # that `read` has taken over.
        self._measured: tuple[list[float], int] | None = None
        self._taken: tuple[list[float], int] | None = None
        self._jumps = self._jumps_taken = self._jumps_reported = 0
        self._given: list[tuple[float, str | None]] = []
        self._failed_in = "read"
        self._is_paused = False
        self._has_write = hardware.info.type != "sensor"
        self._pace = Pace(rw_rate, update_rate)
        self._handler = AsyncFunctionHandler(
            self._read_and_write,
            f"hardware {self.name}",
            hardware.info.async_thread,
            rw_rate,
            logger,
            uses_threads,
        )

    def _read_and_write(self, time_ns: int, period: float) -> ReturnType:
        """Read, then write if active; called in the thread."""
        self._failed_in = "read"
        began_ns = time.perf_counter_ns()
        outcome = self._call_in_cycle(self.hardware.read, time_ns, period)
        self.reads.add(began_ns, period)
        self._jumps += super().take_state_jumped()
        self._measured = [state.value for state in self._own_states], self._jumps
        is_written = self.lifecycle_state is State.ACTIVE and self._has_write
        if outcome is not ReturnType.OK or not is_written:
            return outcome
        self._failed_in = "write"
        for command, (value, owner) in zip(self._own_commands, self._given, strict=True):
            command.value, command.owner = value, owner
        began_ns = time.perf_counter_ns()
        outcome = self._call_in_cycle(self.hardware.write, time_ns, period)
        self.writes.add(began_ns, period)
        return outcome

    def read(self, time_ns: int, period: float) -> ReturnType:
        """Take over the values of the last call, and trigger the next one if due; return a failure.

        Returns:
            The result of the last call, if it was not returned before; else OK.
        """
        if self.lifecycle_state not in _ACCESSIBLE:
            return ReturnType.OK
        measured = self._measured
        if measured is not None and measured is not self._taken:
            self._taken = measured
            values, self._jumps_taken = measured
            for state, value in zip(self.state_interfaces, values, strict=True):
                state.value = value
        handler = self._handler
        if not handler.is_busy and (outcome := handler.take_outcome()) is not ReturnType.OK:
            if outcome is ReturnType.DEACTIVATE and self._failed_in == "read":
                outcome = ReturnType.ERROR
            self.leave(outcome)
            return outcome
        elapsed = self._pace.elapsed(period)
        if not elapsed or self._is_paused:
            return ReturnType.OK
        if handler.is_busy:
            self._pace.postpone(elapsed)
            if self.hardware.info.async_thread.print_warnings:
                self._logger.warning(
                    "Trigger read/write called while the previous async trigger is still in "
                    f"progress for hardware interface : '{self.name}'. Failed to trigger "
                    "read/write cycle!",
                    throttle_duration_sec=1.0,
                )
            return ReturnType.OK
        self._given = [(command.value, command.owner) for command in self.command_interfaces]
        handler.trigger(time_ns, elapsed)
        return ReturnType.OK

    def write(self, time_ns: int, period: float) -> ReturnType:
        """Return OK: the thread writes, and `read` returns its failures."""
        del time_ns, period
        return ReturnType.OK

    def take_state_jumped(self) -> bool:
        """Return whether the values taken over since the last call have jumped."""
        before, self._jumps_reported = self._jumps_reported, self._jumps_taken
        return self._jumps_taken != before

    def pause(self) -> None:
        """Trigger no more, and wait for the running read and write."""
        self._is_paused = True
        self._handler.wait_until_idle()

    def resume(self) -> None:
        """Trigger again in the next cycle."""
        self._is_paused = False

    def wait_until_idle(self) -> bool:
        """Wait for the running read and write; return False if they take too long."""
        return self._handler.wait_until_idle()

    def _enter(self, state: State) -> None:
        super()._enter(state)
        self._pace.restart()
        if state not in _ACCESSIBLE:
            self._handler.stop_thread()

    def _call(self, function: Callable[[], CallbackReturn | None]) -> CallbackReturn:
        """Call a lifecycle callback of the plug-in after the running read and write."""
        if not self._handler.wait_until_idle():
            self._logger.error(
                f"Hardware '{self.name}' has not returned from read() or write() for "
                f"{LONGEST_CALL_S:g} s: {function.__name__} is not called"
            )
            return CallbackReturn.ERROR
        self.before_mode_switch()
        outcome = super()._call(function)
        self._measured = None
        for shared, own in zip(self.state_interfaces, self._own_states, strict=True):
            shared.value = own.value
        self.after_mode_switch()
        return outcome

    def before_mode_switch(self) -> None:
        """Copy commands and their owners to the plug-in's interfaces."""
        for own, shared in self._command_pairs():
            own.value, own.owner, own.next_owner = shared.value, shared.owner, shared.next_owner

    def after_mode_switch(self) -> None:
        """Copy the commands that the plug-in may have changed to the controllers' interfaces."""
        for own, shared in self._command_pairs():
            shared.value = own.value

    def _command_pairs(self) -> list[tuple[CommandInterface, CommandInterface]]:
        return list(zip(self._own_commands, self.command_interfaces, strict=True))
