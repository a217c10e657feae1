"""``launch.actions.reset_environment``."""

from teleopctl.launch import ResetEnvironment as ModelAction

from ..action import Action


class ResetEnvironment(Action):
    """Restores the environment at the start of the launch."""

    def model_action(self) -> ModelAction:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelAction()
