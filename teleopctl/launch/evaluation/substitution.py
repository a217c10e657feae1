"""Base class of substitutions in launch files, and their evaluation."""

from __future__ import annotations

import shlex

from teleopctl import plugins
from teleopctl.base.budget import BudgetError
from teleopctl.base.printable import shortened
from teleopctl.base.typed import Callable, Sequence
from teleopctl.errors import LaunchError, TeleopctlError, UnknownPluginError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.model.action import exposed_substitutions, load_launch_extensions
from teleopctl.launch.model.template import Call, ComputedText, Template


class Substitution:
    """Base of substitutions, such as ``$(find-pkg-share …)``: a function from arguments to text.

    Args:
        function: Returns the text for the evaluated arguments and the launch's context. Its
            exceptions end the launch with file and line of the substitution.
        least: Minimum number of arguments.
        most: Maximum number of arguments; None for any number.
        words: Whether the text is split into words, or none, as a whole word of a command line.
    """

    def __init__(
        self,
        function: Callable[[Sequence[str], LaunchContext], str],
        least: int = 0,
        most: int | None = None,
        *,
        words: bool = False,
    ) -> None:
        self._function = function
        self._least = least
        self._most = most
        self.words = words

    def evaluate(self, call: Call, context: LaunchContext) -> str:
        """Evaluate the arguments of a substitution's call, and return the resulting text.

        Raises:
            LaunchError: The call has the wrong number of arguments, or fails.
        """
        self._check_count(call)
        arguments = self.arguments(call, context)
        try:
            return self._function(arguments, context)
        except TeleopctlError:
            raise
        except Exception as error:
            raise LaunchError(f"{call.source}: {type(error).__name__}: {error}") from error

    def arguments(self, call: Call, context: LaunchContext) -> list[str]:
        """Return the arguments of a substitution's call, nested substitutions evaluated."""
        return [evaluated_text(argument.template, context) for argument in call.arguments]

    def _check_count(self, call: Call) -> None:
        least, most, count = self._least, self._most, len(call.arguments)
        if count < least or (most is not None and count > most):
            expected = str(least) if least == most else f"{least} to {most}"
            raise LaunchError(
                f"{call.source}: expected {expected if most is not None else f'at least {least}'} "
                f"argument(s), got {count}"
            )


def evaluated_text(template: Template, context: LaunchContext) -> str:
    """Return a launch file's text with all substitutions, such as ``$(var x)``, evaluated.

    Raises:
        TeleopctlError: A substitution is unknown, has the wrong number of arguments or fails, or
            the text exceeds the budget.
    """
    try:
        text = template.render(lambda call: _evaluate(call, context))
        context.characters.add(len(text))
    except BudgetError as error:
        raise LaunchError(f"'{shortened(template.source)}' makes {error}") from error
    return text


def evaluated_words(word: Template, context: LaunchContext) -> list[str]:
    """Return a command line word evaluated, as a list: several or none for some substitutions.

    Raises:
        TeleopctlError: Same as for `evaluated_text`.
    """
    text = evaluated_text(word, context)
    (part, *more) = word.parts or ("",)
    if more or not isinstance(part, Call) or part.name not in plugins.LAUNCH_SUBSTITUTIONS.builtin:
        return [text]
    substitution: Substitution = plugins.load(plugins.LAUNCH_SUBSTITUTIONS, part.name)
    return shlex.split(text) if substitution.words else [text]


def _evaluate(call: Call | ComputedText, context: LaunchContext) -> str:
    if not isinstance(call, Call):
        return call.evaluate(context)
    try:
        substitution: Substitution = plugins.load(plugins.LAUNCH_SUBSTITUTIONS, call.name)
    except UnknownPluginError as error:
        if call.name not in exposed_substitutions:
            load_launch_extensions()
        if call.name in exposed_substitutions:
            return evaluated_text(exposed_substitutions[call.name](call), context)
        raise LaunchError(
            f"{call.source}: unknown substitution '{call.name}'", hint=error.hint
        ) from error
    return substitution.evaluate(call, context)
