"""Conversion of parameters of Python launch files to those of `teleopctl.launch`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from launch._texts import template
from launch.substitution import Substitution

from teleopctl.launch import (
    ParameterEntry as ModelParameter,
    ParameterFileEntry as ModelParameterFile,
    ParameterTree,
    Template,
)

from .parameter_descriptions import Parameter, ParameterFile, ParameterValue


# object: callers may pass anything, which is checked.
def parameters(given: object) -> Iterator[ModelParameter | ModelParameterFile]:
    """Yield the parameters and parameter files of a node.

    Raises:
        TypeError: There is something among them that is none.
    """
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise TypeError(f"Expecting list of parameters, got {given}")
    for entry in given:
        if isinstance(entry, Mapping):
            yield from _of_mapping(entry, ())
        elif isinstance(entry, Parameter):
            yield _parameter(template(entry.normalized_name), entry.parameter_value)
        elif isinstance(entry, ParameterFile):
            allows = entry.allows
            yield ModelParameterFile(
                template(entry.given),
                allow_substs=allows if isinstance(allows, bool) else template(allows),
            )
        else:
            yield ModelParameterFile(template(entry))


# object: keys and values are the user's.
def _of_mapping(
    given: Mapping[object, object], prefix: tuple[Template, ...]
) -> Iterator[ModelParameter]:
    for key, value in given.items():
        names = (*prefix, template(key))
        if isinstance(value, Mapping):
            yield from _of_mapping(value, names)
        else:
            yield _parameter(_joined(names), value)


def _joined(names: tuple[Template, ...]) -> Template:
    whole = names[0]
    for name in names[1:]:
        whole = Template((*whole.parts, ".", *name.parts), f"{whole.source}.{name.source}")
    return whole


def _parameter(name: Template, value: object) -> ModelParameter:
    type_name = None
    if isinstance(value, ParameterValue):
        type_name, value = value.type_name, value.normalized
    try:
        return ModelParameter(name, _tree(value), type_name)
    except TypeError as error:
        raise TypeError(f"parameter '{name.source}': {error}") from error


def _is_text(value: object) -> bool:
    return isinstance(value, str | Substitution) or (
        isinstance(value, Sequence) and any(isinstance(item, Substitution) for item in value)
    )


def _tree(value: object) -> ParameterTree:
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Substitution):
        return template(value)
    if isinstance(value, Sequence) and not isinstance(value, bytes):
        if _is_text(value) and all(isinstance(item, str | Substitution) for item in value):
            # As in ROS 2: texts beside substitutions are one text.
            return template(value)
        return [_item(item) for item in value]
    raise TypeError(f"{value!r} is no value of a parameter")


def _item(value: object) -> ParameterTree:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return template(value)
    return _tree(value)
