"""``nav2_common.launch.launch_config_as_bool``."""

from __future__ import annotations

from launch import LaunchContext, Substitution
from launch.substitutions import LaunchConfiguration

_TRUE = ("true", "1", "yes", "on")


class LaunchConfigAsBool(Substitution):
    """Launch configuration, written in any way, as ``True`` or ``False``.

    Args:
        name: The launch configuration.
    """

    def __init__(self, name: str) -> None:
        super().__init__()
        self._config = LaunchConfiguration(name)

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"LaunchConfigAsBool({self._config.describe()})"

    def perform(self, context: LaunchContext) -> str:
        """Return ``True`` or ``False``."""
        return str(self._config.perform(context).strip().lower() in _TRUE)
