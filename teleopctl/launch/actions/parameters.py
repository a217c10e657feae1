"""Readers of the parameters in ``node``, ``set_parameter`` and components of launch files."""

from __future__ import annotations

from teleopctl.base.typed import Iterator
from teleopctl.launch.model.action import Entity
from teleopctl.launch.model.descriptions import ParameterEntry, ParameterFileEntry, ParameterTree
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.template import parse

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


def parameter(entity: Entity, prefix: str = "") -> ParameterEntry:
    """Return the unevaluated parameter that an entry defines, its name after a prefix."""
    type_element = entity.element("type")
    type_name = None if type_element is None else type_element.text()
    if type_element is not None and type_name not in PARAMETER_TYPES:
        raise type_element.error(
            f"unknown type '{type_name}', expected one of {', '.join(sorted(PARAMETER_TYPES))}"
        )
    name = entity.required("name")
    return ParameterEntry(
        name=parse(f"{prefix}{name.source}") if prefix else name,
        value=_parameter_value(_value(entity.required_element("value"), type_name)),
        type_name=type_name,
    )


def parameters(
    element: Element | None, prefix: str = ""
) -> Iterator[ParameterEntry | ParameterFileEntry]:
    """Yield the parameters (nested: dotted names) and files of a ``param`` list; none for None."""
    if element is None:
        return
    for item in element.items("a list of 'name: …, value: …' or 'from: FILE'"):
        entity = Entity(item, ("name", "value", "type", "param", "from", "allow_substs"))
        if entity.element("from") is not None:
            _refuse_together(entity, "from", "name", "value", "type", "param")
            yield ParameterFileEntry(
                entity.required("from"), entity.optional("allow_substs") or False
            )
            continue
        _refuse_together(entity, "param", "value", "type")
        _refuse_together(entity, "allow_substs", "name")
        if entity.element("param") is not None:
            yield from parameters(
                entity.element("param"), f"{prefix}{entity.required_text('name')}."
            )
        else:
            yield parameter(entity, prefix)


def _refuse_together(entity: Entity, key: str, *others: str) -> None:
    if entity.element(key) is None:
        return
    for other in others:
        if (element := entity.element(other)) is not None:
            raise element.error(f"'{key}' and '{other}' exclude each other")


def _value(element: Element, type_name: str | None) -> Element:
    """Return a value typed by its language; a text with an explicit scalar type stays a text."""
    is_text = isinstance(element.value, str)
    if type_name is None or (type_name.startswith("list_of_") and is_text):
        return element.typed()
    return element


def _parameter_value(element: Element) -> ParameterTree:
    if isinstance(element.value, list):
        return [_parameter_value(item) for item in element.value]
    if isinstance(element.value, bool | int | float):
        return element.value
    template = element.template()
    # YAML has typed the value: quoted digits are a text. Only results of substitutions are untyped.
    return "".join(map(str, template.parts)) if template.is_literal else template
