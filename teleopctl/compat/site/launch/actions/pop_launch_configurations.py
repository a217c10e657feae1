"""``launch.actions.pop_launch_configurations``."""

from teleopctl.launch import PopConfigurations

from ..action import Action


class PopLaunchConfigurations(Action):
    """Restores the launch configurations that `PushLaunchConfigurations` saved last."""

    def model_action(self) -> PopConfigurations:
        """Return the corresponding action of `teleopctl.launch`."""
        return PopConfigurations()
