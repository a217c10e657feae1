"""What stands in a launch file, as one entity."""

from teleopctl.launch import Include

from .._texts import template
from ..action import Action


class FileContents(Action):
    """All entries of a launch file of any kind.

    Args:
        path: The file.
    """

    def __init__(self, path: str) -> None:
        super().__init__()
        self._path = path

    def model_action(self) -> Include:
        """Return what the model does for it."""
        return Include(file=template(self._path), arguments=())
