"""The keys of ``node`` and ``executable``."""

from __future__ import annotations

from collections.abc import Iterator

from teleopctl.launch.frontends.yaml.entries import Entry
from teleopctl.launch.frontends.yaml.tree import Element
from teleopctl.launch.model.descriptions import (
    NodePart,
    Parameter,
    ParameterFile,
    ParameterTree,
    StartProcess,
)
from teleopctl.launch.model.template import Template, literal, parse

PARAMETER_TYPES = frozenset(
    {
        "bool",
        "int",
        "float",
        "str",
        "list_of_bool",
        "list_of_int",
        "list_of_float",
        "list_of_str",
    }
)

_PROCESS_KEYS = (
    "args",
    "cwd",
    "emulate_tty",  # output reaches us unbuffered with and without it
    "env",
    "launch-prefix",
    "on_exit",
    "output",
    "required",
    "respawn",
    "respawn_delay",
    "respawn_max_retries",
    "sigkill_timeout",
    "sigterm_timeout",
)
NODE_KEYS = (
    "pkg",
    "exec",
    "name",
    "namespace",
    "exec_name",
    "param",
    "remap",
    "ros_args",
    *_PROCESS_KEYS,
)
EXECUTABLE_KEYS = ("cmd", "name", "shell", *_PROCESS_KEYS)


def read_node(entry: Entry) -> StartProcess:
    """Read a ``node``."""
    node = NodePart(
        package=entry.required("pkg"),
        executable=entry.required("exec"),
        name=entry.optional("name"),
        namespace=entry.optional("namespace"),
        parameters=tuple(_parameters(entry.element("param"))),
        remaps=tuple(pairs(entry.element("remap"), "from", "to")),
        ros_arguments=entry.optional("ros_args"),
    )
    return _process(entry, process_name=entry.optional("exec_name"), node=node)


def read_executable(entry: Entry) -> StartProcess:
    """Read an ``executable``."""
    return _process(
        entry,
        process_name=entry.optional("name"),
        command=entry.required("cmd"),
        shell=entry.optional("shell"),
    )


def parameter(entry: Entry, prefix: str = "") -> Parameter:
    """Read a parameter with ``name``, ``value`` and perhaps ``type``."""
    type_element = entry.element("type")
    type_name = None if type_element is None else type_element.text()
    if type_element is not None and type_name not in PARAMETER_TYPES:
        raise type_element.error(
            f"unknown type '{type_name}', expected one of {', '.join(sorted(PARAMETER_TYPES))}"
        )
    name = entry.required("name")
    return Parameter(
        name=parse(f"{prefix}{name.source}") if prefix else name,
        value=_parameter_value(entry.required_element("value")),
        type_name=type_name,
    )


def _process(
    entry: Entry,
    *,
    process_name: Template | None,
    node: NodePart | None = None,
    command: Template | None = None,
    shell: Template | None = None,
) -> StartProcess:
    return StartProcess(
        node=node,
        command=command,
        shell=shell,
        process_name=process_name,
        arguments=entry.optional("args"),
        working_directory=entry.optional("cwd"),
        environment=tuple(pairs(entry.element("env"), "name", "value")),
        prefix=entry.optional("launch-prefix"),
        output=entry.optional("output"),
        respawn=entry.optional("respawn"),
        respawn_delay=entry.optional("respawn_delay"),
        respawn_max_retries=entry.optional("respawn_max_retries"),
        shutdown_on_exit=_shutdown_on_exit(entry),
        sigterm_timeout=entry.optional("sigterm_timeout"),
        sigkill_timeout=entry.optional("sigkill_timeout"),
    )


def _shutdown_on_exit(entry: Entry) -> Template | None:
    on_exit = entry.element("on_exit")
    if on_exit is None:
        return entry.optional("required")
    if on_exit.value != "shutdown":
        raise on_exit.error(f"expected 'shutdown', got {on_exit.describe()}")
    return literal("true")


def pairs(element: Element | None, first: str, second: str) -> Iterator[tuple[Template, Template]]:
    """Read a list of mappings that have two keys each."""
    if element is None:
        return
    for item in element.items(f"a list of mappings with '{first}' and '{second}'"):
        entry = Entry(item, (first, second))
        yield entry.required(first), entry.required(second)


def _parameters(element: Element | None, prefix: str = "") -> Iterator[Parameter | ParameterFile]:
    if element is None:
        return
    for item in element.items("a list of 'name: …, value: …' or 'from: FILE'"):
        entry = Entry(item, ("name", "value", "type", "param", "from"))
        if entry.element("from") is not None:
            yield ParameterFile(entry.required("from"))
        elif entry.element("param") is not None:
            yield from _parameters(
                entry.element("param"), f"{prefix}{entry.required_text('name')}."
            )
        else:
            yield parameter(entry, prefix)


def _parameter_value(element: Element) -> ParameterTree:
    if isinstance(element.value, list):
        return [_parameter_value(item) for item in element.value]
    if isinstance(element.value, bool | int | float):
        return element.value
    return element.template()
