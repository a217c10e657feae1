"""``launch.substitution``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.launch import Call, SubstitutionArgument, Template

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class Substitution:
    """Text that is evaluated by the launch.

    A subclass overrides `perform`; ROS 2's own substitutions override `template` instead.
    """

    def template(self) -> Template | None:
        """Return the substitution as a template; None if only `perform` implements it."""
        return None

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return repr(self)

    def perform(self, context: LaunchContext) -> str:
        """Return the substitution's value.

        Raises:
            SubstitutionFailure: The substitution cannot be evaluated.
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
    """Base class of ROS 2's own substitutions, which XML and YAML launch files have by a name.

    Attributes:
        parameters: Constructor arguments for those in a launch file, in order.
        required: Number of required arguments.
    """

    parameters: ClassVar[tuple[str, ...]] = ()
    required: ClassVar[int] = 0

    # Any: each has arguments of its own.
    @classmethod
    def parse(cls, data: Sequence[Any]) -> tuple[type[Substitution], dict[str, Any]]:
        """Return the class and its constructor arguments, parsed from a launch file.

        Raises:
            TypeError: There are too few or too many of them.
        """
        least, most = cls.required, len(cls.parameters)
        if not least <= len(data) <= most:
            count = f"{least} arguments" if least == most else f"{least} to {most} arguments"
            raise TypeError(f"{cls.__name__} substitution expects {count}, got {len(data)}")
        return cls, dict(zip(cls.parameters, data, strict=False))


def in_words(substitutions: Iterable[Substitution]) -> str:
    """Return a readable form of a sequence of substitutions."""
    return " + ".join(substitution.describe() for substitution in substitutions)


def call(name: str, *arguments: Template, source: str | None = None) -> Template:
    """Return a template that consists of one substitution.

    Args:
        name: Name of the substitution, as after ``$(``.
        arguments: Its arguments.
        source: Readable form; by default as in a launch file.
    """
    written = " ".join([name, *(f"'{argument.source}'" for argument in arguments)])
    made = Call(
        name,
        tuple(SubstitutionArgument(argument, "'") for argument in arguments),
        source or f"$({written})",
    )
    return Template((made,), made.source)
