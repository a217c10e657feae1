"""``launch.actions.set_launch_configuration``."""

from teleopctl.launch import Let

from .._texts import template
from ._named import NamedWithValue


class SetLaunchConfiguration(NamedWithValue):
    """Sets a launch configuration."""

    def model_action(self) -> Let:
        """Return the corresponding action of `teleopctl.launch`."""
        return Let(name=template(self._name), value=template(self._value))
