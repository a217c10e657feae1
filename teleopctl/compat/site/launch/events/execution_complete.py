"""``launch.events.execution_complete``."""

from ..event import Event
from ..launch_description_entity import LaunchDescriptionEntity


class ExecutionComplete(Event):
    """Emitted when an action has completed.

    Args:
        action: The action.
    """

    name = "launch.events.ExecutionComplete"

    def __init__(self, *, action: LaunchDescriptionEntity) -> None:
        self.action = action
