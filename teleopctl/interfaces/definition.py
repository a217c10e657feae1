"""Parsed interface definitions: fields with types and defaults, and constants."""

from __future__ import annotations

import keyword

from teleopctl.base.typed import IntEnum, NamedTuple
from teleopctl.interfaces.typenames import KINDS

PLACEHOLDER = "structure_needs_at_least_one_member"
"""Name of the uint8 that a type without fields has on the wire and in the type hash."""

INTEGER_RANGES = {
    "int8": (-(2**7), 2**7 - 1),
    "uint8": (0, 2**8 - 1),
    "char": (0, 2**8 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint64": (0, 2**64 - 1),
}
FLOATS = frozenset({"float32", "float64"})
STRINGS = frozenset({"string", "wstring"})
PRIMITIVES = frozenset({*INTEGER_RANGES, *FLOATS, *STRINGS, "bool", "byte"})

IDL_ONLY = "idl::"
"""Prefix of base types that IDL has but messages do not have, such as ``idl::wchar``."""

_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8"} | {
    "float32": "float",
    "float64": "double",
}


class Shape(IntEnum):
    """Multiplicity of a field: single, array, bounded or unbounded sequence."""

    SINGLE = 0
    ARRAY = 1
    BOUNDED = 2
    UNBOUNDED = 3


class FieldType(NamedTuple):
    """Type of a field: base type, multiplicity and bounds.

    Attributes:
        base: Primitive type (``uint8``, ``string``, …) or message type (``package/msg/Name``).
        shape: Single value, fixed array, or sequence with or without a bound.
        capacity: Length of the array or bound of the sequence, else 0.
        string_capacity: Bound of a bounded string in characters, else 0.
    """

    base: str
    shape: Shape = Shape.SINGLE
    capacity: int = 0
    string_capacity: int = 0

    @property
    def is_nested(self) -> bool:
        """Whether the values of the field are messages."""
        return self.base not in PRIMITIVES

    @property
    def is_numeric(self) -> bool:
        """Whether the base type is an integer or float type, not bool, byte or string."""
        return self.base in INTEGER_RANGES or self.base in FLOATS

    @property
    def element(self) -> FieldType:
        """Type of a single element of the array or sequence."""
        return FieldType(self.base, string_capacity=self.string_capacity)

    def __str__(self) -> str:
        """Return the type as a definition file writes it."""
        base = self.base.replace("/msg/", "/")
        if self.string_capacity:
            base += f"<={self.string_capacity}"
        match self.shape:
            case Shape.ARRAY:
                return f"{base}[{self.capacity}]"
            case Shape.BOUNDED:
                return f"{base}[<={self.capacity}]"
            case Shape.UNBOUNDED:
                return f"{base}[]"
        return base

    def idl(self) -> str:
        """Return the type in the spelling of ROS 2's ``get_fields_and_field_types``."""
        base = _IDL_NAMES.get(self.base, self.base)
        for kind in KINDS:
            base = base.replace(f"/{kind}/", "/")
        if self.string_capacity:
            base += f"<{self.string_capacity}>"
        match self.shape:
            case Shape.ARRAY:
                return f"{base}[{self.capacity}]"
            case Shape.BOUNDED:
                return f"sequence<{base}, {self.capacity}>"
            case Shape.UNBOUNDED:
                return f"sequence<{base}>"
        return base


class Field(NamedTuple):
    """Field of a message; ``default`` is None if unset."""

    name: str
    type: FieldType
    default: object = None

    @property
    def attribute(self) -> str:
        """Name of the field in Python, with an underscore appended to keywords."""
        return f"{self.name}_" if keyword.iskeyword(self.name) else self.name


class Constant(NamedTuple):
    """Constant of a message."""

    name: str
    base: str
    value: object


class Definition(NamedTuple):
    """Definition of a message, or of one section of a service or an action.

    Attributes:
        type_name: Full name of the type, ``package/kind/Name``.
        fields: Fields in the order of the definition.
        constants: Constants in the order of the definition.
        text: Text of the definition; None if only fields and constants are known.
    """

    type_name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()
    text: str | None = None

    @property
    def wire_fields(self) -> tuple[Field, ...]:
        """Fields on the wire: those of the definition, or one placeholder if it has none."""
        return self.fields or (Field(PLACEHOLDER, FieldType("uint8")),)

    def nested_types(self) -> list[str]:
        """Return the names of the message types of the fields, each once, without deeper ones."""
        return list(dict.fromkeys(f.type.base for f in self.fields if f.type.is_nested))

    def render(self) -> str:
        """Return the text of the definition: as it was parsed, else composed from the fields."""
        if self.text is not None:
            return self.text
        lines = [f"{c.base} {c.name}={_literal(c.value)}" for c in self.constants]
        if self.constants and self.fields:
            lines.append("")
        for field in self.fields:
            default = "" if field.default is None else f" {_literal(field.default)}"
            lines.append(f"{field.type} {field.name}{default}")
        return "".join(f"{line}\n" for line in lines)


def _literal(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)
