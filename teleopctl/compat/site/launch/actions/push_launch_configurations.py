"""``launch.actions.push_launch_configurations``."""

from teleopctl.launch import PushConfigurations

from ..action import Action


class PushLaunchConfigurations(Action):
    """Remembers the launch variables, for `PopLaunchConfigurations`."""

    def model_action(self) -> PushConfigurations:
        """Return what the model does for it."""
        return PushConfigurations()
