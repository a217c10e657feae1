"""Reads a YAML launch file into descriptions.

The vocabulary is that of ROS 2's YAML front end; names with hyphens and with underscores are the
same. A key that does not belong is an error, since a misspelled one would silently do nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from teleopctl.launch import template
from teleopctl.launch.descriptions import (
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
    Timer,
)
from teleopctl.launch.entries import Entry
from teleopctl.launch.process_entries import pairs, parameter, parse_executable, parse_node
from teleopctl.launch.yaml_tree import Element, load
from teleopctl.packages import suggest


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
    return LaunchFile(path=path, actions=_actions(root.value["launch"]))


def _actions(element: Element) -> tuple[Action, ...]:
    if element.value is None:
        return ()
    return tuple(_action(item) for item in element.items("a list of actions"))


def _action(element: Element) -> Action:
    fields = element.mapping("an action, such as 'node: …'")
    if len(fields) != 1:
        raise element.error(
            f"expected one action, got {element.describe()}",
            hint="What belongs to an action is indented below its name.",
        )
    name, content = next(iter(fields.items()))
    parse = _PARSERS.get(name.replace("-", "_"))
    if parse is None:
        unsupported = _UNSUPPORTED.get(name.replace("-", "_"))
        if unsupported is not None:
            raise content.error(unsupported)
        raise content.error(
            f"unknown action '{name}', expected one of {', '.join(sorted(_PARSERS))}",
            hint=suggest(name, _PARSERS),
        )
    return parse(content)


def _conditions(entry: Entry) -> tuple[Condition, ...]:
    found = (("if", True), ("unless", False))
    return tuple(
        Condition(text, expected)
        for key, expected in found
        if (text := entry.optional(key)) is not None
    )


def _declare_argument(element: Element) -> Action:
    entry = Entry(element, ("name", "default", "description", "choice", "if", "unless"))
    choices = entry.element("choice")
    description = entry.element("description")
    return DeclareArgument(
        place=element.place,
        conditions=_conditions(entry),
        name=entry.required_text("name"),
        default=entry.optional("default"),
        description=None if description is None else description.text(),
        choices=tuple(
            Entry(item, ("value",)).required_text("value")
            for item in (choices.items("a list of 'value: …'") if choices else ())
        ),
    )


def _let(element: Element) -> Action:
    entry = Entry(element, ("name", "value", "if", "unless"))
    return Let(
        place=element.place,
        conditions=_conditions(entry),
        name=entry.required("name"),
        value=entry.required("value"),
    )


def _set_environment(element: Element) -> SetEnvironment:
    entry = Entry(element, ("name", "value", "if", "unless"))
    return SetEnvironment(
        place=element.place,
        conditions=_conditions(entry),
        name=entry.required("name"),
        value=entry.required("value"),
    )


def _append_environment(element: Element) -> Action:
    return replace(_set_environment(element), append=True)


def _unset_environment(element: Element) -> Action:
    entry = Entry(element, ("name", "if", "unless"))
    return SetEnvironment(
        place=element.place,
        conditions=_conditions(entry),
        name=entry.required("name"),
        value=None,
    )


def _include(element: Element) -> Action:
    entry = Entry(element, ("file", "arg", "let", "if", "unless"))
    return Include(
        place=element.place,
        conditions=_conditions(entry),
        file=entry.required("file"),
        arguments=(
            *pairs(entry.element("arg"), "name", "value"),
            *pairs(entry.element("let"), "name", "value"),
        ),
    )


def _group(element: Element) -> Action:
    if isinstance(element.value, list):
        return Group(place=element.place, scoped=True, actions=_actions(element))
    entry = Entry(element, ("children", "scoped", "if", "unless"))
    scoped = entry.element("scoped")
    if scoped is not None and not isinstance(scoped.value, bool):
        raise scoped.error(f"expected true or false, got {scoped.describe()}")
    return Group(
        place=element.place,
        conditions=_conditions(entry),
        scoped=scoped is None or scoped.value is True,
        actions=_actions(entry.required_element("children")),
    )


def _timer(element: Element) -> Action:
    entry = Entry(element, ("period", "children", "if", "unless"))
    return Timer(
        place=element.place,
        conditions=_conditions(entry),
        period=entry.required("period"),
        actions=_actions(entry.required_element("children")),
    )


def _push_namespace(element: Element) -> Action:
    entry = Entry(element, ("namespace", "if", "unless"))
    return PushNamespace(
        place=element.place, conditions=_conditions(entry), namespace=entry.required("namespace")
    )


def _set_parameter(element: Element) -> Action:
    entry = Entry(element, ("name", "value", "type", "if", "unless"))
    return SetParameter(
        place=element.place, conditions=_conditions(entry), parameter=parameter(entry)
    )


def _set_remap(element: Element) -> Action:
    entry = Entry(element, ("from", "to", "if", "unless"))
    return SetRemap(
        place=element.place,
        conditions=_conditions(entry),
        source=entry.required("from"),
        target=entry.required("to"),
    )


def _log(element: Element) -> Action:
    entry = Entry(element, ("level", "message", "if", "unless"))
    return Log(
        place=element.place,
        conditions=_conditions(entry),
        level=entry.optional("level") or template.literal("INFO"),
        message=entry.required("message"),
    )


def _shutdown(element: Element) -> Action:
    entry = Entry(element, ("reason", "if", "unless"))
    return Shutdown(
        place=element.place, conditions=_conditions(entry), reason=entry.required("reason")
    )


def _node(element: Element) -> Action:
    process, entry = parse_node(element)
    return replace(process, conditions=_conditions(entry))


def _executable(element: Element) -> Action:
    process, entry = parse_executable(element)
    return replace(process, conditions=_conditions(entry))


_PARSERS: dict[str, Callable[[Element], Action]] = {
    "append_env": _append_environment,
    "arg": _declare_argument,
    "executable": _executable,
    "group": _group,
    "include": _include,
    "let": _let,
    "log": _log,
    "node": _node,
    "push_ros_namespace": _push_namespace,
    "set_env": _set_environment,
    "set_parameter": _set_parameter,
    "set_remap": _set_remap,
    "shutdown": _shutdown,
    "timer": _timer,
    "unset_env": _unset_environment,
}

_UNSUPPORTED = dict.fromkeys(
    ("node_container", "load_composable_node"),
    "composable nodes are C++ libraries loaded into one process; use 'node' for each of them",
)
