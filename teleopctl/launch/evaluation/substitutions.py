"""What the substitutions of a launch file mean: ``$(var x)``, ``$(find-pkg-share p)`` and so on.

ROS 2's own, and some of ours: ``$(xacro FILE name:=value …)`` is the robot description, expanded
in this process, ``$(node-exists /name)`` asks the live graph, ``$(first-file A B …)`` is the first
of some files that exists, and ``$(file-param FILE NODE NAME DEFAULT)`` is what a parameter file
says about a node.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from teleopctl.errors import LaunchError, did_you_mean
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.expression import ExpressionError, evaluate
from teleopctl.launch.model import values
from teleopctl.launch.model.template import Argument, Call, Template
from teleopctl.packages import package_share, resolve_uri

_COMMAND_TIMEOUT_S = 60.0


def render(template: Template, context: LaunchContext) -> str:
    """Evaluate a text.

    Raises:
        TeleopctlError: When a substitution is unknown, has the wrong number of arguments or fails.
    """
    return template.render(lambda call: _substitute(call, context))


def _substitute(call: Call, context: LaunchContext) -> str:
    if call.name == "eval" and call.arguments:
        return _evaluate(call, context)
    entry = _FUNCTIONS.get(call.name)
    if entry is None:
        raise LaunchError(
            f"{call.source}: unknown substitution '{call.name}'",
            hint=did_you_mean(call.name, _FUNCTIONS),
        )
    function, least, most = entry
    count = len(call.arguments)
    if count < least or (most is not None and count > most):
        expected = str(least) if least == most else f"{least} to {most}"
        raise LaunchError(
            f"{call.source}: expected {expected if most is not None else f'at least {least}'} "
            f"argument(s), got {count}"
        )
    return function([render(argument.template, context) for argument in call.arguments], context)


def _evaluate(call: Call, context: LaunchContext) -> str:
    """Evaluate ``$(eval …)``: one quoted argument is the expression, else what stands there."""
    try:
        if len(call.arguments) == 1:
            return evaluate(render(call.arguments[0].template, context))
        return evaluate(" ".join(_requoted(argument, context) for argument in call.arguments))
    except ExpressionError as error:
        raise LaunchError(f"{call.source}: {error}") from error


def _requoted(argument: Argument, context: LaunchContext) -> str:
    return f"{argument.quote}{render(argument.template, context)}{argument.quote}"


def _var(arguments: Sequence[str], context: LaunchContext) -> str:
    name = arguments[0]
    if name in context.scope.variables:
        return context.scope.variables[name]
    if len(arguments) > 1:
        return arguments[1]
    raise LaunchError(
        f"launch configuration '{name}' does not exist",
        hint=did_you_mean(name, context.scope.variables),
    )


def _env(arguments: Sequence[str], context: LaunchContext) -> str:
    value = context.environment_value(arguments[0])
    if value is not None:
        return value
    if len(arguments) > 1:
        return arguments[1]
    raise LaunchError(f"environment variable '{arguments[0]}' does not exist")


def _optional_env(arguments: Sequence[str], context: LaunchContext) -> str:
    default = arguments[1] if len(arguments) > 1 else ""
    value = context.environment_value(arguments[0])
    return default if value is None else value


def _find_pkg_share(arguments: Sequence[str], _: LaunchContext) -> str:
    return str(package_share(arguments[0]))


def _find_exec(arguments: Sequence[str], context: LaunchContext) -> str:
    found = shutil.which(arguments[0], path=context.environment_value("PATH"))
    if found is None:
        raise LaunchError(f"executable '{arguments[0]}' not found on the PATH")
    return found


def _dirname(_: Sequence[str], context: LaunchContext) -> str:
    return str(context.file.parent)


def _filename(_: Sequence[str], context: LaunchContext) -> str:
    return str(context.file)


def _log_directory(_: Sequence[str], context: LaunchContext) -> str:
    return str(context.log_directory)


def _anonymous(arguments: Sequence[str], context: LaunchContext) -> str:
    return context.anonymous_name(arguments[0])


def _xacro(arguments: Sequence[str], context: LaunchContext) -> str:
    mappings: dict[str, str] = {}
    for argument in arguments[1:]:
        name, separator, value = argument.partition(":=")
        if not separator or not name:
            raise LaunchError(f"$(xacro …): expected 'name:=value', got '{argument}'")
        mappings[name] = value
    return context.robot_description(resolve_uri(arguments[0]).absolute(), mappings)


def _command(arguments: Sequence[str], context: LaunchContext) -> str:
    words = values.words(arguments[0])
    if not words:
        raise LaunchError("$(command …): the command is empty")
    if Path(words[0]).name == "xacro" and len(words) > 1 and words[1][:1] != "-":
        # What every launch file in the world does; it needs no xacro on the PATH here.
        return _xacro(words[1:], context)
    on_stderr = arguments[1] if len(arguments) > 1 else "fail"
    if on_stderr not in ("fail", "ignore", "warn", "capture"):
        raise LaunchError(
            f"$(command …): expected fail, ignore, warn or capture, got '{on_stderr}'"
        )
    try:
        result = subprocess.run(
            words,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
            timeout=_COMMAND_TIMEOUT_S,
            stdin=subprocess.DEVNULL,
            env=context.environment(),
        )
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        raise LaunchError(f"$(command '{arguments[0]}'): {error}") from error
    complaint = result.stderr.strip()
    if result.returncode != 0:
        raise LaunchError(
            f"$(command '{arguments[0]}') ended with status {result.returncode}: "
            f"{complaint or 'it wrote nothing'}"
        )
    if complaint and on_stderr == "fail":
        raise LaunchError(
            f"$(command '{arguments[0]}') wrote to stderr: {complaint}",
            hint="Add 'ignore', 'warn' or 'capture' behind the command where that is in order.",
        )
    if complaint and on_stderr == "warn":
        context.warnings.append(f"$(command '{arguments[0]}') wrote to stderr: {complaint}")
    return result.stdout + (result.stderr if on_stderr == "capture" else "")


def _node_exists(arguments: Sequence[str], context: LaunchContext) -> str:
    name = arguments[0] if arguments[0].startswith("/") else f"/{arguments[0]}"
    return _word(context.node_is_running(name))


def _first_file(arguments: Sequence[str], _: LaunchContext) -> str:
    for argument in arguments:
        if resolve_uri(argument).is_file():
            return argument
    raise LaunchError(f"there is no file {' nor '.join(arguments)}")


def _file_parameter(arguments: Sequence[str], _: LaunchContext) -> str:
    from teleopctl.node.values.parameter_file import read_parameter_file

    file, node, name = arguments[:3]
    parameters = read_parameter_file(resolve_uri(file)).for_node(f"/{node.lstrip('/')}")
    if name in parameters:
        return str(parameters[name])
    if len(arguments) > 3:
        return arguments[3]
    raise LaunchError(f"{file} gives node '{node}' no parameter '{name}'")


def _not(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(not values.flag(arguments[0]))


def _all(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(all(_flags(arguments)))


def _any(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(any(_flags(arguments)))


def _flags(arguments: Sequence[str]) -> list[bool]:
    """Read every argument, so that a wrong one is reported even where others decide."""
    return [values.flag(argument) for argument in arguments]


def _equals(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(arguments[0] == arguments[1])


def _not_equals(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(arguments[0] != arguments[1])


def _if(arguments: Sequence[str], _: LaunchContext) -> str:
    if values.flag(arguments[0]):
        return arguments[1]
    return arguments[2] if len(arguments) > 2 else ""


def _word(value: bool) -> str:
    return "true" if value else "false"


# Name → function, least and greatest number of arguments (None: any number).
_FUNCTIONS: dict[str, tuple[Callable[[Sequence[str], LaunchContext], str], int, int | None]] = {
    "all": (_all, 1, None),
    "and": (_all, 2, 2),
    "anon": (_anonymous, 1, 1),
    "any": (_any, 1, None),
    "command": (_command, 1, 2),
    "dirname": (_dirname, 0, 0),
    "env": (_env, 1, 2),
    "equals": (_equals, 2, 2),
    "file-param": (_file_parameter, 3, 4),
    "filename": (_filename, 0, 0),
    "find-exec": (_find_exec, 1, 1),
    "find-pkg-share": (_find_pkg_share, 1, 1),
    "first-file": (_first_file, 1, None),
    "if": (_if, 2, 3),
    "launch_log_dir": (_log_directory, 0, 0),
    "log_dir": (_log_directory, 0, 0),
    "node-exists": (_node_exists, 1, 1),
    "not": (_not, 1, 1),
    "not-equals": (_not_equals, 2, 2),
    "optenv": (_optional_env, 1, 2),
    "or": (_any, 2, 2),
    "var": (_var, 1, 2),
    "xacro": (_xacro, 1, None),
}
