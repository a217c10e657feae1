"""Arrays and sequences of numbers, bools and bytes, as messages store them in slots.

A slot stores a block in the type in which it was assigned; a received block is a memoryview of the
received bytes. When programs read the field, they get the type of ROS 2's messages: ``array.array``
for a sequence of numbers, a numpy array for a fixed array of numbers, a list for bools and bytes.

The import of numpy takes longer than most commands run, so numpy is imported only for values that
are numpy arrays.
"""

from __future__ import annotations

import sys

from teleopctl.base.typed import TYPE_CHECKING, Any, Iterable, TypeAlias, TypeGuard

if TYPE_CHECKING:
    import array

    import numpy as np
    import numpy.typing as npt

    NumberArray: TypeAlias = npt.NDArray[Any]

TYPE_CODES: dict[str, Any] = {
    "int8": "b",
    "uint8": "B",
    "char": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""Type codes of ``array``, ``struct`` and memoryview for types that are stored as numbers."""

BLOCK_CODES: dict[str, Any] = TYPE_CODES | {"bool": "?", "byte": "c"}
"""`TYPE_CODES`, and the codes of the types whose sequences programs read as lists."""

ITEM_SIZES: dict[str, int] = {
    code: memoryview(bytes(8)).cast(code).itemsize for code in BLOCK_CODES.values()
}

_EMPTY = {code: memoryview(b"").cast(code) for code in BLOCK_CODES.values()}


def empty(base: str) -> memoryview:
    """Return an empty memoryview for sequences of a base type, ``float64`` for example."""
    block: memoryview = _EMPTY[BLOCK_CODES[base]]
    return block


def as_block(base: str, data: bytes | bytearray | memoryview) -> memoryview:
    """Return bytes as a memoryview of a base type's values, without copying."""
    view = memoryview(data)
    code = BLOCK_CODES[base]
    return view if code == "B" else view.cast(code)


# Any, here and below: a block has one of several types, without a common type for type checkers.


def byteswapped(base: str, data: memoryview) -> Any:
    """Return bytes of the other byte order as native values: array, or view of one-byte types."""
    code = BLOCK_CODES[base]
    if ITEM_SIZES[code] == 1:
        return as_block(base, data)
    block = new_array(code)
    block.frombytes(data)
    block.byteswap()
    return block


def new_array(code: str, values: Iterable[Any] = ()) -> array.array[Any]:
    """Return an ``array.array``, whose module takes a millisecond to import."""
    from array import array

    return array(code, values)


def is_array(value: object) -> TypeGuard[array.array[Any]]:
    """Return whether a value is an ``array.array``, without importing its module."""
    return isinstance(value, getattr(sys.modules.get("array"), "array", ()))


def to_array(code: str, block: Any) -> array.array[Any]:
    """Return a copy of a memoryview or numpy array of numbers as an ``array.array``."""
    copy = new_array(code)
    copy.frombytes(memoryview(block).cast("B"))
    return copy


def to_numpy(base: str, block: Any) -> NumberArray:
    """Return a stored array or sequence as a numpy array: itself, a view, or a copy of a list."""
    import numpy as np

    if isinstance(block, np.ndarray):
        return block
    dtype = numpy_type(base)
    if not isinstance(block, list):
        return np.frombuffer(block, dtype)
    if base == "byte":
        return np.frombuffer(b"".join(block), dtype)
    return np.array(block, dtype)


def to_own_numpy(base: str, block: Any) -> NumberArray:
    """Return a stored array as a writable numpy array; views and read-only arrays are copied."""
    view = to_numpy(base, block)
    return view if view.flags.writeable and not isinstance(block, memoryview) else view.copy()


def numpy_type(base: str) -> np.dtype[Any]:
    """Return the numpy dtype for a base type's values."""
    import numpy as np

    return np.dtype({"byte": "B"}.get(base) or BLOCK_CODES[base])


def is_numpy_array(value: object) -> bool:
    """Return whether a value is a numpy array, without importing numpy."""
    return isinstance(value, getattr(sys.modules.get("numpy"), "ndarray", ()))


def is_numpy_bool(value: object) -> bool:
    """Return whether a value is a numpy bool, without importing numpy."""
    return isinstance(value, getattr(sys.modules.get("numpy"), "bool_", ()))


def equal(one: Any, other: Any) -> bool:
    """Return whether two stored field values are equal, even if only one of them is a list."""
    if type(one) is type(other) and (isinstance(one, _PLAIN) or is_array(one)):
        return bool(one == other)
    if isinstance(one, list) or isinstance(other, list):
        return bool(_listed(one) == _listed(other))
    if not (_is_block(one) and _is_block(other)):
        return bool(one == other)
    first, second = memoryview(one), memoryview(other)
    if first.nbytes != second.nbytes:
        return False
    if first.format in ("f", "d"):  # bytes do not decide: 0.0 equals -0.0, and NaN no value
        return bool(first == second)
    return first.tobytes() == second.tobytes()


_PLAIN = (str, int, float, bytes)


def _listed(value: Any) -> Any:
    return value.tolist() if _is_block(value) else value


def _is_block(value: object) -> bool:
    return isinstance(value, memoryview) or is_array(value) or is_numpy_array(value)
