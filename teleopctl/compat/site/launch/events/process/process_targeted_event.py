"""``launch.events.process.process_targeted_event``."""

import signal
from collections.abc import Callable

from teleopctl.launch import Launch, ProcessPart, ProcessPlan, SignalRequested

from ...action import Action
from ...event import Event


class ProcessTargetedEvent(Event):
    """Base class of events that are addressed to processes by a matcher.

    Args:
        process_matcher: Returns whether the event is for the process of an action.
    """

    name = "launch.events.process.ProcessTargetedEvent"

    def __init__(self, *, process_matcher: Callable[[Action], bool]) -> None:
        self.process_matcher = process_matcher

    def happen(self, launch: Launch) -> None:
        """Send the signal to the processes that the matcher selects."""

        def is_meant(process: ProcessPart, plan: ProcessPlan) -> bool:  # noqa: ARG001 -- for the events of subclasses
            return isinstance(process.origin, Action) and self.process_matcher(process.origin)

        launch.emit(SignalRequested(is_meant, self._number()))

    def _number(self) -> signal.Signals | None:
        """Return the signal to send; None for a shutdown's sequence of signals."""
        return None


class ShutdownProcess(ProcessTargetedEvent):
    """Request to end a process as a shutdown does: SIGINT, SIGTERM, SIGKILL."""

    name = "launch.events.process.ShutdownProcess"


class SignalProcess(ProcessTargetedEvent):
    """Request to send a signal to a process.

    Args:
        signal_number: The signal, by its name or number.
        process_matcher: Returns whether the event is for the process of an action.
    """

    name = "launch.events.process.SignalProcess"

    def __init__(
        self,
        *,
        signal_number: str | signal.Signals | int,
        process_matcher: Callable[[Action], bool],
    ) -> None:
        super().__init__(process_matcher=process_matcher)
        if isinstance(signal_number, str):
            self.signal = signal.Signals[signal_number]
        else:
            self.signal = signal.Signals(signal_number)

    def _number(self) -> signal.Signals:
        return self.signal

    @property
    def signal_name(self) -> str:
        """The signal's name, such as ``SIGINT``."""
        return self.signal.name
