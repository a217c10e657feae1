"""Layout of values in CDR, the encoding of messages on the wire.

The rules are those of XCDR version 1 (OMG DDS-XTypes 1.3, 7.4.3), called PLAIN_CDR:

* Four bytes of encapsulation come first: ``00 01`` for little-endian, ``00 00`` for big-endian,
  and two bytes of options. Alignment is relative to the end of the encapsulation.
* A number is aligned to a multiple of its size by padding bytes. A bool, an octet and a char take
  one byte.
* A string is a uint32, the number of its bytes with a NUL at the end, and these bytes.
* A wide string is a uint32, the number of its UTF-16 units, and the units of two bytes each,
  without a terminator, as Fast CDR 2 of ROS 2 Jazzy and later writes it. XTypes counts bytes.
* A sequence is a uint32, the number of its elements, and the elements. An array is the elements.
* A message is its fields, without padding of its own; in ROS 2 a message without fields has a byte.

All values between strings and sequences have a fixed size: one call of a ``struct.Struct`` reads or
writes such a *run* of values. The padding inside a run depends only on its start position modulo 8.
"""

from __future__ import annotations

from struct import Struct

from teleopctl.base.typed import Callable, TypeAlias, cache
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces.blocks import BLOCK_CODES, ITEM_SIZES
from teleopctl.interfaces.definition import Definition, FieldType, Shape

HEADER_SIZE = 4
MAXIMUM_ALIGNMENT = 8

Offsets: TypeAlias = frozenset[int]
"""Possible positions of a value in the data, modulo 8, as the generator can determine them."""

START: Offsets = frozenset({HEADER_SIZE})
ANYWHERE: Offsets = frozenset(range(MAXIMUM_ALIGNMENT))

_COUNT_SIZE = 4
_SHORTEST_STRING = 5
_INLINED_FIELDS = 64
_INLINED_ELEMENT_FIELDS = 10


def padding(position: int, alignment: int) -> int:
    """Return the padding in bytes from a position in the data to the next aligned position."""
    return (HEADER_SIZE - position) % alignment


class Run:
    """Run of fixed-size values that one struct format packs."""

    def __init__(self) -> None:
        self._items: list[tuple[int, str, int]] = []

    def __bool__(self) -> bool:
        return bool(self._items)

    def add(self, code: str) -> None:
        """Append a value to the run by its struct code; ``x`` is padding."""
        size = ITEM_SIZES.get(code, 1)
        self._items.append((size, code, size))

    def add_block(self, code: str, count: int) -> None:
        """Append a fixed array of ``count`` values, packed as bytes."""
        size = ITEM_SIZES[code]
        self._items.append((size, f"{count * size}s", count * size))

    def is_single_pad(self) -> bool:
        """Return whether the run is a single padding byte, such as a string's terminating NUL."""
        return [code for _, code, _ in self._items] == ["x"]

    def struct_at(self, start: int, order: str) -> Struct:
        """Return the `Struct`, padding included, for the run at a start position in the data."""
        return _make_struct(tuple(self._items), start, order)

    def ends(self, starts: Offsets) -> Offsets:
        """Return the possible end positions of the run, modulo 8, for its start positions."""
        return frozenset(
            (start + self.struct_at(start, "<").size) % MAXIMUM_ALIGNMENT for start in starts
        )


@cache
def _make_struct(items: tuple[tuple[int, str, int], ...], start: int, order: str) -> Struct:
    position = start
    parts = [order]
    for alignment, code, size in items:
        gap = padding(position, alignment)
        parts.append(f"{gap}x{code}" if gap else code)
        position += gap + size
    return _struct_of("".join(parts))


@cache
def _struct_of(code: str) -> Struct:
    """Return the struct of a format, cached."""
    return Struct(code)


def after_block(starts: Offsets, size: int) -> Offsets:
    """Return the possible end positions, modulo 8, of an aligned block of any length."""
    ends: set[int] = set()
    for start in starts:
        first = start + padding(start, size)
        ends.update((first + size * n) % MAXIMUM_ALIGNMENT for n in range(MAXIMUM_ALIGNMENT))
    return frozenset(ends)


# Messages of fewer bytes are not checked against the budget, so that short commands do not import
# its module.
_USUAL_BYTES = 2**20


class Layout:
    """Smallest wire sizes of types, which types can be sent, and which nested code is inlined.

    Args:
        definition: Function that returns the definition of a type by its full name.
    """

    def __init__(self, definition: Callable[[str], Definition]) -> None:
        self.definition = definition
        self._weights: dict[str, int] = {}
        self._minimums: dict[str, int] = {}

    def is_inlined(self, type_name: str, is_element: bool) -> bool:
        """Return whether the code of a nested message is inlined in that of the outer one.

        The limit keeps the code short for types that contain each other many times. It is lower
        for elements of sequences, whose types mostly occur in several messages, so that generating
        their code once saves time.
        """
        limit = _INLINED_ELEMENT_FIELDS if is_element else _INLINED_FIELDS
        return self._weight(type_name, ()) <= limit

    def minimum(self, kind: FieldType) -> int:
        """Return the smallest wire size of a field's type in bytes, without padding."""
        if kind.shape in (Shape.BOUNDED, Shape.UNBOUNDED):
            return _COUNT_SIZE
        count = kind.capacity if kind.shape is Shape.ARRAY else 1
        return count * self.element_minimum(kind)

    def element_minimum(self, kind: FieldType) -> int:
        """Return the smallest wire size of one value of a type in bytes, without padding."""
        if kind.base in BLOCK_CODES:
            return ITEM_SIZES[BLOCK_CODES[kind.base]]
        if not kind.is_nested:
            return _COUNT_SIZE if kind.base == "wstring" else _SHORTEST_STRING
        if kind.base not in self._minimums:
            self._weight(kind.base, ())
            fields = self.definition(kind.base).wire_fields
            self._minimums[kind.base] = sum(self.minimum(field.type) for field in fields)
        return self._minimums[kind.base]

    def check(self, type_name: str) -> None:
        """Raise InvalidMessageError if a type contains itself, or its messages are too large."""
        self._weight(type_name, ())
        least = self.minimum(FieldType(type_name))
        if least < _USUAL_BYTES:
            return
        from teleopctl.base.budget import UNPACKED_BYTES

        if least > UNPACKED_BYTES:
            raise InvalidMessageError(
                f"A message of type {type_name} has at least {least:,} bytes;"
                f" at most {UNPACKED_BYTES:,} are made by a definition alone"
            )

    def _weight(self, type_name: str, outer: tuple[str, ...]) -> int:
        """Return the number of fields of a message, including those of nested messages."""
        if type_name in outer:
            raise InvalidMessageError(f"{type_name} contains itself")
        if type_name not in self._weights:
            fields = self.definition(type_name).wire_fields
            self._weights[type_name] = 1 + sum(
                self._weight(kind.base, (*outer, type_name)) if kind.is_nested else 1
                for kind in (field.type for field in fields)
            )
        return self._weights[type_name]
