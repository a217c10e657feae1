"""``launch.condition``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.launch import Condition as ModelCondition

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class Condition:
    """Condition of an action; evaluates a predicate.

    Args:
        predicate: Called with the launch's context.
    """

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def describe(self) -> str:
        """Return a readable form of the condition."""
        return repr(self)

    def model_condition(self) -> ModelCondition | None:
        """Return the corresponding condition of `teleopctl.launch`; None if there is none."""
        return None

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether the condition holds; False without a predicate."""
        return self._predicate is not None and self._predicate(context)
