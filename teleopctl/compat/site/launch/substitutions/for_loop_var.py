"""``launch.substitutions.for_loop_var``."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("for-var")
class ForEachVar(KnownSubstitution):
    """A value of the turn of the `ForEach` around.

    Args:
        name: Its name.
        default_value: What stands for it where the turn has none; None makes that an error.
    """

    parameters: ClassVar[tuple[str, ...]] = ("name", "default_value")
    required = 1

    def __init__(
        self, name: SomeSubstitutionsType, *, default_value: SomeSubstitutionsType | None = None
    ) -> None:
        super().__init__()
        self._name = normalize_to_list_of_substitutions(name)
        self._default = (
            None if default_value is None else normalize_to_list_of_substitutions(default_value)
        )

    @property
    def name(self) -> list[Substitution]:
        """Its name."""
        return self._name

    @property
    def default_value(self) -> list[Substitution] | None:
        """What stands for it where the turn has none, or None."""
        return self._default

    def template(self) -> Template:
        """Return it as the model has it."""
        default = () if self._default is None else (template(self._default),)
        return call("for-var", template(self._name), *default, source=self.describe())

    def describe(self) -> str:
        """Return it in words."""
        default = in_words(self._default or ())
        return f"{type(self).__name__}(name={in_words(self._name)}, default_value={default})"


@expose_substitution("index")
class ForLoopIndex(ForEachVar):
    """The number of the turn of the `ForLoop` around, counted from 0.

    Args:
        name: What the loop calls it.
    """

    parameters = ("name",)

    def __init__(self, name: SomeSubstitutionsType) -> None:
        super().__init__(name)
