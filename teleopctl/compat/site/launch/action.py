"""``launch.action``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl import launch as model

from .condition import Condition
from .launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class Action(LaunchDescriptionEntity):
    """Something that is done when a launch is evaluated.

    A subclass brings `execute`; those of ROS 2 bring `model_action`, what the model does for them.

    Args:
        condition: Has to hold when it is done.
    """

    def __init__(self, *, condition: Condition | None = None) -> None:
        super().__init__()
        self._condition = condition

    @property
    def condition(self) -> Condition | None:
        """What has to hold when it is done, or None."""
        return self._condition

    def describe(self) -> str:
        """Return the action in words."""
        return f"{type(self).__name__}({id(self)})"

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Do it where its condition holds, and return what is to be visited in its place."""
        if self._condition is None or self._condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Do it, and return what is to be visited in its place."""
        context.launch.perform(self.model_action())
        return None

    def model_action(self) -> model.Action:
        """Return what the model does for it."""
        raise NotImplementedError(f"{type(self).__name__} has no execute")
