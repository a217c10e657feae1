"""``launch.actions.timer_action``."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from os import PathLike
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.launch import Step, TimedEntities, dataclass

from .._entities import steps
from .._texts import optional, template
from ..action import Action
from ..events.timer_event import TimerEvent
from ..launch_context import LaunchContext
from ..launch_description_entity import LaunchDescriptionEntity
from ..substitution import Substitution
from ..utilities import ensure_argument_type
from ..utilities.type_utils import NormalizedValueType, normalize_typed_substitution

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType

_TEXT = (str, PathLike, Substitution, Iterable)


class TimerAction(Action):
    """Executes actions once after a period, unless it is cancelled before.

    Args:
        period: After how many seconds.
        actions: The actions.
        cancel_on_shutdown: Whether the end of the launch cancels them.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        period: float | SomeSubstitutionsType,
        actions: Iterable[LaunchDescriptionEntity],
        cancel_on_shutdown: bool | SomeSubstitutionsType = True,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        # An int is accepted too, unlike in ROS 2.
        ensure_argument_type(period, (*_TEXT, float, int), "period", "TimerAction")
        ensure_argument_type(actions, Iterable, "actions", "TimerAction")
        if isinstance(period, str):
            warnings.warn(
                "The parameter 'period' must be a float or substitution,"
                "passing a string literal was deprecated",
                stacklevel=2,
            )
        self._given = float(period) if isinstance(period, str | int) else period
        self._period = optional(self._given) or template("0")
        self._actions = list(actions)
        self._cancel_on_shutdown = optional(cancel_on_shutdown)
        self._is_cancelled = False

    @property
    def period(self) -> NormalizedValueType:
        """Period in seconds."""
        return normalize_typed_substitution(self._given, float)

    @property
    def actions(self) -> list[LaunchDescriptionEntity]:
        """The actions."""
        return self._actions

    def describe(self) -> str:
        """Return a readable form of the action."""
        return f"TimerAction(period={self.period}, actions=<actions>)"

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the actions, with the description of their time."""
        return [(f"{self.period} seconds pass without being canceled", self._actions)]

    def cancel(self) -> None:
        """Cancel the timer; without effect once it has fired."""
        self._is_cancelled = True

    def done(self, context: LaunchContext) -> None:
        """Do nothing: the last step of the timer completes the action."""

    def waiting_steps(self) -> tuple[model.Step, ...]:
        """Return the steps that are executed when the timer fires."""
        came = Step(self.defined_at, (), _Came(self))
        return (came, *steps(self._actions), Step(self.defined_at, (), _Done(self)))

    def model_action(self) -> TimedEntities:
        """Return the corresponding action of `teleopctl.launch`."""
        return TimedEntities(
            period=self._period,
            steps=self.waiting_steps(),
            is_cancelled=lambda: self._is_cancelled,
            cancel_on_shutdown=self._cancel_on_shutdown,
        )


@dataclass(frozen=True, slots=True)
class _Came(model.Action):
    """Action of `teleopctl.launch` that emits the event of a timer."""

    timer: TimerAction

    def evaluate(self, launch: model.Launch) -> None:
        """Emit `TimerEvent` if an event handler matches it."""
        event = TimerEvent(timer_action=self.timer)
        if not launch.is_trial and launch.has_handler_for(event):
            launch.emit(event)


@dataclass(frozen=True, slots=True)
class _Done(model.Action):
    """Action of `teleopctl.launch` that completes a timer."""

    timer: TimerAction

    def evaluate(self, launch: model.Launch) -> None:
        """Emit `ExecutionComplete` if an event handler matches it."""
        if not launch.is_trial:
            self.timer.tell_completion(LaunchContext.with_launch(launch))
