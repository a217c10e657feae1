"""``launch.events.process.process_exited``."""

from typing import Any

from .running_process_event import RunningProcessEvent


class ProcessExited(RunningProcessEvent):
    """Emitted when a process has exited.

    Args:
        returncode: Exit status; negative for a signal.
        kwargs: Further arguments of `RunningProcessEvent`.
    """

    name = "launch.events.process.ProcessExited"

    # Any: arguments of `RunningProcessEvent.`
    def __init__(self, *, returncode: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.returncode = returncode
