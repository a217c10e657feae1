"""``launch.substitutions.launch_configuration``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("var")
class LaunchConfiguration(KnownSubstitution):
    """Value of a launch configuration.

    Args:
        variable_name: Its name.
        default: Value if it is not set; with None, that is an error.
    """

    parameters = ("variable_name", "default")
    required = 1

    # object: texts, numbers and truth values are all in use.
    def __init__(
        self, variable_name: SomeSubstitutionsType, *, default: object | None = None
    ) -> None:
        super().__init__()
        self._name = normalize_to_list_of_substitutions(variable_name)
        self._default: list[Substitution] | None = None
        if default is not None:
            several = default if isinstance(default, Iterable) else (default,)
            self._default = normalize_to_list_of_substitutions(
                item if isinstance(item, Substitution) else str(item) for item in several
            )

    @property
    def variable_name(self) -> list[Substitution]:
        """Name of the launch configuration."""
        return self._name

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        default = () if self._default is None else (template(self._default),)
        return call("var", template(self._name), *default, source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"LaunchConfig({in_words(self._name)})"
