"""What a text front end has read, as an entity."""

from __future__ import annotations

from teleopctl import launch as model

from ..action import Action


class ReadStep(Action):
    """An entry of a launch file.

    Args:
        step: The entry.
    """

    def __init__(self, step: model.Step) -> None:
        super().__init__()
        self._step = step

    def model_action(self) -> model.Action:
        """Return what the model does for it."""
        return model.IncludeSteps(steps=(self._step,), arguments=())
