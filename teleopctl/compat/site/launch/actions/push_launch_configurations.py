"""``launch.actions.push_launch_configurations``."""

from teleopctl.launch import PushConfigurations

from ..action import Action


class PushLaunchConfigurations(Action):
    """Saves the launch configurations for `PopLaunchConfigurations`."""

    def model_action(self) -> PushConfigurations:
        """Return the corresponding action of `teleopctl.launch`."""
        return PushConfigurations()
