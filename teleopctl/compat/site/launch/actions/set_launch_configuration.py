"""``launch.actions.set_launch_configuration``."""

from teleopctl.launch import Let

from .._texts import template
from ._named import NamedWithValue


class SetLaunchConfiguration(NamedWithValue):
    """Sets a launch variable."""

    def model_action(self) -> Let:
        """Return what the model does for it."""
        return Let(name=template(self._name), value=template(self._value))
