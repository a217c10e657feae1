"""Conversion of a launch file's elements to steps with actions, for XML and YAML alike.

The vocabulary is that of ROS 2's XML and YAML front ends; names with hyphens and with underscores
are equal. An unknown key is an error, since a misspelled key would silently have no effect.
"""

from __future__ import annotations

from pathlib import Path

from teleopctl import plugins
from teleopctl.errors import BrokenPluginError, TeleopctlError, did_you_mean
from teleopctl.launch.actions.messages import Log
from teleopctl.launch.model.action import (
    Action,
    Entity,
    LaunchFile,
    Step,
    exposed_actions,
    load_launch_extensions,
)
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.template import literal


def launch_file(path: Path, actions: Element, deprecated: Element | None = None) -> LaunchFile:
    """Return the path and the steps of a launch file, from its parsed list of actions.

    Args:
        path: Path of the launch file.
        actions: List of the file's actions.
        deprecated: Reason why the file is deprecated, if the file has the key ``deprecated``.

    Raises:
        TeleopctlError: An action or key is unknown, or a value is invalid. The message names file,
            line and key, and what was expected there.
    """
    steps = _steps(actions)
    if deprecated is not None:
        message = literal(f"launch file [{path}] is deprecated: {deprecated.text()}")
        steps = (Step(deprecated.place, (), Log(message=message, level=literal("WARNING"))), *steps)
    return LaunchFile(path, steps)


def _steps(element: Element) -> tuple[Step, ...]:
    if element.value is None:
        return ()
    return tuple(read_step(*item.action()) for item in element.items("a list of actions"))


def read_step(name: str, content: Element) -> Step:
    """Return one launch file entry as a `Step`: its action, conditions and place.

    Args:
        name: Name of the action.
        content: Content of the action: its keys, attributes or nested tags.

    Raises:
        TeleopctlError: The action or a key is unknown, or a value is invalid.
    """
    known = plugins.find(plugins.LAUNCH_ACTIONS, name.replace("-", "_"))
    if known is None:
        if name not in exposed_actions:
            load_launch_extensions()
        if name in exposed_actions:
            return exposed_actions[name](name, content)
    action = _action_class(name, content)
    entity = Entity(content, (*action.keys, "if", "unless"), _steps, action.renamed)
    try:
        return Step(content.place, entity.conditions(), action.parse(entity))
    except TeleopctlError:
        raise
    except Exception as error:
        raise content.error(
            f"{action.__name__} cannot be read: {type(error).__name__}: {error}"
        ) from error


def _action_class(name: str, content: Element) -> type[Action]:
    canonical = name.replace("-", "_")
    if plugins.find(plugins.LAUNCH_ACTIONS, canonical) is None:
        known = sorted(plugins.available(plugins.LAUNCH_ACTIONS))
        raise content.error(
            f"unknown action '{name}', expected one of {', '.join(known)}",
            hint=did_you_mean(name, known),
        )
    try:
        found: type[Action] = plugins.load(plugins.LAUNCH_ACTIONS, canonical)
    except BrokenPluginError as error:
        raise content.error(error.message) from error
    return found
