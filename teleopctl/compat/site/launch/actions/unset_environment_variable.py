"""``launch.actions.unset_environment_variable``."""

from teleopctl.launch import UnsetEnvironment

from .._texts import template
from ._named import Named


class UnsetEnvironmentVariable(Named):
    """Removes an environment variable, if it is set."""

    def model_action(self) -> UnsetEnvironment:
        """Return the corresponding action of `teleopctl.launch`."""
        return UnsetEnvironment(name=template(self._name))
