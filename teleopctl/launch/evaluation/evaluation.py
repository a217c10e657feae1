"""From a launch file and its arguments to a plan.

Everything that can go wrong goes wrong here, before the first process starts: unknown packages,
missing arguments, robot descriptions that do not parse.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from teleopctl.errors import LaunchError, TeleopctlError, UsageError
from teleopctl.launch.evaluation import values
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.processes import ProcessBuilder, at_key, join_namespace
from teleopctl.launch.evaluation.substitutions import render
from teleopctl.launch.frontends.yaml.parser import parse_file
from teleopctl.launch.model.descriptions import (
    Action,
    DeclareArgument,
    Group,
    Include,
    LaunchFile,
    Let,
    Log,
    Place,
    PushNamespace,
    SetEnvironment,
    SetParameter,
    SetRemap,
    Shutdown,
    StartProcess,
    Step,
    Timer,
)
from teleopctl.launch.model.plan import LaunchPlan
from teleopctl.launch.model.template import Template
from teleopctl.packages import resolve_uri

_MAX_INCLUDES = 30
_LOG_LEVELS = {"DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"}


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
    evaluation = _Evaluation(
        context, ProcessBuilder(context, show_all_output=show_all_output, prefix=prefix)
    )
    evaluation.run_file(file)
    known = ", ".join(sorted(evaluation.declared)) or "none"
    unknown = [
        f"launch argument '{name}' is not declared by the launch file (declared: {known})"
        for name in arguments
        if name not in evaluation.declared
    ]
    return LaunchPlan(
        log_directory=log_directory,
        processes=evaluation.builder.plans,
        messages=evaluation.messages,
        warnings=[*context.warnings, *unknown],
        files=evaluation.builder.files,
    )


@contextmanager
def located(place: Place) -> Iterator[None]:
    """Put file and line before the message of an error raised in the block."""
    try:
        yield
    except TeleopctlError as error:
        if error.place is not None:
            raise
        raise error.at(str(place)) from error


class _Evaluation:
    def __init__(self, context: LaunchContext, builder: ProcessBuilder) -> None:
        self.context = context
        self.builder = builder
        self.messages: list[tuple[str, str]] = []
        self.declared: set[str] = set()
        self._depth = 0

    def run_file(self, file: LaunchFile) -> None:
        with self.context.inside(file.path):
            self._run(file.steps)

    def _run(self, steps: tuple[Step, ...]) -> None:
        for step in steps:
            with located(step.place):
                if all(
                    values.flag(self._text(condition.text)) == condition.expected
                    for condition in step.conditions
                ):
                    _HANDLERS[type(step.action)](self, step.action)

    def _text(self, text: Template) -> str:
        return render(text, self.context)

    def declare(self, action: DeclareArgument) -> None:
        self.declared.add(action.name)
        variables = self.context.scope.variables
        if action.name not in variables:
            if action.default is None:
                description = action.description or "no description given"
                raise UsageError(
                    f"Required launch argument '{action.name}' (description: '{description}') "
                    "was not provided",
                    hint=f"Give it behind the file: {action.name}:=VALUE",
                )
            variables[action.name] = self._text(action.default)
        value = variables[action.name]
        if action.choices and value not in action.choices:
            raise UsageError(
                f'Argument "{action.name}" provided value "{value}" is not valid. '
                f"Valid options are: {list(action.choices)}",
            )

    def let(self, action: Let) -> None:
        self.context.scope.variables[self._text(action.name)] = self._text(action.value)

    def set_environment(self, action: SetEnvironment) -> None:
        name = self._text(action.name)
        value = None if action.value is None else self._text(action.value)
        if action.append and value is not None:
            present = self.context.environment_value(name)
            value = f"{present}{os.pathsep}{value}" if present else value
        self.context.scope.environment[name] = value

    def include(self, action: Include) -> None:
        path = included_path(self._text(action.file), self.context.file)
        if self._depth >= _MAX_INCLUDES:
            raise LaunchError(f"{path} is included more than {_MAX_INCLUDES} levels deep")
        for name, value in action.arguments:
            self.context.scope.variables[self._text(name)] = self._text(value)
        self._depth += 1
        try:
            self.run_file(parse_file(path))
        finally:
            self._depth -= 1

    def group(self, action: Group) -> None:
        if action.scoped:
            with self.context.scoped():
                self._run(action.steps)
        else:
            self._run(action.steps)

    def timer(self, action: Timer) -> None:
        with at_key("period"):
            seconds = values.number(self._text(action.period))
        with self.context.delayed(seconds):
            self._run(action.steps)

    def push_namespace(self, action: PushNamespace) -> None:
        scope = self.context.scope
        scope.namespace = join_namespace(scope.namespace, self._text(action.namespace))

    def set_parameter(self, action: SetParameter) -> None:
        self.context.scope.parameters += (action.parameter,)

    def set_remap(self, action: SetRemap) -> None:
        self.context.scope.remaps += ((self._text(action.source), self._text(action.target)),)

    def log(self, action: Log) -> None:
        level = self._text(action.level).upper()
        if level == "WARN":
            level = "WARNING"
        if level not in _LOG_LEVELS:
            raise LaunchError(
                f"'level': expected one of {', '.join(sorted(_LOG_LEVELS))}, got '{level}'"
            )
        self.messages.append((level, self._text(action.message)))

    def shutdown(self, action: Shutdown) -> None:
        if self.context.start_delay > 0:
            raise LaunchError("'shutdown' cannot stand in a timer")
        reason = LaunchError(self._text(action.reason))
        # Whoever wrote the file knows better than its line number what the person has to know.
        reason.place = ""
        raise reason

    def start_process(self, action: StartProcess) -> None:
        self.builder.add(action)


def included_path(text: str, including: Path) -> Path:
    """Return the file that an ``include`` names: a path, or a file beside the including one."""
    path = resolve_uri(text)
    if path.is_absolute():
        return path
    beside = including.parent / path
    return beside if beside.is_file() else path.absolute()


_HANDLERS: dict[type[Action], Callable[..., None]] = {
    DeclareArgument: _Evaluation.declare,
    Group: _Evaluation.group,
    Include: _Evaluation.include,
    Let: _Evaluation.let,
    Log: _Evaluation.log,
    PushNamespace: _Evaluation.push_namespace,
    SetEnvironment: _Evaluation.set_environment,
    SetParameter: _Evaluation.set_parameter,
    SetRemap: _Evaluation.set_remap,
    Shutdown: _Evaluation.shutdown,
    StartProcess: _Evaluation.start_process,
    Timer: _Evaluation.timer,
}
