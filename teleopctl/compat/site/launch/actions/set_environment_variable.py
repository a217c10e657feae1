"""``launch.actions.set_environment_variable``."""

from teleopctl.launch import SetEnvironment

from .._texts import template
from ._named import NamedWithValue


class SetEnvironmentVariable(NamedWithValue):
    """Sets an environment variable."""

    def model_action(self) -> SetEnvironment:
        """Return the corresponding action of `teleopctl.launch`."""
        return SetEnvironment(name=template(self._name), value=template(self._value))
