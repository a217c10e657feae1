"""``launch.events.execution_complete``."""

from ..action import Action
from ..event import Event


class ExecutionComplete(Event):
    """An action has been done.

    Args:
        action: The action.
    """

    name = "launch.events.ExecutionComplete"

    def __init__(self, *, action: Action) -> None:
        self.action = action
