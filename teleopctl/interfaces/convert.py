"""Checks and conversions of the values that programs assign to fields.

A converter takes the assigned value and returns the value that the field stores, or raises
TypeError or ValueError with a text like ``expected uint32, got 'abc'``. The caller puts the field's
name before the text. Sequences of numbers are stored in the type in which they were assigned
(``array.array``, numpy array or memoryview of bytes), so that large blocks of data are not copied.
"""

from __future__ import annotations

from _operator import index as to_int

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, Iterable, cache
from teleopctl.interfaces.blocks import (
    ITEM_SIZES,
    TYPE_CODES,
    as_block,
    is_array,
    is_numpy_array,
    is_numpy_bool,
    new_array,
    numpy_type,
)
from teleopctl.interfaces.definition import FLOATS, INTEGER_RANGES, STRINGS, FieldType, Shape

if TYPE_CHECKING:
    import array

    from teleopctl.interfaces.blocks import NumberArray

Converter = Callable[[Any], Any]

_INFINITY = float("inf")
_FLOAT32_MAX = 3.4028234663852886e38
_SHOWN = 60


def expected(kind: FieldType | str, value: object) -> str:
    """Return the text "expected TYPE, got VALUE" for a value that does not fit a field's type."""
    shown = repr(value)
    if len(shown) > _SHOWN:
        shown = f"{shown[:_SHOWN]}…"
    return f"expected {kind}, got {shown}"


@cache
def converter(kind: FieldType, message_class: Callable[[str], type]) -> Converter:
    """Return the cached function that checks values for a field and converts them for storage.

    Args:
        kind: Type of the field.
        message_class: Function that returns the class of a message type by its full name; called
            at the first conversion.
    """
    if kind.shape is Shape.SINGLE:
        return _single(kind, message_class)
    if kind.is_numeric:
        return _fixed_numbers(kind) if kind.shape is Shape.ARRAY else _numbers(kind)
    return _list(kind, _single(kind.element, message_class))


def _single(kind: FieldType, message_class: Callable[[str], type]) -> Converter:
    if kind.base in INTEGER_RANGES:
        return _integer(kind)
    if kind.base in FLOATS:
        return _float(kind)
    if kind.base in STRINGS:
        return _string(kind)
    if kind.base == "bool":
        return _bool
    if kind.base == "byte":
        return _byte
    return _message(kind, message_class)


def _integer(kind: FieldType) -> Converter:
    low, high = INTEGER_RANGES[kind.base]

    def convert(value: Any) -> int:
        if type(value) is not int:
            try:
                value = to_int(value)
            except TypeError:
                raise TypeError(expected(kind, value)) from None
        if not low <= value <= high:
            raise ValueError(f"{expected(kind, value)}, which is not in {low}…{high}")
        return int(value)

    return convert


def _float(kind: FieldType) -> Converter:
    limit = _FLOAT32_MAX if kind.base == "float32" else _INFINITY

    def convert(value: Any) -> float:
        if type(value) is not float:
            if not _is_real(value):
                raise TypeError(expected(kind, value))
            try:
                value = float(value)
            except OverflowError:
                raise ValueError(expected(kind, value)) from None
        if not -limit <= value <= limit and -_INFINITY < value < _INFINITY:
            raise ValueError(f"{expected(kind, value)}, which is out of range")
        return float(value)

    return convert


def _is_real(value: object) -> bool:
    if isinstance(value, int):
        return True
    from numbers import Real

    return isinstance(value, Real) or is_numpy_bool(value)


def _string(kind: FieldType) -> Converter:
    bound = kind.string_capacity

    def convert(value: Any) -> str:
        if not isinstance(value, str):
            raise TypeError(expected(kind, value))
        if bound and len(value) > bound:
            raise ValueError(f"{expected(kind, value)} of {len(value)} characters")
        return value

    return convert


def _bool(value: Any) -> bool:
    if isinstance(value, bool) or is_numpy_bool(value):
        return bool(value)
    raise TypeError(expected("bool", value))


def _byte(value: Any) -> bytes:
    if isinstance(value, bytes | bytearray):
        if len(value) == 1:
            return bytes(value)
    elif not (isinstance(value, bool) or is_numpy_bool(value)):
        try:
            return bytes((to_int(value),))
        except (TypeError, ValueError):
            pass
    raise ValueError(expected("byte", value))


def _message(kind: FieldType, message_class: Callable[[str], type]) -> Converter:
    wanted: type | None = None

    def convert(value: Any) -> object:
        nonlocal wanted
        if wanted is None:
            wanted = message_class(kind.base)
        if isinstance(value, wanted):
            return value
        if hasattr(value, "to_msg"):  # a Time or a Duration of the client library
            value = value.to_msg()
            if isinstance(value, wanted):
                return value
        got = getattr(type(value), "TYPE_NAME", None)
        raise TypeError(f"expected {kind.base}, got {got}" if got else expected(kind.base, value))

    return convert


def _list(kind: FieldType, convert_element: Converter) -> Converter:
    plain = kind.base in STRINGS or kind.is_nested  # conversion does not change elements

    def convert(value: Any) -> list[Any]:
        if is_numpy_array(value):
            value = value.tolist()
        elif kind.base == "byte" and isinstance(value, bytes | bytearray):
            value = [bytes((number,)) for number in value]
        if isinstance(value, str | bytes | dict) or not isinstance(value, Iterable):
            raise TypeError(expected(kind, value))
        given = value if isinstance(value, list) else list(value)
        check_length(kind, len(given))
        converted: list[Any] = []
        for index, element in enumerate(given):
            try:
                converted.append(convert_element(element))
            except (TypeError, ValueError) as error:
                raise type(error)(f"element {index}: {error}") from None
        # As in ROS 2, a list whose elements need no conversion is stored without a copy.
        return given if plain else converted

    return convert


def check_length(kind: FieldType, length: int) -> None:
    """Raise ValueError if an array or sequence type does not allow a number of elements."""
    if kind.shape is Shape.ARRAY and length != kind.capacity:
        raise ValueError(f"expected {kind}, got {length} elements")
    if kind.shape is Shape.BOUNDED and length > kind.capacity:
        raise ValueError(f"expected {kind}, got {length} elements")


def _numbers(kind: FieldType) -> Converter:
    code = TYPE_CODES[kind.base]
    bounded = kind.shape is Shape.BOUNDED

    def convert(value: Any) -> array.array[Any] | memoryview | NumberArray:
        stored: array.array[Any] | memoryview | NumberArray
        if is_array(value) and value.typecode == code:
            stored = value
        elif isinstance(value, list | tuple):
            stored = _collect(kind, value, code)
        elif isinstance(value, bytes | bytearray | memoryview):
            if ITEM_SIZES[code] != 1:
                raise TypeError(expected(kind, value))
            # bytes are immutable, so that a view is safe; bytearray and memoryview are copied.
            stored = as_block(kind.base, value if isinstance(value, bytes) else bytes(value))
        elif is_numpy_array(value):
            stored = _from_numpy(kind, value)
        elif isinstance(value, str | dict) or not isinstance(value, Iterable):
            raise TypeError(expected(kind, value))
        else:
            stored = _collect(kind, value, code)
        if bounded:
            check_length(kind, len(stored))
        return stored

    return convert


def _fixed_numbers(kind: FieldType) -> Converter:
    convert_numbers = _numbers(kind)

    def convert(value: Any) -> array.array[Any] | memoryview | NumberArray:
        stored = convert_numbers(value)
        check_length(kind, len(stored))
        # The message stores its own copy, except of a memoryview, whose bytes are immutable.
        own: array.array[Any] | memoryview | NumberArray = stored
        if is_numpy_array(stored):
            own = stored.copy()
        elif stored is value:
            own = stored[:]
        return own

    return convert


def _collect(kind: FieldType, values: Iterable[Any], code: str) -> array.array[Any]:
    given = values if isinstance(values, list | tuple) else list(values)
    try:
        stored = new_array(code, given)
        # array converts values out of float32's range to infinity without an error.
        if code != "f" or not (_INFINITY in stored or -_INFINITY in stored):
            return stored
    except (TypeError, ValueError, OverflowError):
        pass
    check = _float(kind.element) if kind.base in FLOATS else _integer(kind.element)
    converted = new_array(code)
    for index, element in enumerate(given):
        try:
            converted.append(check(element))
        except (TypeError, ValueError) as error:
            raise type(error)(f"element {index}: {error}") from None
    return converted


def _from_numpy(kind: FieldType, value: NumberArray) -> NumberArray:
    import numpy as np

    dtype = numpy_type(kind.base)
    flat = np.ascontiguousarray(value).reshape(-1)
    if flat.dtype == dtype:
        return flat
    if flat.size == 0:
        return np.empty(0, dtype)
    if flat.dtype.kind not in "iufb" or (flat.dtype.kind == "f" and dtype.kind != "f"):
        raise TypeError(f"expected {kind}, got an array of {flat.dtype}")
    if dtype.kind in "iu":
        low, high = INTEGER_RANGES[kind.base]
        if int(flat.min()) < low or int(flat.max()) > high:
            raise ValueError(f"expected {kind}, got values outside {low}…{high}")
    with np.errstate(over="ignore"):
        return flat.astype(dtype)
