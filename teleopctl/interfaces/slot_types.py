"""Field types as objects with the names and the equality of ``rosidl_parser.definition``."""

from __future__ import annotations

from dataclasses import dataclass

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.interfaces.definition import IDL_ONLY, Shape
from teleopctl.interfaces.typenames import split

if TYPE_CHECKING:
    from teleopctl.interfaces.definition import Definition, FieldType

# IDL names of the primitive types whose names differ.
_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float"}
_IDL_NAMES["float64"] = "double"


class AbstractType:
    """Base of slot types, the field types in ``Message.SLOT_TYPES``."""


class AbstractNestableType(AbstractType):
    """Base of slot types that arrays and sequences can contain."""


class AbstractGenericString(AbstractNestableType):
    """Base of the slot types of strings, bounded or not."""

    def has_maximum_size(self) -> bool:
        """Return False: the string is unbounded; overridden for bounded strings."""
        return False


class AbstractString(AbstractGenericString):
    """Base of the slot types of 8-bit strings."""


class AbstractWString(AbstractGenericString):
    """Base of the slot types of wide (16-bit) strings."""


class AbstractNestedType(AbstractType):
    """Base of the slot types of arrays and sequences."""

    value_type: AbstractNestableType

    def has_maximum_size(self) -> bool:
        """Return False: the length is unbounded; overridden for bounded types."""
        return False


class AbstractSequence(AbstractNestedType):
    """Base of the slot types of bounded and unbounded sequences."""


@dataclass(frozen=True)
class BasicType(AbstractNestableType):
    """Slot type of numbers, booleans and octets, by IDL name."""

    typename: str


class NamespacedType(AbstractNestableType):
    """Slot type of a nested message, by package, kind and name.

    Args:
        namespaces: Package and kind of the type.
        name: Name of the type without package and kind.
    """

    def __init__(self, namespaces: list[str] | tuple[str, ...], name: str) -> None:
        self.namespaces = list(namespaces)
        self.name = name

    def namespaced_name(self) -> tuple[str, ...]:
        """Return package, kind and name of the message type as a tuple."""
        return (*self.namespaces, self.name)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, NamespacedType) and self.namespaced_name() == other.namespaced_name()
        )

    def __hash__(self) -> int:
        return hash(self.namespaced_name())

    def __repr__(self) -> str:
        return f"NamespacedType(namespaces={self.namespaces!r}, name={self.name!r})"


@dataclass(frozen=True)
class UnboundedString(AbstractString):
    """Slot type of strings of unlimited length."""


@dataclass(frozen=True)
class BoundedString(AbstractString):
    """Slot type of strings of limited length."""

    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Return True: the string is bounded."""
        return True


@dataclass(frozen=True)
class UnboundedWString(AbstractWString):
    """Slot type of wide strings of unlimited length."""


@dataclass(frozen=True)
class BoundedWString(AbstractWString):
    """Slot type of wide strings of limited length."""

    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Return True: the string is bounded."""
        return True


@dataclass(frozen=True)
class Array(AbstractNestedType):
    """Slot type of arrays of fixed length."""

    value_type: AbstractNestableType
    size: int

    def has_maximum_size(self) -> bool:
        """Return True: the array has a fixed size."""
        return True


@dataclass(frozen=True)
class BoundedSequence(AbstractSequence):
    """Slot type of sequences of limited length."""

    value_type: AbstractNestableType
    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Return True: the sequence is bounded."""
        return True


@dataclass(frozen=True)
class UnboundedSequence(AbstractSequence):
    """Slot type of sequences of unlimited length."""

    value_type: AbstractNestableType


def slot_types(definition: Definition) -> tuple[AbstractType, ...]:
    """Return the slot types of a message's fields, in the order of the fields."""
    return tuple(slot_type(field.type) for field in definition.fields)


def slot_type(kind: FieldType) -> AbstractType:
    """Return the slot type for the type of a field: array, sequence or single value."""
    element = _element(kind)
    match kind.shape:
        case Shape.ARRAY:
            return Array(element, kind.capacity)
        case Shape.BOUNDED:
            return BoundedSequence(element, kind.capacity)
        case Shape.UNBOUNDED:
            return UnboundedSequence(element)
    return element


def _element(kind: FieldType) -> AbstractNestableType:
    if kind.base.startswith(IDL_ONLY):
        return BasicType(kind.base.removeprefix(IDL_ONLY))
    if kind.is_nested:
        package, folder, name = split(kind.base)
        return NamespacedType([package, folder], name)
    if kind.base == "string":
        return BoundedString(kind.string_capacity) if kind.string_capacity else UnboundedString()
    if kind.base == "wstring":
        return BoundedWString(kind.string_capacity) if kind.string_capacity else UnboundedWString()
    return BasicType(_IDL_NAMES.get(kind.base, kind.base))
