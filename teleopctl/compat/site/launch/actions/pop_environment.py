"""``launch.actions.pop_environment``."""

from teleopctl.launch import PopEnvironment as ModelAction

from ..action import Action


class PopEnvironment(Action):
    """Brings back the environment that was remembered last."""

    def model_action(self) -> ModelAction:
        """Return what the model does for it."""
        return ModelAction()
