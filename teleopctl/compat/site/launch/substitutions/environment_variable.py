"""``launch.substitutions.environment_variable``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("env")
class EnvironmentVariable(KnownSubstitution):
    """The value of an environment variable, as the processes see it.

    Args:
        name: Its name.
        default_value: What stands for it where it is not set; None makes that an error.
    """

    parameters = ("name", "default_value")
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
        """What stands for it where it is not set, or None."""
        return self._default

    def template(self) -> Template:
        """Return it as the model has it."""
        default = () if self._default is None else (template(self._default),)
        return call("env", template(self._name), *default, source=self.describe())

    def describe(self) -> str:
        """Return it in words."""
        return f"EnvVar({in_words(self._name)})"
