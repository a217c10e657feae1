"""``launch.actions.reset_environment``."""

from teleopctl.launch import ResetEnvironment as ModelAction

from ..action import Action


class ResetEnvironment(Action):
    """Brings back the environment that the launch was started with."""

    def model_action(self) -> ModelAction:
        """Return what the model does for it."""
        return ModelAction()
