"""``launch.substitution``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.errors import TeleopctlError
from teleopctl.launch import Argument, Call, Template

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class Substitution:
    """A text that is known only when the launch is evaluated.

    A subclass brings `perform`; those of ROS 2 bring `template`, what they are in a text.
    """

    def template(self) -> Template | None:
        """Return the substitution as the model has it; None where only `perform` knows."""
        return None

    def describe(self) -> str:
        """Return the substitution in words."""
        return type(self).__name__

    def perform(self, context: LaunchContext) -> str:
        """Return the text that it stands for.

        Raises:
            SubstitutionFailure: It cannot be evaluated.
        """
        from .substitutions.substitution_failure import SubstitutionFailure

        text = self.template()
        if text is None:
            raise NotImplementedError(f"{type(self).__name__} has no perform")
        try:
            return context.text(text)
        except TeleopctlError as error:
            raise SubstitutionFailure(error.message) from error


def call(name: str, *arguments: Template, source: str | None = None) -> Template:
    """Return the text that is one substitution of the model.

    Args:
        name: What stands behind ``$(`` in a text.
        arguments: Its arguments.
        source: How it is described; by default as one would write it.
    """
    written = " ".join([name, *(f"'{argument.source}'" for argument in arguments)])
    made = Call(
        name, tuple(Argument(argument, "'") for argument in arguments), source or f"$({written})"
    )
    return Template((made,), made.source)
