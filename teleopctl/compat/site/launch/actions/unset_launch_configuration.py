"""``launch.actions.unset_launch_configuration``."""

from teleopctl.launch import Unset

from .._texts import template
from ._named import Named


class UnsetLaunchConfiguration(Named):
    """Removes a launch configuration, if it is set."""

    def model_action(self) -> Unset:
        """Return the corresponding action of `teleopctl.launch`."""
        return Unset(name=template(self._name))
