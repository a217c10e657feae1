"""``launch.substitutions.local_substitution``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..substitution import Substitution
from ..utilities import ensure_argument_type

if TYPE_CHECKING:
    from ..launch_context import LaunchContext


class LocalSubstitution(Substitution):
    """Value of a local variable of the launch context, such as ``event``.

    Args:
        expression: Its name, with attributes behind it, such as ``event.process_name``.
        description: Readable form; None for the expression.
    """

    def __init__(self, expression: str, description: str | None = None) -> None:
        super().__init__()
        ensure_argument_type(expression, str, "expression", "LocalSubstitution")
        self._expression = expression
        self._description = description

    @property
    def expression(self) -> str:
        """Name of the variable, with attributes."""
        return self._expression

    @property
    def description(self) -> str | None:
        """Description, or None."""
        return self._description

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        words = self._expression if self._description is None else self._description
        return f"LocalVar('{words}')"

    def perform(self, context: LaunchContext) -> str:
        """Return the value of the variable."""
        return str(eval(f"found.{self._expression}", {"found": context.locals}))  # noqa: S307 -- an expression of the launch file, which is a program itself
