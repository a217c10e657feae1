"""Updates of controllers in threads of their own.

An asynchronous controller has interfaces of its own. The control cycle passes values between them
and those of the hardware: measured values before an update, commands after it. So an update works
on the values of one cycle, and all its commands hold from the same cycle on.
"""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from teleopctl.control.asynchronous.function_handler import LONGEST_CALL_S, AsyncFunctionHandler
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import ReturnType
from teleopctl.errors import InvalidParameterError
from teleopctl.robot import AsyncThread

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface
    from teleopctl.control.statistics import WorkStatistics

# Longest wait in the control cycle for a running update, in seconds.
_LONGEST_IN_CYCLE_S = 0.1
_WARNING_PERIOD_S = 20.0
_PREFIX = "async_parameters"


def async_thread(controller: ControllerInterface) -> AsyncThread:
    """Return the scheduling of a controller's thread, from its parameters ``async_parameters.…``.

    Raises:
        InvalidParameterError: A parameter has an invalid value.
    """
    policy = controller.auto_declare(f"{_PREFIX}.scheduling_policy", "synchronized")
    if policy == "detached":
        raise InvalidParameterError(
            "The controllers are not supported to run asynchronously in detached mode!"
        )
    if policy != "synchronized":
        raise InvalidParameterError(
            f"Parameter '{_PREFIX}.scheduling_policy' must be synchronized, got '{policy}'"
        )
    priority = controller.auto_declare(f"{_PREFIX}.thread_priority", AsyncThread().priority)
    if not 0 <= priority <= 99:
        raise InvalidParameterError(
            f"Parameter '{_PREFIX}.thread_priority' must be between 0 and 99, got {priority}"
        )
    affinity: Sequence[int] = controller.auto_declare(f"{_PREFIX}.cpu_affinity", [])
    warns = controller.auto_declare(f"{_PREFIX}.print_warnings", True)
    return AsyncThread(priority, tuple(affinity), print_warnings=warns)


class AsyncUpdate:
    """Updates of one controller in a thread of its own, triggered by the control cycle.

    Args:
        controller: Function that returns the instance of the controller.
        statistics: Statistics of the updates.
        thread: Scheduling of the thread.
        uses_threads: Function that returns False in lockstep, where the cycle updates the
            controller, and its commands hold from the next cycle on all the same.

    Attributes:
        total_triggers: Number of triggers since the activation.
        failed_triggers: Number of these that were missed, since an update was still running.
    """

    def __init__(
        self,
        controller: Callable[[], ControllerInterface],
        statistics: WorkStatistics,
        thread: AsyncThread,
        uses_threads: Callable[[], bool],
    ) -> None:
        self._controller = controller
        self._statistics = statistics
        self._warns = thread.print_warnings
        present = controller()
        self._handler = AsyncFunctionHandler(
            self._update,
            f"controller {present.name}",
            thread,
            present.update_rate,
            present.logger,
            uses_threads,
        )
        self._states: list[tuple[StateInterface, StateInterface]] = []
        self._commands: list[tuple[CommandInterface, CommandInterface]] = []
        self._has_commands = False
        self._is_paused = False
        self.total_triggers = self.failed_triggers = 0

    def separate_interfaces(self) -> None:
        """Replace the controller's interfaces by copies; called before its activation."""
        controller = self._controller()
        self._states = [(copy.copy(shared), shared) for shared in controller.state_interfaces]
        self._commands = [(copy.copy(shared), shared) for shared in controller.command_interfaces]
        controller.state_interfaces = [own for own, _ in self._states]
        controller.command_interfaces = [own for own, _ in self._commands]
        # Commands of the activation hold from the first cycle on.
        self._has_commands, self._is_paused = True, False
        self.total_triggers = self.failed_triggers = 0

    def interfaces_restorer(self) -> Callable[[], None]:
        """Return a function that makes the present copies of interfaces the ones that are used."""
        states, commands = self._states, self._commands

        def restore() -> None:
            self._states, self._commands = states, commands
            self._has_commands = False

        return restore

    def shared(self, commands: Sequence[CommandInterface]) -> list[CommandInterface]:
        """Return the hardware's interfaces of which the controller has the given copies."""
        copies = {id(own): shared for own, shared in self._commands}
        return [copies.get(id(command), command) for command in commands]

    def _update(self, time_ns: int, period: float) -> ReturnType:
        began_ns = time.perf_counter_ns()
        outcome = self._controller().update(time_ns, period) or ReturnType.OK
        self._statistics.add(began_ns, period)
        self._has_commands = True
        return outcome

    def hand_over(self) -> None:
        """Pass the commands of the last update to the hardware; called in each cycle."""
        if self._has_commands and not self._handler.is_busy:
            self._has_commands = False
            for own, shared in self._commands:
                shared.value = own.value

    def trigger(self, time_ns: int, period: float) -> ReturnType:
        """Start an update, and return the result of the last one.

        If an update is still running, count a missed trigger and return OK.

        Args:
            time_ns: Time of the cycle, nanoseconds.
            period: Seconds since the last trigger.

        Raises:
            Exception: The last update raised it.
        """
        if self._is_paused:
            return ReturnType.OK
        handler = self._handler
        self.total_triggers += 1
        if handler.is_busy:
            self.failed_triggers += 1
            if self._warns:
                self._controller().logger.warning(
                    f"The controller missed {self.failed_triggers} update cycles out of "
                    f"{self.total_triggers} total triggers.",
                    throttle_duration_sec=_WARNING_PERIOD_S,
                )
            return ReturnType.OK
        outcome = handler.take_outcome()
        if outcome is not ReturnType.OK:
            return outcome
        for own, measured in self._states:
            own.value = measured.value
        handler.trigger(time_ns, period)
        return ReturnType.OK

    def wait_until_idle(self) -> bool:
        """Wait for the running update; return False if it takes too long."""
        return self._handler.wait_until_idle()

    def pause(self, longest_s: float = LONGEST_CALL_S) -> None:
        """Start no more updates, and wait for the running one; log an error if it does not end."""
        self._is_paused = True
        if not self._handler.wait_until_idle(longest_s):
            controller = self._controller()
            controller.logger.error(
                f"Controller '{controller.name}' has not returned from update() for {longest_s:g} s"
            )

    def pause_in_cycle(self) -> None:
        """As `pause`, with a wait that the control cycle may take."""
        self.pause(_LONGEST_IN_CYCLE_S)

    def resume(self) -> None:
        """Start updates again with the next trigger, from the commands that hold then."""
        self._is_paused = False
        if not self._has_commands:
            for own, shared in self._commands:
                own.value = shared.value

    def finish(self) -> None:
        """Pass the commands of the deactivation to the hardware."""
        self._has_commands = True
        self.hand_over()

    def restart(self) -> None:
        """Discard the commands of the last update, after the joints have jumped."""
        self.pause_in_cycle()
        self._has_commands = False
        for command, _ in self._commands:
            command.value = math.nan
        for state, measured in self._states:
            state.value = measured.value
        self.resume()

    def stop(self) -> None:
        """End the thread."""
        self._handler.stop_thread()
