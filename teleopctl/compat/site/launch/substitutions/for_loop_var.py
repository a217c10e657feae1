"""``launch.substitutions.for_loop_var``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..frontend.expose import expose_substitution
from ..substitution import in_words
from ._with_default import WithDefault

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("for-var")
class ForEachVar(WithDefault):
    """Value of the enclosing `ForEach` in the current iteration."""

    name_in_texts = "for-var"

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        default = in_words(self._default or ())
        return f"{type(self).__name__}(name={in_words(self._name)}, default_value={default})"


@expose_substitution("index")
class ForLoopIndex(ForEachVar):
    """Index of the enclosing `ForLoop` in the current iteration, from 0.

    Args:
        name: Name of the index in the loop.
    """

    parameters = ("name",)

    def __init__(self, name: SomeSubstitutionsType) -> None:
        super().__init__(name)
