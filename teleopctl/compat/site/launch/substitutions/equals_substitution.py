"""``launch.substitutions.equals_substitution``."""

from __future__ import annotations

from typing import Any

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call
from ..utilities import normalize_to_list_of_substitutions
from ..utilities.type_utils import is_substitution


# Any: whatever is to be compared.
def _normalized(value: Any) -> list[Substitution]:
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    if value is None:
        return normalize_to_list_of_substitutions("")
    return normalize_to_list_of_substitutions(
        str(value).lower() if isinstance(value, bool) else str(value)
    )


@expose_substitution("equals")
class EqualsSubstitution(KnownSubstitution):
    """Whether two values are the same truth value, number or text.

    Args:
        left: One of them.
        right: The other one.
    """

    parameters = ("left", "right")
    required = 2
    name_in_texts = "equals"

    # object: texts, numbers and truth values are all in use.
    def __init__(self, left: object, right: object) -> None:
        super().__init__()
        self._left = _normalized(left)
        self._right = _normalized(right)

    @property
    def left(self) -> list[Substitution]:
        """One of them."""
        return self._left

    @property
    def right(self) -> list[Substitution]:
        """The other one."""
        return self._right

    def template(self) -> Template:
        """Return it as the model has it."""
        arguments = (template(self._left), template(self._right))
        return call(self.name_in_texts, *arguments, source=self.describe())

    def describe(self) -> str:
        """Return it in words."""
        return f"{type(self).__name__}({self._left} {self._right})"
