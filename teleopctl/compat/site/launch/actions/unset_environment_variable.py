"""``launch.actions.unset_environment_variable``."""

from teleopctl.launch import UnsetEnvironment

from .._texts import template
from ._named import Named


class UnsetEnvironmentVariable(Named):
    """Removes an environment variable, where it is set."""

    def model_action(self) -> UnsetEnvironment:
        """Return what the model does for it."""
        return UnsetEnvironment(name=template(self._name))
