"""``launch.events.include_launch_description``."""

from ..event import Event
from ..launch_description import LaunchDescription


class IncludeLaunchDescription(Event):
    """Request to include a launch description.

    Args:
        launch_description: The description.
    """

    name = "launch.events.IncludeLaunchDescription"

    def __init__(self, launch_description: LaunchDescription) -> None:
        self.launch_description = launch_description
