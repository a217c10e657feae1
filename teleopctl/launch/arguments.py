"""Launch arguments of a launch file and its includes, as ``launch --show-args`` lists them."""

from __future__ import annotations

from pathlib import Path

from teleopctl.base.budget import DEEPEST_INCLUDES
from teleopctl.base.typed import Collection, Iterable, Iterator, Mapping, NamedTuple
from teleopctl.errors import TeleopctlError
from teleopctl.launch.actions.nesting import (
    For,
    ForEach,
    Group,
    Include,
    IncludeSteps,
    TimedEntities,
    included_path,
)
from teleopctl.launch.actions.settings import DeclareArgument, Let
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.evaluation import undeclared
from teleopctl.launch.evaluation.substitution import evaluated_text
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.action import Step
from teleopctl.launch.model.template import Call, Template
from teleopctl.packages import resolve_uri

# Substitutions that expand a robot description, start a program, or write a file.
_COSTLY = frozenset(
    (
        "command",
        "robot",
        "robot-arguments",
        "robot-controllers",
        "robot-is-controlled",
        "robot-namespace",
        "robot-remappings",
        "simulated-robot",
        "with-plugins",
        "xacro",
    )
)


class _Declared(NamedTuple):
    """A declared launch argument, and whether its declaration depends on a condition."""

    argument: DeclareArgument
    may_be_missing: bool


def describe_arguments(file: Path, arguments: Mapping[str, str]) -> Iterator[str]:
    """Yield the ``--show-args`` lines of a launch file, its includes and given xacro files.

    Raises:
        TeleopctlError: The file or an included file cannot be read.
    """
    yield "Arguments (pass arguments as '<name>:=<value>'):"
    context = LaunchContext(arguments, Path())
    seen: dict[str, _Declared] = {}
    for declared in _declared(file, context, 0):
        argument = declared.argument
        if argument.name in seen:
            continue
        seen[argument.name] = declared
        yield ""
        yield f"    '{argument.name}':{'*' if declared.may_be_missing else ''}"
        yield f"        {argument.in_words}"
        if argument.default is not None:
            yield f"        (default: {_describe(argument.default)})"
    if not seen:
        yield ""
        yield "  No arguments."
    if any(declared.may_be_missing for declared in seen.values()):
        yield ""
        yield "* argument(s) which are only used if specific conditions occur"
    yield from _xacro_argument_lines(arguments.values(), seen)


def _xacro_argument_lines(values: Iterable[str], declared: Collection[str]) -> Iterator[str]:
    """Yield lines for the undeclared xacro arguments of robot descriptions among the values."""
    from teleopctl.robot import xacro_arguments

    for value in values:
        if not value.endswith(".xacro"):
            continue
        taken = xacro_arguments([resolve_uri(value)])
        if names := [name for name in taken if name not in declared]:
            yield ""
            yield f"Arguments of {value}:"
        for name in names:
            yield ""
            yield f"    '{name}'"
            if (default := taken[name]) is not None:
                yield f"        (default: '{default}')"


def argument_names(file: Path, files_read: set[Path] | None = None) -> list[str]:
    """Return the names of the arguments that a launch file and its includes declare.

    Args:
        file: Path of the launch file.
        files_read: Set to which the paths of the file and its includes are added.

    Raises:
        TeleopctlError: The file or an included file cannot be read.
    """
    declared = _declared(file, LaunchContext({}, Path()), 0, files_read)
    return list(dict.fromkeys(each.argument.name for each in declared))


def undeclared_argument_warnings(file: Path, arguments: Mapping[str, str]) -> list[str]:
    """Return a warning for each argument that no launch file or given robot file declares.

    Returns no warnings if the files cannot be read. A file that can be evaluated does not need this
    function: the warnings of its plan include these.
    """
    from teleopctl.robot import xacro_arguments

    try:
        of_robots = xacro_arguments(
            Path(value) for value in arguments.values() if value.endswith((".xacro", ".urdf"))
        )
        unknown = [name for name in arguments if name not in of_robots]
        return undeclared(unknown, argument_names(file))
    except TeleopctlError:
        return []


def _describe(default: Template) -> str:
    if default.is_literal:
        return f"'{default.render(lambda _: '')}'"
    calls = [part for part in default.parts if not isinstance(part, str)]
    if all(call.source.startswith("$(") for call in calls):
        return default.source
    # A default of a Python launch file, which has no text as a whole.
    parts = (f"'{part}'" if isinstance(part, str) else part.source for part in default.parts)
    return " + ".join(parts)


def _declared(
    file: Path, context: LaunchContext, depth: int, files_read: set[Path] | None = None
) -> Iterator[_Declared]:
    if depth > DEEPEST_INCLUDES:
        return
    context.count_included()
    if files_read is not None:
        files_read.add(file)
    with context.inside(file):
        yield from _declared_in(read_launch_file(file).steps, context, depth, files_read)


def _declared_in(
    steps: tuple[Step, ...],
    context: LaunchContext,
    depth: int,
    files_read: set[Path] | None,
    *,
    conditional: bool = False,
) -> Iterator[_Declared]:
    variables = context.scope.variables
    for step in steps:
        action = step.action
        may_be_missing = conditional or bool(step.conditions)
        if isinstance(action, DeclareArgument):
            yield _Declared(action, may_be_missing)
            if action.default is not None and action.name not in variables:
                _try_to_set(context, action.name, action.default)
        elif isinstance(action, Let):
            if action.name.is_literal:
                _try_to_set(context, action.name.source, action.value)
        elif isinstance(action, Group | TimedEntities | For | ForEach | IncludeSteps):
            given = action.arguments if isinstance(action, IncludeSteps) else ()
            below = _declared_in(
                action.steps,
                context,
                depth,
                files_read,
                conditional=may_be_missing or isinstance(action, TimedEntities),
            )
            yield from _not_given(below, given)
        elif isinstance(action, Include):
            try:
                path = included_path(evaluated_text(action.file, context), context.file)
            except TeleopctlError:
                continue  # the file depends on values that are known only at the start
            for argument, is_conditional in _not_given(
                _declared(path, context, depth + 1, files_read), action.arguments
            ):
                yield _Declared(argument, may_be_missing or is_conditional)


def _not_given(
    declared: Iterator[_Declared], given: tuple[tuple[Template, Template], ...]
) -> Iterator[_Declared]:
    names = {name.source for name, _ in given}
    return (each for each in declared if each.argument.name not in names)


def _try_to_set(context: LaunchContext, name: str, value: Template) -> None:
    if _is_costly(value):
        return  # too costly for a value that only helps to find included files
    try:
        context.scope.variables[name] = evaluated_text(value, context)
    except TeleopctlError:
        return


def _is_costly(text: Template) -> bool:
    return any(
        isinstance(part, Call)
        and (
            part.name in _COSTLY
            or any(_is_costly(argument.template) for argument in part.arguments)
        )
        for part in text.parts
    )
