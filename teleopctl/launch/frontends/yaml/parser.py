"""Reads a YAML launch file into descriptions.

The vocabulary is that of ROS 2's YAML front end; names with hyphens and with underscores are the
same. A key that does not belong is an error, since a misspelled one would silently do nothing.
"""

from __future__ import annotations

from pathlib import Path

from teleopctl import plugins
from teleopctl.errors import BrokenPluginError, TeleopctlError, did_you_mean
from teleopctl.launch.frontends.yaml.tree import load
from teleopctl.launch.model.action import Action, Entity, LaunchFile, Step
from teleopctl.launch.model.descriptions import Condition
from teleopctl.launch.model.element import Element

_UNSUPPORTED = dict.fromkeys(
    ("node_container", "load_composable_node"),
    "composable nodes are C++ libraries loaded into one process; use 'node' for each of them",
)


def parse_file(path: Path) -> LaunchFile:
    """Read a launch file.

    Raises:
        TeleopctlError: When it cannot be read or does not follow the vocabulary. The message
            names file, line and key, and what was expected there.
    """
    root = load(path)
    if not isinstance(root.value, dict) or "launch" not in root.value:
        raise root.error(f"expected a mapping with the key 'launch', got {root.describe()}")
    unknown = [key for key in root.value if key != "launch"]
    if unknown:
        raise root.value[unknown[0]].error("expected only the key 'launch' at the top of the file")
    return LaunchFile(path, _steps(root.value["launch"]))


def _steps(element: Element) -> tuple[Step, ...]:
    if element.value is None:
        return ()
    return tuple(_step(item) for item in element.items("a list of actions"))


def _step(element: Element) -> Step:
    fields = element.mapping("an action, such as 'node: …'")
    if len(fields) != 1:
        raise element.error(
            f"expected one action, got {element.describe()}",
            hint="What belongs to an action is indented below its name.",
        )
    name, content = next(iter(fields.items()))
    action = _action_class(name, content)
    if name == "group" and isinstance(content.value, list):
        # The short form: a list of children and nothing else.
        content = Element({"children": content}, content.place, content.path)
    entity = Entity(content, (*action.keys, "if", "unless"), _steps)
    conditions = tuple(
        Condition(text, expected)
        for key, expected in (("if", True), ("unless", False))
        if (text := entity.optional(key)) is not None
    )
    try:
        return Step(content.place, conditions, action.parse(entity))
    except TeleopctlError:
        raise
    except Exception as error:
        raise content.error(
            f"{action.__name__} cannot be read: {type(error).__name__}: {error}"
        ) from error


def _action_class(name: str, content: Element) -> type[Action]:
    canonical = name.replace("-", "_")
    if plugins.find(plugins.LAUNCH_ACTIONS, canonical) is None:
        if canonical in _UNSUPPORTED:
            raise content.error(_UNSUPPORTED[canonical])
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
