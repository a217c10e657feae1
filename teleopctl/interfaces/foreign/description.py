"""Definitions from ``type_description_interfaces/msg/TypeDescription`` of other nodes."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces.definition import (
    PLACEHOLDER,
    Definition,
    Field,
    FieldType,
    Shape,
)
from teleopctl.interfaces.hashing import BASE_IDS, BOUNDED_TEXT, NESTED_ID, SHAPE_STEP
from teleopctl.interfaces.typenames import is_lower_name, normalize

if TYPE_CHECKING:
    from type_description_interfaces.msg import (
        Field as FieldMessage,
        IndividualTypeDescription,
        TypeDescription,
    )

_BASES = {number: base for base, number in BASE_IDS.items() if base != "char"}


def definitions(description: TypeDescription) -> list[Definition]:
    """Return the `Definition`s in a type description message, the described type first.

    Args:
        description: Type description received from another node; not trusted.

    Raises:
        TeleopctlError: A name is malformed, or the number of a type is unknown.
    """
    return [
        _definition(individual)
        for individual in (
            description.type_description,
            *description.referenced_type_descriptions,
        )
    ]


def _definition(individual: IndividualTypeDescription) -> Definition:
    name = individual.type_name
    if normalize(name) != name:
        raise InvalidMessageError(f"{name!r} is not the full name of a type")
    fields = tuple(
        Field(field.name, _field_type(name, field))
        for field in individual.fields
        if field.name != PLACEHOLDER
    )
    for field in fields:
        if not is_lower_name(field.name):
            raise InvalidMessageError(f"{name} has a field of the name {field.name!r}")
    if len({field.name for field in fields}) != len(fields):
        raise InvalidMessageError(f"{name} has two fields of the same name")
    return Definition(name, fields)


def _field_type(type_name: str, field: FieldMessage) -> FieldType:
    number, kind = field.type.type_id, field.type
    shape, base_id = divmod(number, SHAPE_STEP)
    bounded = base_id in (BASE_IDS["string"] + BOUNDED_TEXT, BASE_IDS["wstring"] + BOUNDED_TEXT)
    if base_id == NESTED_ID:
        base = normalize(kind.nested_type_name)
    else:
        base = _BASES.get(base_id - BOUNDED_TEXT if bounded else base_id, "")
    needs_capacity = shape in (Shape.ARRAY, Shape.BOUNDED)
    if (
        not base
        or shape > Shape.UNBOUNDED
        or needs_capacity != bool(kind.capacity)
        or bounded != bool(kind.string_capacity)
    ):
        raise InvalidMessageError(
            f"Field {field.name!r} of {type_name} has the unknown type {number}"
        )
    return FieldType(base, Shape(shape), kind.capacity, kind.string_capacity)
