"""Hardware components: plug-ins with lifecycle state and statistics."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.base.exception_origin import with_origin
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType, State
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

    Attributes:
        lifecycle_state: Lifecycle state of the component.
        reads: Statistics of the duration and rate of reads.
        writes: Statistics of the duration and rate of writes.
    """

    def __init__(self, hardware: HardwareComponentInterface, logger: RcutilsLogger) -> None:
        self.hardware = hardware
        self.name: str = hardware.info.name
        self.state_interfaces: list[StateInterface] = list(hardware.state_interfaces.values())
        self.command_interfaces: list[CommandInterface] = list(hardware.command_interfaces.values())
        self.lifecycle_state = State.UNCONFIGURED
        self.reads = WorkStatistics()
        self.writes = WorkStatistics()
        self._logger = logger

    def initialize(self) -> bool:
        """Call the plug-in's ``on_init``; return False unless it succeeds."""
        self._logger.info(f"Initialize hardware '{self.name}' ")
        if self._call(self.hardware.on_init) is not CallbackReturn.SUCCESS:
            self._logger.error(f"Failed to initialize hardware '{self.name}'")
            return False
        self._logger.info(f"Successful initialization of hardware '{self.name}'")
        return True

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
            self._recover()
        return False

    def _finalize(self) -> bool:
        self._call(self.hardware.on_shutdown)
        self._enter(State.FINALIZED)
        return True

    def _recover(self) -> None:
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
        outcome = self._exchange(self.hardware.read, time_ns, period)
        self.reads.add(began_ns, period)
        return outcome

    def write(self, time_ns: int, period: float) -> ReturnType:
        """Call ``write`` if active, on failure also ``on_error``; return the result."""
        if self.lifecycle_state is not State.ACTIVE:
            return ReturnType.OK
        began_ns = time.perf_counter_ns()
        outcome = self._exchange(self.hardware.write, time_ns, period)
        self.writes.add(began_ns, period)
        return outcome

    def _exchange(
        self, function: Callable[[int, float], ReturnType | None], time_ns: int, period: float
    ) -> ReturnType:
        try:
            outcome = function(time_ns, period) or ReturnType.OK
            if not isinstance(outcome, ReturnType):
                raise TypeError(f"it returned {outcome!r} in the place of a ReturnType")
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a plug-in's failure must not end the loop
            self._logger.error(
                f"Hardware '{self.name}' raised in {function.__name__}: {with_origin(error)}"
            )
            outcome = ReturnType.ERROR
        if outcome is ReturnType.ERROR:
            self._recover()
        elif outcome is ReturnType.DEACTIVATE:
            self._take(State.INACTIVE)
        return outcome

    def _call(self, function: Callable[[], CallbackReturn | None]) -> CallbackReturn:
        try:
            return function() or CallbackReturn.SUCCESS
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a plug-in's failure is the component's
            self._logger.error(
                f"Hardware '{self.name}' raised in {function.__name__}: {with_origin(error)}"
            )
            return CallbackReturn.ERROR
