"""``launch.conditions.if_condition``."""

from teleopctl.launch import Condition as ModelCondition, flag

from .._texts import template
from ..condition import Condition
from ..launch_context import LaunchContext
from ..some_substitutions_type import SomeSubstitutionsType


class IfCondition(Condition):
    """Holds when a text is true.

    Args:
        predicate_expression: The text: ``true``, ``1``, ``false`` or ``0``.
    """

    def __init__(self, predicate_expression: SomeSubstitutionsType) -> None:
        super().__init__(predicate=self._holds)
        self._text = template(predicate_expression)

    def describe(self) -> str:
        """Return the condition in words."""
        return f"IfCondition({self._text.source})"

    def model_condition(self) -> ModelCondition:
        """Return the condition as the model has it."""
        return ModelCondition(self._text, True)

    def _holds(self, context: LaunchContext) -> bool:
        return flag(context.text(self._text)) is True
