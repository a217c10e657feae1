"""``launch.events.process.process_exited``."""

from typing import Any

from .running_process_event import RunningProcessEvent


class ProcessExited(RunningProcessEvent):
    """Emitted when a process has exited.

    Args:
        returncode: What it ended with; negative for a signal.
        kwargs: What `RunningProcessEvent` takes.
    """

    name = "launch.events.process.ProcessExited"

    # Any: the words of RunningProcessEvent.
    def __init__(self, *, returncode: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.returncode = returncode
