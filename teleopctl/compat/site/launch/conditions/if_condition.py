"""``launch.conditions.if_condition``."""

from teleopctl.launch import Condition as ModelCondition

from .._texts import template
from ..condition import Condition
from ..launch_context import LaunchContext
from ..some_substitutions_type import SomeSubstitutionsType
from ..utilities import normalize_to_list_of_substitutions
from .evaluate_condition_expression_impl import evaluate_condition_expression


class IfCondition(Condition):
    """Holds if an expression evaluates to true.

    Args:
        predicate_expression: The text: ``true``, ``1``, ``false`` or ``0``.
    """

    def __init__(self, predicate_expression: SomeSubstitutionsType) -> None:
        super().__init__(predicate=self._holds)
        self._expression = normalize_to_list_of_substitutions(predicate_expression)

    def describe(self) -> str:
        """Return a readable form of the condition."""
        return f"IfCondition({template(self._expression).source})"

    def model_condition(self) -> ModelCondition:
        """Return the corresponding condition of `teleopctl.launch`."""
        return ModelCondition(template(self._expression), True)

    def _holds(self, context: LaunchContext) -> bool:
        return evaluate_condition_expression(context, self._expression)
