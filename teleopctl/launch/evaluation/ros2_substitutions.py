"""ROS 2's substitutions for launch files, such as ``$(var x)`` and ``$(find-pkg-share p)``.

The names are registered in `teleopctl.plugins`; teleopctl's own substitutions are in
`teleopctl.launch.evaluation.extra_substitutions`.
"""

from __future__ import annotations

import math
import os
import subprocess
from pathlib import Path

from teleopctl.base.budget import joined
from teleopctl.base.files import read_text
from teleopctl.base.typed import Sequence
from teleopctl.errors import LaunchError, did_you_mean
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.parameters import parameter_value
from teleopctl.launch.evaluation.processes import find_command, replace_missing_command
from teleopctl.launch.evaluation.robot_substitutions import expand
from teleopctl.launch.evaluation.substitution import Substitution, evaluated_text
from teleopctl.launch.model import values
from teleopctl.launch.model.descriptions import ParameterEntry
from teleopctl.launch.model.template import Call, SubstitutionArgument
from teleopctl.packages import find_executable, find_package, package_share, resolve_uri

_COMMAND_TIMEOUT_S = 60.0


class _Expression(Substitution):
    """``$(eval …)``: evaluates a Python expression, quoted as one argument or without quotes.

    A second quoted argument lists modules. Only ``math`` is allowed, which every expression can
    use.
    """

    def arguments(self, call: Call, context: LaunchContext) -> list[str]:
        if len(call.arguments) == 1 or (len(call.arguments) == 2 and _all_quoted(call)):
            return super().arguments(call, context)
        return [" ".join(_requoted(argument, context) for argument in call.arguments)]


def _all_quoted(call: Call) -> bool:
    return all(argument.quote for argument in call.arguments)


def _eval(arguments: Sequence[str], _: LaunchContext) -> str:
    modules = [name.strip() for name in ",".join(arguments[1:]).split(",")]
    if others := [name for name in modules if name not in ("", "math")]:
        raise LaunchError(f"$(eval …): module '{others[0]}' is not available, only math")
    from teleopctl.base.expression import ExpressionError, evaluate

    try:
        return evaluate(arguments[0])
    except ExpressionError as error:
        raise LaunchError(f"$(eval {arguments[0]}): {error}") from error


def _requoted(argument: SubstitutionArgument, context: LaunchContext) -> str:
    return f"{argument.quote}{evaluated_text(argument.template, context)}{argument.quote}"


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


def _find_pkg_prefix(arguments: Sequence[str], _: LaunchContext) -> str:
    return str(find_package(arguments[0]).prefix)


def _executable_in_package(arguments: Sequence[str], _: LaunchContext) -> str:
    name, package = arguments
    find_executable(package, name)
    return str(find_package(package).prefix / "lib" / package / name)


def _find_exec(arguments: Sequence[str], context: LaunchContext) -> str:
    found = find_command(arguments[0], context.environment_value("PATH"))
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


def _is_plain_xacro(words: Sequence[str]) -> bool:
    return Path(words[0]).name == "xacro" and not any(word.startswith("-") for word in words[1:])


def _command(arguments: Sequence[str], context: LaunchContext) -> str:
    words = values.words(arguments[0])
    if not words:
        raise LaunchError("$(command …): the command is empty")
    if _is_plain_xacro(words):
        # The usual call in launch files; expanded here, so that no xacro needs to be on the PATH.
        return expand(words[1:], context)
    words = replace_missing_command(words, context.environment_value("PATH"))
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
    except FileNotFoundError as error:
        raise LaunchError(f"file not found: {error}") from error
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        raise LaunchError(f"$(command '{arguments[0]}'): {error}") from error
    written = f"\nCaptured stderr output: {result.stderr}" if result.stderr.strip() else ""
    if result.returncode != 0:
        raise LaunchError(f"executed command failed. Command: {arguments[0]}{written}")
    complaint = f"executed command showed stderr output. Command: {arguments[0]}{written}"
    if written and on_stderr == "fail":
        raise LaunchError(
            complaint,
            hint="Add 'ignore', 'warn' or 'capture' after the command if that is intended.",
        )
    if written and on_stderr == "warn":
        context.warnings.append(complaint)
    return result.stdout + (result.stderr if on_stderr == "capture" else "")


def _not(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(not values.boolean(arguments[0]))


def _all(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(all(_flags(arguments)))


def _any(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(any(_flags(arguments)))


def _flags(arguments: Sequence[str]) -> list[bool]:
    """Convert all arguments, so that an invalid one is reported even if others decide."""
    return [values.boolean(argument) for argument in arguments]


def _equals(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(_are_equal(*arguments))


def _not_equals(arguments: Sequence[str], _: LaunchContext) -> str:
    return _word(not _are_equal(*arguments))


def _are_equal(left: str, right: str) -> bool:
    """Return whether two texts are the same truth value or number, or else the same text."""
    words = (left.lower(), right.lower())
    if all(word in ("true", "false", "1", "0") for word in words):
        return values.flag(left) == values.flag(right)
    if all(map(_is_number, words)):
        return math.isclose(float(left), float(right))
    return left == right


def _if(arguments: Sequence[str], _: LaunchContext) -> str:
    if values.boolean(arguments[0]):
        return arguments[1]
    return arguments[2] if len(arguments) > 2 else ""


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _path_join(arguments: Sequence[str], _: LaunchContext) -> str:
    joined(arguments)
    # As in ROS 2, an empty last part ends the path with a separator.
    return os.path.join(*arguments)  # noqa: PTH118 -- pathlib drops it


def _string_join(arguments: Sequence[str], _: LaunchContext) -> str:
    return joined(arguments[1:], arguments[0])


def _file_content(arguments: Sequence[str], _: LaunchContext) -> str:
    path = resolve_uri(arguments[0])
    if not path.exists():
        raise LaunchError(f"File not found: {path}")
    return read_text(path)


def _loop_value(arguments: Sequence[str], context: LaunchContext) -> str:
    loop_values = context.scope.loop_values
    if arguments[0] in loop_values:
        return loop_values[arguments[0]]
    if len(arguments) > 1:
        return arguments[1]
    raise LaunchError(
        f"no enclosing loop sets '{arguments[0]}'", hint=did_you_mean(arguments[0], loop_values)
    )


def _parameter(arguments: Sequence[str], context: LaunchContext) -> str:
    for entry in context.scope.parameters:
        if (
            isinstance(entry, ParameterEntry)
            and evaluated_text(entry.name, context) == arguments[0]
        ):
            return str(parameter_value(entry, context))
    if len(arguments) > 1:
        return arguments[1]
    raise LaunchError(f"no set_parameter has set parameter '{arguments[0]}'")


def _word(value: bool) -> str:
    return "true" if value else "false"


ALL = Substitution(_all, 0, None)
AND = Substitution(_all, 2, 2)
ANON = Substitution(_anonymous, 1, 1)
ANY = Substitution(_any, 0, None)
COMMAND = Substitution(_command, 1, 2)
DIRNAME = Substitution(_dirname, 0, 0)
ENV = Substitution(_env, 1, 2)
EQUALS = Substitution(_equals, 2, 2)
EVAL = _Expression(_eval, 1)
EXEC_IN_PKG = Substitution(_executable_in_package, 2, 2)
FILE_CONTENT = Substitution(_file_content, 1, 1)
FILENAME = Substitution(_filename, 0, 0)
FIND_EXEC = Substitution(_find_exec, 1, 1)
FIND_PKG_PREFIX = Substitution(_find_pkg_prefix, 1, 1)
FIND_PKG_SHARE = Substitution(_find_pkg_share, 1, 1)
FOR_VAR = Substitution(_loop_value, 1, 2)
IF = Substitution(_if, 2, 3)
INDEX = Substitution(_loop_value, 1, 1)
LAUNCH_LOG_DIR = Substitution(_log_directory, 0, 0)
LOG_DIR = Substitution(_log_directory, 0, 0)
NOT = Substitution(_not, 1, 1)
NOT_EQUALS = Substitution(_not_equals, 2, 2)
OPTENV = Substitution(_optional_env, 1, 2)
OR = Substitution(_any, 2, 2)
PARAM = Substitution(_parameter, 1, 2)
PATH_JOIN = Substitution(_path_join, 1, None)
STRING_JOIN = Substitution(_string_join, 2, None)
VAR = Substitution(_var, 1, 2)
