"""``launch.substitutions.python_expression``."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, in_words
from ..utilities import (
    ensure_argument_type,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_substitutions_type import SomeSubstitutionsType

_TEXT = (str, Substitution, Iterable)


@expose_substitution("eval")
class PythonExpression(KnownSubstitution):
    """Value of a Python expression.

    Args:
        expression: The expression.
        python_modules: Modules that it may use; what is in ``math`` is there without its name.
    """

    parameters = ("expression", "python_modules")
    required = 1

    def __init__(
        self,
        expression: SomeSubstitutionsType,
        python_modules: SomeSubstitutionsType = ("math",),
    ) -> None:
        super().__init__()
        ensure_argument_type(expression, _TEXT, "expression", "PythonExpression")
        ensure_argument_type(python_modules, _TEXT, "python_modules", "PythonExpression")
        self._expression = normalize_to_list_of_substitutions(expression)
        self._python_modules = normalize_to_list_of_substitutions(python_modules)

    # Any: as in KnownSubstitution.
    @classmethod
    def parse(cls, data: Sequence[Any]) -> tuple[type[Substitution], dict[str, Any]]:
        """Return the class and its constructor arguments, parsed from a launch file."""
        _, given = super().parse(data)
        if "python_modules" in given:
            names = given["python_modules"][0].text if given["python_modules"] else ""
            given["python_modules"] = [name.strip() for name in names.split(",") if name.strip()]
        return cls, given

    @property
    def expression(self) -> list[Substitution]:
        """The expression."""
        return self._expression

    @property
    def python_modules(self) -> list[Substitution]:
        """Modules that the expression may use."""
        return self._python_modules

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        modules = ", ".join(module.describe() for module in self._python_modules)
        return f"PythonExpr({in_words(self._expression)}, [{modules}])"

    def perform(self, context: LaunchContext) -> str:
        """Return the value of the expression."""
        known: dict[str, Any] = {}
        for name in map(context.perform_substitution, self._python_modules):
            module = importlib.import_module(name)
            if name == "math":
                known |= vars(module)
            known[name] = module
        expression = perform_substitutions(context, self._expression)
        return str(eval(expression, {}, known))  # noqa: S307 -- an expression of the launch file, which is a program itself
