"""Our substitutions: what ``$(var x)``, ``$(find-pkg-share p)`` and so on mean.

ROS 2's own, and some of ours: ``$(xacro FILE name:=value …)`` is the robot description, expanded
in this process, ``$(node-exists /name)`` asks the live graph, ``$(first-file A B …)`` is the first
of some files that exists, and ``$(file-param FILE NODE NAME DEFAULT)`` is what a parameter file
says about a node, ``$(file-controllers FILE)`` the controllers that it configures, and
``$(world-file FILE)`` is the path of a file of what stands around a robot, which has been looked
through. Their names stand in `teleopctl.plugins`.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.errors import InvalidFileError, LaunchError, TeleopctlError, did_you_mean
from teleopctl.expression import ExpressionError, evaluate
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.substitution import Substitution, render
from teleopctl.launch.model import values
from teleopctl.launch.model.template import Argument, Call
from teleopctl.packages import package_share, resolve_uri

if TYPE_CHECKING:
    from teleopctl.node import ParameterFile

_COMMAND_TIMEOUT_S = 60.0
# How the type of a controller ends among the manager's parameters: NAME.type.
_TYPE = ".type"


class _Expression(Substitution):
    """``$(eval …)``: one quoted argument is the expression, else what stands there."""

    def arguments(self, call: Call, context: LaunchContext) -> list[str]:
        if len(call.arguments) == 1:
            return super().arguments(call, context)
        return [" ".join(_requoted(argument, context) for argument in call.arguments)]


def _eval(arguments: Sequence[str], _: LaunchContext) -> str:
    try:
        return evaluate(arguments[0])
    except ExpressionError as error:
        raise LaunchError(f"$(eval {arguments[0]}): {error}") from error


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


def _parameter_file(file: str) -> ParameterFile:
    """Read a parameter file, whose mistakes are its own and not the launch file's."""
    from teleopctl.node import read_parameter_file

    path = resolve_uri(file).absolute()
    try:
        return read_parameter_file(path)
    except InvalidFileError as error:
        error.place = str(path)  # its message names it
        raise


def _file_parameter(arguments: Sequence[str], _: LaunchContext) -> str:
    file, node, name = arguments[:3]
    parameters = _parameter_file(file).for_node(f"/{node.lstrip('/')}")
    if name in parameters:
        return str(parameters[name])
    if len(arguments) > 3:
        return arguments[3]
    raise LaunchError(f"{file} gives node '{node}' no parameter '{name}'")


def _file_controllers(arguments: Sequence[str], _: LaunchContext) -> str:
    """The controllers whose types a file gives, broadcasters first.

    A type stands below the controller manager's section or in a section of the controller's own;
    ROS 2's spawner reads both. A broadcaster only reads, so that states are seen before anything
    moves.
    """
    file = _parameter_file(arguments[0])
    types = {
        name.removesuffix(_TYPE): str(value)
        for name, value in file.for_node("/controller_manager").items()
        if name.endswith(_TYPE)
    }
    for section, parameters in file.sections:
        name = section.removeprefix("/")
        if "type" in parameters and not set(name) & set("*/"):
            types.setdefault(name, str(parameters["type"]))
    return " ".join(sorted(types, key=lambda name: not types[name].endswith("Broadcaster")))


def _world_file(arguments: Sequence[str], _: LaunchContext) -> str:
    """The absolute path of a world file, after a look at it; empty for none.

    A mistake is told here, once, and not by each of the nodes that read the file.
    """
    if not arguments[0]:
        return ""
    from teleopctl.robot import read_world

    path = resolve_uri(arguments[0]).absolute()
    try:
        return str(read_world(path).path)
    except TeleopctlError as error:
        error.place = str(path)  # its message names it
        raise


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


ALL = Substitution(_all, 1, None)
AND = Substitution(_all, 2, 2)
ANON = Substitution(_anonymous, 1, 1)
ANY = Substitution(_any, 1, None)
COMMAND = Substitution(_command, 1, 2)
DIRNAME = Substitution(_dirname, 0, 0)
ENV = Substitution(_env, 1, 2)
EQUALS = Substitution(_equals, 2, 2)
EVAL = _Expression(_eval, 1)
FILENAME = Substitution(_filename, 0, 0)
FILE_CONTROLLERS = Substitution(_file_controllers, 1, 1)
FILE_PARAM = Substitution(_file_parameter, 3, 4)
FIND_EXEC = Substitution(_find_exec, 1, 1)
FIND_PKG_SHARE = Substitution(_find_pkg_share, 1, 1)
FIRST_FILE = Substitution(_first_file, 1, None)
IF = Substitution(_if, 2, 3)
LAUNCH_LOG_DIR = Substitution(_log_directory, 0, 0)
LOG_DIR = Substitution(_log_directory, 0, 0)
NODE_EXISTS = Substitution(_node_exists, 1, 1)
NOT = Substitution(_not, 1, 1)
NOT_EQUALS = Substitution(_not_equals, 2, 2)
OPTENV = Substitution(_optional_env, 1, 2)
OR = Substitution(_any, 2, 2)
VAR = Substitution(_var, 1, 2)
WORLD_FILE = Substitution(_world_file, 1, 1)
XACRO = Substitution(_xacro, 1, None)
