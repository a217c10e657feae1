"""Constructor arguments of the actions in ``launch`` for steps of XML and YAML launch files.

The model reads the entry; what stands here makes of it what a Python launch file would say.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from teleopctl import launch as model
from teleopctl.launch import ProcessPart, Template, split_command_line

from ..action import Action
from ..actions import (
    AppendEnvironmentVariable,
    DeclareBooleanLaunchArgument,
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    ReplaceEnvironmentVariables,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    Shutdown,
    TimerAction,
    UnsetEnvironmentVariable,
)
from ..actions.log_info import Log, LogDebug, LogError, LogInfo, LogWarning
from ..launch_description_sources import AnyLaunchDescriptionSource
from ..substitution import Substitution
from .known import action_of, flag_or_text, is_known_as, number_or_text, pairs, text

_LOGS = {"DEBUG": LogDebug, "INFO": LogInfo, "WARNING": LogWarning, "ERROR": LogError}


# Any, in what follows: constructor arguments, which differ by class.
@is_known_as("let", model.Let, SetLaunchConfiguration)
@is_known_as("set_env", model.SetEnvironment, SetEnvironmentVariable)
def _named_with_value(action: Any) -> dict[str, Any]:
    return {"name": text(action.name), "value": text(action.value)}


@is_known_as("unset_env", model.UnsetEnvironment, UnsetEnvironmentVariable)
def _named(action: Any) -> dict[str, Any]:
    return {"name": text(action.name)}


@is_known_as("append_env", model.AppendEnvironment, AppendEnvironmentVariable)
def _append(action: model.AppendEnvironment) -> dict[str, Any]:
    return {
        **_named_with_value(action),
        "prepend": flag_or_text(action.prepend),
        "separator": text(action.separator),
    }


@is_known_as("reset_env", model.ResetEnvironment, ResetEnvironment)
def _nothing(_: model.ResetEnvironment) -> dict[str, Any]:
    return {}


@is_known_as("rep_env", model.ReplaceEnvironment, ReplaceEnvironmentVariables)
def _replace(action: model.ReplaceEnvironment) -> dict[str, Any]:
    return {"env": pairs(action.variables)}


@is_known_as("arg", model.DeclareArgument, DeclareLaunchArgument)
def _argument(action: model.DeclareArgument) -> dict[str, Any]:
    return {**_boolean_argument(action), "choices": list(action.choices) or None}


@is_known_as("bool_arg", model.DeclareBoolean, DeclareBooleanLaunchArgument)
def _boolean_argument(action: model.DeclareArgument) -> dict[str, Any]:
    default = None if action.default is None else text(action.default)
    return {"name": action.name, "default_value": default, "description": action.description}


@is_known_as("reset", model.Reset, ResetLaunchConfigurations)
def _reset(action: model.Reset) -> dict[str, Any]:
    return {"launch_configurations": pairs(action.keep)}


@is_known_as("group", model.Group, GroupAction)
def _group(action: model.Group) -> dict[str, Any]:
    return {
        "actions": [action_of(step) for step in action.steps],
        "scoped": action.scoped,
        "forwarding": action.forwarding,
        "launch_configurations": pairs(action.keep),
    }


@is_known_as("timer", model.TimedEntities, TimerAction)
def timer(action: model.TimedEntities) -> dict[str, Any]:
    """Return the constructor arguments of a timer."""
    cancels = action.cancel_on_shutdown
    return {
        "period": number_or_text(action.period),
        "actions": [action_of(step) for step in action.steps],
        "cancel_on_shutdown": True if cancels is None else flag_or_text(cancels),
    }


@is_known_as("include", model.Include, IncludeLaunchDescription)
def _include(action: model.Include) -> dict[str, Any]:
    return {
        "launch_description_source": AnyLaunchDescriptionSource(text(action.file)),
        "launch_arguments": [(text(name), text(value)) for name, value in action.arguments],
    }


@is_known_as("log", model.Log, Log)
def _log(action: model.Log) -> dict[str, Any] | Action:
    words = {"msg": text(action.message)}
    kind = _LOGS.get(action.level.source.upper())
    return kind(**words) if kind is not None else {**words, "level": text(action.level)}


@is_known_as("shutdown", model.Shutdown, Shutdown)
def _shutdown(action: model.Shutdown) -> dict[str, Any]:
    return {"reason": text(action.reason)}


@is_known_as("executable", model.Executable, ExecuteProcess)
def _executable(action: ProcessPart) -> dict[str, Any]:
    command = [*command_line(action.command), *command_line(action.arguments)]
    return {
        "cmd": command,
        **({} if action.process_name is None else {"name": text(action.process_name)}),
        **process(action),
    }


def process(action: ProcessPart) -> dict[str, Any]:
    """Return the constructor arguments of a process without command line and name."""
    found: dict[str, Any] = {
        "cwd": action.working_directory,
        "prefix": action.prefix,
        "output": action.output,
        "respawn_delay": action.respawn_delay,
        "respawn_max_retries": action.respawn_max_retries,
        "sigterm_timeout": action.sigterm_timeout,
        "sigkill_timeout": action.sigkill_timeout,
    }
    words: dict[str, Any] = {
        name: text(value) for name, value in found.items() if isinstance(value, Template)
    }
    for name in ("shell", "emulate_tty", "respawn"):
        value = getattr(action, name)
        if value is not None:
            words[name] = flag_or_text(value)
    if action.environment:
        words["additional_env"] = pairs(action.environment)
    if action.shutdown_on_exit is not None and flag_or_text(action.shutdown_on_exit) is True:
        words["on_exit"] = [Shutdown()]
    return words


def command_line(
    words: Template | Iterable[Template] | None,
) -> list[list[Substitution]]:
    """Return the constructor argument with the command line."""
    split = split_command_line(words) if isinstance(words, Template) else words
    return [text(word) for word in split or ()]
