"""``launch.actions.push_environment``."""

from teleopctl.launch import PushEnvironment as ModelAction

from ..action import Action


class PushEnvironment(Action):
    """Saves the environment for `PopEnvironment`."""

    def model_action(self) -> ModelAction:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelAction()
