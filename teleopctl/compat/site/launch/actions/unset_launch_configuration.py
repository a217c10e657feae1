"""``launch.actions.unset_launch_configuration``."""

from teleopctl.launch import Unset

from .._texts import template
from ._named import Named


class UnsetLaunchConfiguration(Named):
    """Forgets a launch variable, where it is set."""

    def model_action(self) -> Unset:
        """Return what the model does for it."""
        return Unset(name=template(self._name))
