"""``launch.events.execution_complete``."""

from ..event import Event
from ..launch_description_entity import LaunchDescriptionEntity


class ExecutionComplete(Event):
    """An action has been done.

    Args:
        action: The action.
    """

    name = "launch.events.ExecutionComplete"

    def __init__(self, *, action: LaunchDescriptionEntity) -> None:
        self.action = action
