"""``launch.conditions.launch_configuration_not_equals``."""

from ..launch_context import LaunchContext
from .launch_configuration_equals import LaunchConfigurationEquals


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """Holds unless a launch configuration has a value; `NotEqualsSubstitution` replaces it."""

    def _holds(self, context: LaunchContext) -> bool:
        return not super()._holds(context)
