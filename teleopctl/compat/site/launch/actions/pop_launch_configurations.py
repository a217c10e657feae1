"""``launch.actions.pop_launch_configurations``."""

from teleopctl.launch import PopConfigurations

from ..action import Action


class PopLaunchConfigurations(Action):
    """Brings back the launch variables that were remembered last."""

    def model_action(self) -> PopConfigurations:
        """Return what the model does for it."""
        return PopConfigurations()
