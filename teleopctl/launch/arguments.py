"""What ``launch --show-args`` prints: the arguments of a launch file and of those it includes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from teleopctl.errors import TeleopctlError
from teleopctl.launch.actions.loops import For, ForEach
from teleopctl.launch.actions.nesting import Group, Include, Timer, included_path
from teleopctl.launch.actions.settings import DeclareArgument, Let
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.evaluation import undeclared
from teleopctl.launch.evaluation.substitution import render
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.action import Step
from teleopctl.launch.model.template import Template

_MAX_DEPTH = 30


def describe_arguments(file: Path, arguments: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines that ``ros2 launch --show-args`` prints.

    Raises:
        TeleopctlError: When the file cannot be read.
    """
    yield "Arguments (pass arguments as '<name>:=<value>'):"
    context = LaunchContext(arguments, Path())
    seen: set[str] = set()
    for argument in _declared(file, context, 0):
        if argument.name in seen:
            continue
        seen.add(argument.name)
        yield ""
        yield f"    '{argument.name}':"
        yield f"        {argument.in_words}"
        if argument.default is not None:
            yield f"        (default: {_describe(argument.default)})"
    if not seen:
        yield ""
        yield "  No arguments."


def argument_names(file: Path) -> list[str]:
    """Return the names of the arguments of a launch file and of those it includes.

    Raises:
        TeleopctlError: When the file cannot be read.
    """
    declared = _declared(file, LaunchContext({}, Path()), 0)
    return list(dict.fromkeys(argument.name for argument in declared))


def undeclared_arguments(file: Path, arguments: Mapping[str, str]) -> list[str]:
    """Say which arguments a launch file that cannot be evaluated does not declare.

    For a file that can be, the plan's warnings say so.
    """
    try:
        return undeclared(arguments, argument_names(file))
    except TeleopctlError:
        return []


def _describe(default: Template) -> str:
    if default.is_literal:
        return f"'{default.render(lambda _: '')}'"
    return default.source


def _declared(file: Path, context: LaunchContext, depth: int) -> Iterator[DeclareArgument]:
    if depth > _MAX_DEPTH:
        return
    with context.inside(file):
        yield from _declared_in(read_launch_file(file).steps, context, depth)


def _declared_in(
    steps: tuple[Step, ...], context: LaunchContext, depth: int
) -> Iterator[DeclareArgument]:
    variables = context.scope.variables
    for action in (step.action for step in steps):
        if isinstance(action, DeclareArgument):
            yield action
            if action.default is not None and action.name not in variables:
                _try_to_set(context, action.name, action.default)
        elif isinstance(action, Let):
            if action.name.is_literal:
                _try_to_set(context, action.name.source, action.value)
        elif isinstance(action, Group | Timer | For | ForEach):
            yield from _declared_in(action.steps, context, depth)
        elif isinstance(action, Include):
            try:
                path = included_path(render(action.file, context), context.file)
            except TeleopctlError:
                continue  # which file it is depends on what is known only at the start
            given = {name.source for name, _ in action.arguments}
            for argument in _declared(path, context, depth + 1):
                if argument.name not in given:
                    yield argument


def _try_to_set(context: LaunchContext, name: str, value: Template) -> None:
    if "$(xacro" in value.source or "$(command" in value.source:
        return  # too costly for a default that only names a file elsewhere
    try:
        context.scope.variables[name] = render(value, context)
    except TeleopctlError:
        return
