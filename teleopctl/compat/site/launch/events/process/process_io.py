"""``launch.events.process.process_io``."""

from typing import Any

from .running_process_event import RunningProcessEvent


class ProcessIO(RunningProcessEvent):
    """Base class of events of a process's input and output.

    Args:
        text: The bytes.
        fd: 0 for stdin, 1 for stdout, 2 for stderr.
        kwargs: Further arguments of `RunningProcessEvent`.
    """

    name = "launch.events.process.ProcessIO"

    # Any: arguments of `RunningProcessEvent.`
    def __init__(self, *, text: bytes, fd: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.text = text
        self.fd = fd

    @property
    def from_stdin(self) -> bool:
        """Whether the text is input on stdin."""
        return self.fd == 0

    @property
    def from_stdout(self) -> bool:
        """Whether the text is output on stdout."""
        return self.fd == 1

    @property
    def from_stderr(self) -> bool:
        """Whether the text is output on stderr."""
        return self.fd == 2


class ProcessStdin(ProcessIO):
    """Request to write to a process's stdin."""

    name = "launch.events.process.ProcessStdin"

    # Any: arguments of `RunningProcessEvent.`
    def __init__(self, *, text: bytes, **kwargs: Any) -> None:
        super().__init__(text=text, fd=0, **kwargs)


class ProcessStdout(ProcessIO):
    """Emitted when a process has written to stdout."""

    name = "launch.events.process.ProcessStdout"

    # Any: arguments of `RunningProcessEvent.`
    def __init__(self, *, text: bytes, **kwargs: Any) -> None:
        super().__init__(text=text, fd=1, **kwargs)


class ProcessStderr(ProcessIO):
    """Emitted when a process has written to stderr."""

    name = "launch.events.process.ProcessStderr"

    # Any: arguments of `RunningProcessEvent.`
    def __init__(self, *, text: bytes, **kwargs: Any) -> None:
        super().__init__(text=text, fd=2, **kwargs)
