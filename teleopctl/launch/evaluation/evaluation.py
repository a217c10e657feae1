"""From a launch file and its arguments to a plan.

Everything that can go wrong goes wrong here, before the first process starts: unknown packages,
missing arguments, robot descriptions that do not parse.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from teleopctl.errors import LaunchError, TeleopctlError, did_you_mean
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.processes import ProcessBuilder
from teleopctl.launch.evaluation.substitution import render
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, LaunchFile, Step
from teleopctl.launch.model.descriptions import Condition, Place, Process
from teleopctl.launch.model.plan import LaunchPlan
from teleopctl.launch.model.scope import Scope
from teleopctl.launch.model.template import Template

_MAX_INCLUDES = 30


def evaluate(
    file: LaunchFile,
    arguments: Mapping[str, str],
    log_directory: Path,
    *,
    show_all_output: bool = False,
    prefix: str | None = None,
) -> LaunchPlan:
    """Evaluate a launch file.

    Args:
        file: The parsed file.
        arguments: Launch arguments by name.
        log_directory: The launch's folder for logs and parameter files.
        show_all_output: Whether stdout of every process appears on the screen.
        prefix: Words put before the command line of every process, or None.

    Raises:
        TeleopctlError: When anything in it cannot be evaluated; the message has file and line.
    """
    context = LaunchContext(arguments, log_directory)
    builder = ProcessBuilder(context, show_all_output=show_all_output, prefix=prefix)
    evaluation = Evaluation(context, builder)
    evaluation.run_file(file)
    unknown = undeclared(arguments, context.declared)
    return LaunchPlan(
        log_directory=log_directory,
        processes=builder.plans,
        messages=evaluation.messages,
        warnings=[*context.warnings, *unknown],
        files=builder.files,
    )


def undeclared(arguments: Iterable[str], declared: Collection[str]) -> list[str]:
    """Say which of some launch arguments nobody declares."""
    known = ", ".join(sorted(declared)) or "none"
    return [
        f"launch argument '{name}' is not declared by the launch file (declared: {known})"
        + (f". {guess}" if (guess := did_you_mean(name, declared)) else "")
        for name in arguments
        if name not in declared
    ]


@contextmanager
def located(place: Place) -> Iterator[None]:
    """Put file and line before the message of an error raised in the block."""
    try:
        yield
    except TeleopctlError as error:
        if error.place is not None:
            raise
        raise error.at(str(place)) from error


class Evaluation:
    """A launch while it is being evaluated; a `teleopctl.launch.model.action.Launch`.

    Args:
        context: What substitutions look at.
        builder: Makes the processes.

    Attributes:
        messages: Lines of ``log`` actions, as level and text.
    """

    def __init__(self, context: LaunchContext, builder: ProcessBuilder) -> None:
        self.messages: list[tuple[str, str]] = []
        self._context = context
        self._builder = builder
        self._depth = 0

    @property
    def scope(self) -> Scope:
        """Launch variables, environment, namespace and so on, as the next step sees them."""
        return self._context.scope

    @property
    def file(self) -> Path:
        """The launch file that is being evaluated."""
        return self._context.file

    @property
    def start_delay(self) -> float:
        """Seconds from the start of the launch to that of the next process."""
        return self._context.start_delay

    def text(self, text: Template) -> str:
        """Evaluate the substitutions of a text."""
        return render(text, self._context)

    def environment_value(self, name: str) -> str | None:
        """An environment variable as the processes will see it, or None."""
        return self._context.environment_value(name)

    def run_file(self, file: LaunchFile) -> None:
        """Evaluate a launch file."""
        with self._context.inside(file.path):
            self.run(file.steps)

    def run(self, steps: tuple[Step, ...]) -> None:
        """Evaluate further steps."""
        for step in steps:
            with located(step.place):
                if all(self._holds(condition) for condition in step.conditions):
                    self._evaluate(step.action)

    def _holds(self, condition: Condition) -> bool:
        text = self.text(condition.text)
        with self._context.reading(condition.text):
            return values.flag(text) == condition.expected

    def _evaluate(self, action: Action) -> None:
        try:
            further = tuple(action.evaluate(self) or ())
        except TeleopctlError:
            raise
        except Exception as error:
            raise LaunchError(
                f"{type(action).__name__} failed: {type(error).__name__}: {error}"
            ) from error
        for one in further:
            self._evaluate(one)

    def scoped(self) -> AbstractContextManager[None]:
        """Restore variables, environment, namespace and so on at the end of the block."""
        return self._context.scoped()

    def delayed(self, seconds: float) -> AbstractContextManager[None]:
        """Start the block's processes later."""
        return self._context.delayed(seconds)

    def include(self, path: Path) -> None:
        """Evaluate another launch file."""
        if self._depth >= _MAX_INCLUDES:
            raise LaunchError(f"{path} is included more than {_MAX_INCLUDES} levels deep")
        self._depth += 1
        try:
            self.run_file(read_launch_file(path))
        finally:
            self._depth -= 1

    def declare(self, name: str) -> None:
        """Make a launch argument known."""
        self._context.declared.add(name)

    def say(self, level: str, message: str) -> None:
        """Show a line to the person in front of the terminal when the launch starts."""
        self.messages.append((level, message))

    def start(self, process: Process) -> None:
        """Add the process of a ``node`` or an ``executable``."""
        self._builder.add(process)
