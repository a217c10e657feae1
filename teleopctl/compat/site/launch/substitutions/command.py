"""``launch.substitutions.command``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("command")
class Command(KnownSubstitution):
    """Standard output of a command.

    Args:
        command: The command line, which is split as a shell splits it.
        on_stderr: Reaction to output on stderr: ``fail``, ``ignore``, ``warn`` or
            ``capture``.
    """

    parameters = ("command", "on_stderr")
    required = 1

    def __init__(
        self, command: SomeSubstitutionsType, *, on_stderr: SomeSubstitutionsType = "fail"
    ) -> None:
        super().__init__()
        self._command = normalize_to_list_of_substitutions(command)
        self._on_stderr = normalize_to_list_of_substitutions(on_stderr)

    @property
    def command(self) -> list[Substitution]:
        """The command line."""
        return self._command

    @property
    def on_stderr(self) -> list[Substitution]:
        """Reaction to output on stderr."""
        return self._on_stderr

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        arguments = (template(self._command), template(self._on_stderr))
        return call("command", *arguments, source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"Command({in_words(self._command)})"
