"""``launch.events.include_launch_description``."""

from ..event import Event
from ..launch_description import LaunchDescription


class IncludeLaunchDescription(Event):
    """A launch description is to be included.

    Args:
        launch_description: The description.
    """

    name = "launch.events.IncludeLaunchDescription"

    def __init__(self, launch_description: LaunchDescription) -> None:
        self.launch_description = launch_description
