"""``launch.conditions.unless_condition``."""

from ._expression_condition import ExpressionCondition


class UnlessCondition(ExpressionCondition):
    """Holds if an expression evaluates to false.

    Args:
        predicate_expression: The text: ``true``, ``1``, ``false`` or ``0``.
    """

    _name = "UnlessCondition"
    _holds_if = False
