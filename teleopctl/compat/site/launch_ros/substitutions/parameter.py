"""``launch_ros.substitutions.parameter``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from launch._texts import optional, template
from launch.substitution import Substitution, call

from teleopctl.launch import Template

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class Parameter(Substitution):
    """Value of a global parameter that `SetParameter` has set.

    Args:
        name: Its name.
        default: Value if it is not set; with None, that is an error.
    """

    # object: texts, numbers and truth values are all in use.
    def __init__(self, name: SomeSubstitutionsType, *, default: object | None = None) -> None:
        super().__init__()
        self._name = template(name)
        self._default = optional(default)

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        default = () if self._default is None else (self._default,)
        return call("param", self._name, *default, source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"Parameter(name='{self._name.source}')"
