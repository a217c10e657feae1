"""``launch.actions.push_environment``."""

from teleopctl.launch import PushEnvironment as ModelAction

from ..action import Action


class PushEnvironment(Action):
    """Remembers the environment, for `PopEnvironment`."""

    def model_action(self) -> ModelAction:
        """Return what the model does for it."""
        return ModelAction()
