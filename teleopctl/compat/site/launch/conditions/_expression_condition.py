"""Base class of conditions on an expression that is true or false."""

from __future__ import annotations

from typing import ClassVar

from teleopctl.launch import Condition as ModelCondition

from .._texts import template
from ..condition import Condition
from ..launch_context import LaunchContext
from ..some_substitutions_type import SomeSubstitutionsType
from ..utilities import normalize_to_list_of_substitutions
from .evaluate_condition_expression_impl import evaluate_condition_expression


class ExpressionCondition(Condition):
    """Base class of conditions that hold if an expression has a truth value.

    Args:
        predicate_expression: The text: ``true``, ``1``, ``false`` or ``0``.
    """

    _name: ClassVar[str]
    _holds_if: ClassVar[bool]

    def __init__(self, predicate_expression: SomeSubstitutionsType) -> None:
        super().__init__(predicate=self._holds)
        self._expression = normalize_to_list_of_substitutions(predicate_expression)

    def describe(self) -> str:
        """Return a readable form of the condition."""
        return f"{self._name}({template(self._expression).source})"

    def model_condition(self) -> ModelCondition:
        """Return the corresponding condition of `teleopctl.launch`."""
        return ModelCondition(template(self._expression), self._holds_if)

    def _holds(self, context: LaunchContext) -> bool:
        return evaluate_condition_expression(context, self._expression) is self._holds_if
