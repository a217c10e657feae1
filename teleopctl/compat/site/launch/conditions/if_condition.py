"""``launch.conditions.if_condition``."""

from ._expression_condition import ExpressionCondition


class IfCondition(ExpressionCondition):
    """Holds if an expression evaluates to true.

    Args:
        predicate_expression: The text: ``true``, ``1``, ``false`` or ``0``.
    """

    _name = "IfCondition"
    _holds_if = True
