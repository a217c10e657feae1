"""``launch.condition``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.launch import Condition as ModelCondition

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class Condition:
    """Decides whether an action is done.

    Args:
        predicate: Called with the launch's context.
    """

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def describe(self) -> str:
        """Return the condition in words."""
        return repr(self)

    def model_condition(self) -> ModelCondition | None:
        """Return the condition as the model has it; None where only `evaluate` knows."""
        return None

    def evaluate(self, context: LaunchContext) -> bool:
        """Tell whether it holds; one without a predicate does not."""
        return self._predicate is not None and self._predicate(context)
