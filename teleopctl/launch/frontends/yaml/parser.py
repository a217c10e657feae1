"""Reads a YAML launch file into descriptions.

The vocabulary is that of ROS 2's YAML front end; names with hyphens and with underscores are the
same. A key that does not belong is an error, since a misspelled one would silently do nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from teleopctl.errors import did_you_mean
from teleopctl.launch.frontends.yaml.entries import Entry
from teleopctl.launch.frontends.yaml.process_entries import (
    EXECUTABLE_KEYS,
    NODE_KEYS,
    pairs,
    parameter,
    read_executable,
    read_node,
)
from teleopctl.launch.frontends.yaml.tree import Element, load
from teleopctl.launch.model import template
from teleopctl.launch.model.descriptions import (
    Action,
    Condition,
    DeclareArgument,
    Group,
    Include,
    LaunchFile,
    Let,
    Log,
    PushNamespace,
    SetEnvironment,
    SetParameter,
    SetRemap,
    Shutdown,
    Step,
    Timer,
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
    canonical = name.replace("-", "_")
    if canonical in _UNSUPPORTED:
        raise content.error(_UNSUPPORTED[canonical])
    if canonical not in _ACTIONS:
        raise content.error(
            f"unknown action '{name}', expected one of {', '.join(sorted(_ACTIONS))}",
            hint=did_you_mean(name, _ACTIONS),
        )
    if canonical == "group" and isinstance(content.value, list):
        # The short form: a list of children and nothing else.
        return Step(content.place, (), Group(scoped=True, steps=_steps(content)))
    keys, read = _ACTIONS[canonical]
    entry = Entry(content, (*keys, "if", "unless"))
    return Step(content.place, tuple(_conditions(entry)), read(entry))


def _conditions(entry: Entry) -> Iterator[Condition]:
    for key, expected in (("if", True), ("unless", False)):
        text = entry.optional(key)
        if text is not None:
            yield Condition(text, expected)


def _declare_argument(entry: Entry) -> DeclareArgument:
    choices = entry.element("choice")
    description = entry.element("description")
    return DeclareArgument(
        name=entry.required_text("name"),
        default=entry.optional("default"),
        description=None if description is None else description.text(),
        choices=tuple(
            Entry(item, ("value",)).required_text("value")
            for item in (choices.items("a list of 'value: …'") if choices else ())
        ),
    )


def _let(entry: Entry) -> Let:
    return Let(name=entry.required("name"), value=entry.required("value"))


def _set_environment(entry: Entry) -> SetEnvironment:
    return SetEnvironment(name=entry.required("name"), value=entry.required("value"))


def _append_environment(entry: Entry) -> SetEnvironment:
    return replace(_set_environment(entry), append=True)


def _unset_environment(entry: Entry) -> SetEnvironment:
    return SetEnvironment(name=entry.required("name"), value=None)


def _include(entry: Entry) -> Include:
    return Include(
        file=entry.required("file"),
        arguments=(
            *pairs(entry.element("arg"), "name", "value"),
            *pairs(entry.element("let"), "name", "value"),
        ),
    )


def _group(entry: Entry) -> Group:
    scoped = entry.element("scoped")
    if scoped is not None and not isinstance(scoped.value, bool):
        raise scoped.error(f"expected true or false, got {scoped.describe()}")
    return Group(
        scoped=scoped is None or scoped.value is True,
        steps=_steps(entry.required_element("children")),
    )


def _timer(entry: Entry) -> Timer:
    return Timer(period=entry.required("period"), steps=_steps(entry.required_element("children")))


def _push_namespace(entry: Entry) -> PushNamespace:
    return PushNamespace(namespace=entry.required("namespace"))


def _set_parameter(entry: Entry) -> SetParameter:
    return SetParameter(parameter=parameter(entry))


def _set_remap(entry: Entry) -> SetRemap:
    return SetRemap(source=entry.required("from"), target=entry.required("to"))


def _log(entry: Entry) -> Log:
    return Log(
        level=entry.optional("level") or template.literal("INFO"),
        message=entry.required("message"),
    )


def _shutdown(entry: Entry) -> Shutdown:
    return Shutdown(reason=entry.required("reason"))


# Name → its keys, besides the conditions that every action may have, and who reads them.
_ACTIONS: dict[str, tuple[tuple[str, ...], Callable[[Entry], Action]]] = {
    "append_env": (("name", "value"), _append_environment),
    "arg": (("name", "default", "description", "choice"), _declare_argument),
    "executable": (EXECUTABLE_KEYS, read_executable),
    "group": (("children", "scoped"), _group),
    "include": (("file", "arg", "let"), _include),
    "let": (("name", "value"), _let),
    "log": (("level", "message"), _log),
    "node": (NODE_KEYS, read_node),
    "push_ros_namespace": (("namespace",), _push_namespace),
    "set_env": (("name", "value"), _set_environment),
    "set_parameter": (("name", "value", "type"), _set_parameter),
    "set_remap": (("from", "to"), _set_remap),
    "shutdown": (("reason",), _shutdown),
    "timer": (("period", "children"), _timer),
    "unset_env": (("name",), _unset_environment),
}

_UNSUPPORTED = dict.fromkeys(
    ("node_container", "load_composable_node"),
    "composable nodes are C++ libraries loaded into one process; use 'node' for each of them",
)
