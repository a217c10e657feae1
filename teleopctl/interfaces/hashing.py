"""RIHS01 type hashes, by which the endpoints of a topic or a service match."""

from __future__ import annotations

from teleopctl.base.lazy import import_module
from teleopctl.base.typed import Any, Callable, cache
from teleopctl.interfaces.definition import Definition, Field

NOT_SUPPORTED = "TypeHashNotSupported"
"""Text in keys and tokens of ROS 2 Humble in place of a type hash."""

Lookup = Callable[[str], Definition]

NESTED_ID = 1
BOUNDED_TEXT = 4
"""Added to the id of a string type that has a bound."""

# A char of a definition file is a uint8 here; ids 12 to 14 exist for IDL files only.
BASE_IDS = {
    "int8": 2,
    "uint8": 3,
    "char": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
SHAPE_STEP = 48
"""Added to the id once for an array, twice for a bounded, three times for an unbounded sequence."""


def type_description(definition: Definition, lookup: Lookup) -> dict[str, object]:
    """Return the description of a type and of all types used, as the dictionaries to hash.

    Args:
        definition: Definition of the type.
        lookup: Function that returns the definition of a type by its full name.

    Returns:
        ``type_description`` and, sorted by name, all ``referenced_type_descriptions``.
    """
    referenced: dict[str, Definition] = {}
    waiting = definition.nested_types()
    while waiting:
        name = waiting.pop()
        if name not in referenced and name != definition.type_name:
            referenced[name] = lookup(name)
            waiting.extend(referenced[name].nested_types())
    return {
        "type_description": fields_of(definition),
        "referenced_type_descriptions": [fields_of(referenced[n]) for n in sorted(referenced)],
    }


def type_hash(definition: Definition, lookup: Lookup) -> str:
    """Return the hash of a type, ``RIHS01_`` and 64 hexadecimal digits."""
    # As JSON, whose import takes longer than all hashes: names and types have no characters that
    # JSON or Python would escape, and there are neither bools nor None.
    text = repr(type_description(definition, lookup)).replace("'", '"')
    return f"RIHS01_{_sha256()(text.encode('ascii')).hexdigest()}"


@cache
def _sha256() -> Any:
    """Return Python's own SHA-256: hashlib loads OpenSSL, which takes longer than all hashes."""
    for module in ("_sha2", "_sha256"):  # since Python 3.12, and before
        try:
            return import_module(module).sha256
        except (ImportError, AttributeError):
            continue
    return import_module("hashlib").sha256


def field_type_id(field: Field) -> int:
    """Return the number of a field's type in ``type_description_interfaces/msg/FieldType``."""
    base = BASE_IDS.get(field.type.base, NESTED_ID)
    if field.type.string_capacity:
        base += BOUNDED_TEXT
    return base + SHAPE_STEP * field.type.shape


def fields_of(definition: Definition) -> dict[str, object]:
    """Return name and fields of one type as a dictionary, a part of the type description."""
    return {
        "type_name": definition.type_name,
        "fields": [
            {
                "name": field.name,
                "type": {
                    "type_id": field_type_id(field),
                    "capacity": field.type.capacity,
                    "string_capacity": field.type.string_capacity,
                    "nested_type_name": field.type.base if field.type.is_nested else "",
                },
            }
            for field in definition.wire_fields
        ],
    }
