"""``launch.actions.pop_environment``."""

from teleopctl.launch import PopEnvironment as ModelAction

from ..action import Action


class PopEnvironment(Action):
    """Restores the environment that `PushEnvironment` saved last."""

    def model_action(self) -> ModelAction:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelAction()
