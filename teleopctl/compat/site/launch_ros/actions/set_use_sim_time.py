"""``launch_ros.actions.set_use_sim_time``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import optional, template
from launch.action import Action

from teleopctl.launch import SetUseSimTime as ModelSetUseSimTime

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetUseSimTime(Action):
    """The parameter ``use_sim_time`` of every following node, and the launch's own clock.

    Args:
        value: Whether they follow ``/clock``.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, value: bool | SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._value = optional(value) or template("true")

    def model_action(self) -> ModelSetUseSimTime:
        """Return what the model does for it."""
        return ModelSetUseSimTime(value=self._value)
