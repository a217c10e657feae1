"""``launch.events.process.process_targeted_event``."""

import signal
from collections.abc import Callable

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

    @property
    def signal_name(self) -> str:
        """The signal's name, such as ``SIGINT``."""
        return self.signal.name
