"""Completion candidates for types, fields and default values of messages and services."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli.completion.completing import TypedWords
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from teleopctl.interfaces import Definition, FieldType

# Parameters of verbs with a type, and the suffix of the message of that type to complete.
_TYPES = {"message_type": "", "service_type": "_Request", "type_name": "_Goal"}


def message_types(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return types of the topic on the command line, else all; topics for a text with ``/``."""
    from teleopctl.interfaces import list_types

    if incomplete.startswith("/"):
        from teleopctl.cli.completion.candidates import topics

        return topics(incomplete)
    live = _live_types(ctx.params.get("topic_name"))
    return [name for name in live or list_types("msg") if name.startswith(incomplete)]


def service_types(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the types of the service given on the command line, else all known ones."""
    from teleopctl.cli.graph_lookup import absolute_name, live_graph
    from teleopctl.interfaces import list_types

    live: list[str] = []
    if name := ctx.params.get("service_name"):
        try:
            services = dict(live_graph().service_names_and_types(include_hidden=True))
        except TeleopctlError:
            services = {}
        live = services.get(absolute_name(name), [])
    return [type_ for type_ in live or list_types("srv") if type_.startswith(incomplete)]


def prototypes(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return one candidate: the default message, request or goal of the given type, as YAML."""
    from teleopctl.interfaces import normalize

    try:
        for name, part in _TYPES.items():
            if written := ctx.params.get(name):
                definition = _definition(normalize(written) + part)
                text = definition and _mapping(definition)
                return [text] if text and text.startswith(incomplete) else []
    except TeleopctlError:
        pass
    return []


def fields(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the next field paths of the message type, or of the topic, on the command line."""
    from teleopctl.interfaces import normalize

    try:
        written = ctx.params.get("message_type") or "/"  # the parameter may also hold a topic
        is_type = not written.startswith("/")
        types = [normalize(written)] if is_type else _live_types(ctx.params.get("topic_name"))
        definition = _definition(types[0]) if types else None
        *above, _ = incomplete.split(".")
        for name in above:
            field = definition and _fields(definition).get(name.partition("[")[0])
            definition = _definition(field.base) if field and field.is_nested else None
    except TeleopctlError:
        return []
    if definition is None:
        return []
    path = "".join(f"{name}." for name in above)
    offered = _offered_fields(definition)
    return [path + name for name in offered if (path + name).startswith(incomplete)]


def _offered_fields(definition: Definition) -> Iterator[str]:
    for name, type_ in _fields(definition).items():
        yield name
        element = f"{name}[0]" if type_.shape else name
        if type_.shape:
            yield element
        if type_.is_nested:
            yield f"{element}."


def _live_types(topic: str | list[str] | None) -> list[str]:
    from teleopctl.cli.graph_lookup import absolute_name, live_graph

    if not topic:
        return []
    name = topic if isinstance(topic, str) else topic[0]
    try:
        types = dict(live_graph().topic_names_and_types(include_hidden=True))
    except TeleopctlError:
        return []
    return list(types.get(absolute_name(name), []))


def _definition(name: str) -> Definition | None:
    from teleopctl.interfaces import known_types

    return known_types().find(name)


def _fields(definition: Definition) -> dict[str, FieldType]:
    return {field.name: field.type for field in definition.fields}


def _mapping(definition: Definition) -> str:
    """Return a message with default values in YAML on one line."""
    values = [f"{field.name}: {_value(field.type, field.default)}" for field in definition.fields]
    return f"{{{', '.join(values)}}}"


def _value(type_: FieldType, default: object) -> str:
    if default is not None:
        return _literal(default)
    if type_.shape == type_.shape.ARRAY:
        return f"[{', '.join([_value(type_.element, None)] * type_.capacity)}]"
    if type_.shape:
        return "[]"
    if type_.is_nested:
        nested = _definition(type_.base)
        return _mapping(nested) if nested else "{}"
    others = {"string": "''", "wstring": "''", "bool": "false", "float32": "0.0", "float64": "0.0"}
    return others.get(type_.base, "0")


def _literal(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_literal, value))}]"
    return str(value)
