"""``launch_ros.actions.set_use_sim_time``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import optional, template
from launch.action import Action

from teleopctl.launch import SetUseSimTime as ModelSetUseSimTime

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetUseSimTime(Action):
    """Sets ``use_sim_time`` of the following nodes of the scope, and of the launch's timers.

    Args:
        value: Whether they follow ``/clock``.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, value: bool | SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._value = optional(value) or template("true")

    def model_action(self) -> ModelSetUseSimTime:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelSetUseSimTime(value=self._value)
