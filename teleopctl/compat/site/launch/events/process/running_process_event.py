"""``launch.events.process.running_process_event``."""

from collections.abc import Mapping, Sequence

from ...action import Action
from ...event import Event


class RunningProcessEvent(Event):
    """Base class of events of a process.

    Args:
        action: The action that started it.
        name: Its name in the output.
        cmd: Program and arguments.
        cwd: The folder it was started in, or None for the launch's.
        env: Variables of its environment that differ from the launch's.
        pid: Its process id.
    """

    name = "launch.events.process.RunningProcessEvent"

    def __init__(
        self,
        *,
        action: Action,
        name: str,
        cmd: Sequence[str],
        cwd: str | None,
        env: Mapping[str, str] | None,
        pid: int,
    ) -> None:
        self.action = action
        self.execute_process_action = action
        self.process_name = name
        self.cmd = list(cmd)
        self.cwd = cwd
        self.env = env
        self.pid = pid
