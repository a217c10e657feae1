"""``launch.actions.timer_action``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Timer

from .._entities import steps
from .._texts import optional, template
from ..action import Action
from ..launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class TimerAction(Action):
    """Actions that are done later, once, unless they are cancelled before.

    Args:
        period: After how many seconds.
        actions: The actions.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self,
        *,
        period: float | SomeSubstitutionsType,
        actions: Iterable[LaunchDescriptionEntity],
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._period = optional(period) or template("0")
        self._actions = list(actions)
        self._is_cancelled = False

    @property
    def actions(self) -> list[LaunchDescriptionEntity]:
        """The actions."""
        return self._actions

    def cancel(self) -> None:
        """Do not do them, unless that has happened already."""
        self._is_cancelled = True

    def model_action(self) -> Timer:
        """Return what the model does for it."""
        return Timer(
            period=self._period,
            steps=steps(self._actions),
            is_cancelled=lambda: self._is_cancelled,
        )
