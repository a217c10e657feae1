"""Types of fields as values, with the names and the equality of ``rosidl_parser.definition``."""

from __future__ import annotations

from dataclasses import dataclass

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.interfaces.definition import IDL_ONLY, Shape
from teleopctl.interfaces.typenames import split

if TYPE_CHECKING:
    from teleopctl.interfaces.definition import Definition, FieldType

# What IDL calls the primitive types whose names differ.
_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float"}
_IDL_NAMES["float64"] = "double"


class AbstractType:
    """Any type."""


class AbstractNestableType(AbstractType):
    """A type that arrays and sequences may have."""


class AbstractGenericString(AbstractNestableType):
    """Any text."""

    def has_maximum_size(self) -> bool:
        """Return whether the type is bounded."""
        return False


class AbstractString(AbstractGenericString):
    """Any text of 8-bit characters."""


class AbstractWString(AbstractGenericString):
    """Any text of 16-bit characters."""


class AbstractNestedType(AbstractType):
    """A type of several values."""

    value_type: AbstractNestableType

    def has_maximum_size(self) -> bool:
        """Return whether the type is bounded."""
        return False


class AbstractSequence(AbstractNestedType):
    """Base of sequence types."""


@dataclass(frozen=True)
class BasicType(AbstractNestableType):
    """A number or a truth value, by its name in IDL."""

    typename: str


class NamespacedType(AbstractNestableType):
    """Another message.

    Args:
        namespaces: Package and kind.
        name: Its name there.
    """

    def __init__(self, namespaces: list[str] | tuple[str, ...], name: str) -> None:
        self.namespaces = list(namespaces)
        self.name = name

    def namespaced_name(self) -> tuple[str, ...]:
        """Return package, kind and name."""
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
    """A text of any length."""


@dataclass(frozen=True)
class BoundedString(AbstractString):
    """A text of at most so many characters."""

    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Return True: the string is bounded."""
        return True


@dataclass(frozen=True)
class UnboundedWString(AbstractWString):
    """A wide text of any length."""


@dataclass(frozen=True)
class BoundedWString(AbstractWString):
    """A wide text of at most so many characters."""

    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Return True: the string is bounded."""
        return True


@dataclass(frozen=True)
class Array(AbstractNestedType):
    """So many values."""

    value_type: AbstractNestableType
    size: int

    def has_maximum_size(self) -> bool:
        """Return True: the array has a fixed size."""
        return True


@dataclass(frozen=True)
class BoundedSequence(AbstractSequence):
    """At most so many values."""

    value_type: AbstractNestableType
    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Return True: the sequence is bounded."""
        return True


@dataclass(frozen=True)
class UnboundedSequence(AbstractSequence):
    """Any number of values."""

    value_type: AbstractNestableType


def slot_types(definition: Definition) -> tuple[AbstractType, ...]:
    """Return the types of a message's fields, in order."""
    return tuple(slot_type(field.type) for field in definition.fields)


def slot_type(kind: FieldType) -> AbstractType:
    """Return the type of a field."""
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
