"""``launch.conditions.invalid_condition_expression_error``."""

from collections.abc import Iterable

from ..substitution import Substitution


class InvalidConditionExpressionError(ValueError):
    """Raised when the text of a condition is neither true nor false.

    Args:
        expression: Its text, evaluated.
        unexpanded_expression: The text before evaluation.
        valid_expressions: Texts that are valid.
    """

    def __init__(
        self,
        expression: str,
        unexpanded_expression: Iterable[Substitution],
        valid_expressions: Iterable[str],
    ) -> None:
        source = " + ".join(map(str, unexpanded_expression))
        super().__init__(
            f"invalid condition expression, expected one of [{', '.join(valid_expressions)}] "
            f"but got '{expression}', expanded from '{source}'"
        )
