"""``launch_ros.actions.set_ros_log_dir``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from teleopctl.launch import SetRosLogDirectory

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetROSLogDir(Action):
    """Sets the log folder of the following nodes of the scope.

    Args:
        new_log_dir: The folder.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, new_log_dir: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._folder = template(new_log_dir)

    def model_action(self) -> SetRosLogDirectory:
        """Return the corresponding action of `teleopctl.launch`."""
        return SetRosLogDirectory(folder=self._folder)
