"""``launch.events.process.process_targeted_event``."""

import signal
from collections.abc import Callable

from teleopctl.launch import Launch, ProcessPart, ProcessPlan, SignalRequested

from ...action import Action
from ...event import Event


class ProcessTargetedEvent(Event):
    """Something that is meant for some of the processes.

    Args:
        process_matcher: Tells of the action that started a process whether it is meant.
    """

    name = "launch.events.process.ProcessTargetedEvent"

    def __init__(self, *, process_matcher: Callable[[Action], bool]) -> None:
        self.process_matcher = process_matcher

    def happen(self, launch: Launch) -> None:
        """Tell the processes that are meant."""

        def is_meant(process: ProcessPart, plan: ProcessPlan) -> bool:  # noqa: ARG001 -- ours know it
            return isinstance(process.origin, Action) and self.process_matcher(process.origin)

        launch.emit(SignalRequested(is_meant, self._number()))

    def _number(self) -> signal.Signals | None:
        """Return the signal that is sent; None for those of a shutdown."""
        return None


class ShutdownProcess(ProcessTargetedEvent):
    """A process is to end as in a shutdown, by harder ways where needed."""

    name = "launch.events.process.ShutdownProcess"


class SignalProcess(ProcessTargetedEvent):
    """A signal is to be sent.

    Args:
        signal_number: The signal, by its name or number.
        process_matcher: Tells of the action that started a process whether it is meant.
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
