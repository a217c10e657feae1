"""``launch.substitution``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.launch import Call, SubstitutionArgument, Template

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
        return repr(self)

    def perform(self, context: LaunchContext) -> str:
        """Return the text that it stands for.

        Raises:
            SubstitutionFailure: It cannot be evaluated.
        """
        from .substitutions.substitution_failure import SubstitutionFailure

        text = self.template()
        if text is None:
            raise NotImplementedError("perform() not implemented for Substitution base class.")
        try:
            return context.text(text)
        except TeleopctlError as error:
            raise SubstitutionFailure(error.message) from error


class KnownSubstitution(Substitution):
    """One of ROS 2's own, which the text front ends have under a name of their own.

    Attributes:
        parameters: What its arguments in a text are called, in order.
        required: How many of them have to be there.
    """

    parameters: ClassVar[tuple[str, ...]] = ()
    required: ClassVar[int] = 0

    # Any: each one takes words of its own.
    @classmethod
    def parse(cls, data: Sequence[Any]) -> tuple[type[Substitution], dict[str, Any]]:
        """Return the class and its arguments, from those that stand in a text.

        Raises:
            TypeError: There are too few or too many of them.
        """
        least, most = cls.required, len(cls.parameters)
        if not least <= len(data) <= most:
            count = f"{least} arguments" if least == most else f"{least} to {most} arguments"
            raise TypeError(f"{cls.__name__} substitution expects {count}, got {len(data)}")
        return cls, dict(zip(cls.parameters, data, strict=False))


def in_words(substitutions: Iterable[Substitution]) -> str:
    """Return substitutions in a row in words."""
    return " + ".join(substitution.describe() for substitution in substitutions)


def call(name: str, *arguments: Template, source: str | None = None) -> Template:
    """Return the text that is one substitution of the model.

    Args:
        name: What stands behind ``$(`` in a text.
        arguments: Its arguments.
        source: How it is described; by default as one would write it.
    """
    written = " ".join([name, *(f"'{argument.source}'" for argument in arguments)])
    made = Call(
        name,
        tuple(SubstitutionArgument(argument, "'") for argument in arguments),
        source or f"$({written})",
    )
    return Template((made,), made.source)
