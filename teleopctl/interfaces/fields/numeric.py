"""The numbers of a message by their paths, for whoever draws or watches one of them."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.base.typed import Any, NamedTuple
from teleopctl.interfaces.definition import Shape

MOST_FIELDS = 500
MOST_ELEMENTS = 64

# Where messages name the elements of the arrays beside these lists, or below them.
_NAMES = ("name", "names", "joint_names", "interface_names")
# What tells one message of an array from the next.
_OWN_NAMES = ("child_frame_id", "name", "joint_name")


class NumericField(NamedTuple):
    """A numeric field of a message, or an array of numbers.

    Attributes:
        path: As `field_reader` takes it.
        label: What the message calls it, such as the joint's name; empty if it does not.
        length: How many numbers it is; None is a single one.
    """

    path: str
    label: str = ""
    length: int | None = None


# Any: a message, whose class is made from its definition.
def numeric_fields(message: Any) -> list[NumericField]:
    """Return the numeric and boolean fields of a message, those of its header last.

    An array is listed as a whole and by its elements, `MOST_ELEMENTS` of them at most; after
    `MOST_FIELDS` the list ends.

    Args:
        message: The message; a new one of its class shows all but what is in sequences.
    """
    found: list[NumericField] = []
    _collect(message, "", "", (), found)
    return [field for field in found if not _of_header(field)] + list(filter(_of_header, found))


def _of_header(field: NumericField) -> bool:
    return field.path.startswith("header.")


def _collect(
    message: Any,
    above: str,
    label: str,
    names: tuple[list[str], ...],
    found: list[NumericField],
) -> None:
    names = (*_lists_of_names(message), *names)
    for field in message.__definition__.fields:
        if len(found) >= MOST_FIELDS:
            return
        path = f"{above}.{field.attribute}" if above else field.attribute
        kind = field.type
        is_number = kind.is_numeric or kind.base == "bool"
        if not kind.is_nested and not is_number:
            continue
        value = getattr(message, field.attribute)
        if kind.shape is Shape.SINGLE:
            if is_number:
                found.append(NumericField(path, label))
            else:
                _collect(value, path, label, names, found)
            continue
        length = len(value)
        if is_number and length:
            found.append(NumericField(path, label, length))
        for index in range(min(length, MOST_ELEMENTS)):
            named = _name_of(index, length, names) or label
            if is_number:
                found.append(NumericField(f"{path}[{index}]", named))
            else:
                own = _own_name(value[index]) or named
                _collect(value[index], f"{path}[{index}]", own, names, found)


def _lists_of_names(message: Any) -> list[list[str]]:
    candidates = (getattr(message, name, None) for name in _NAMES)
    return [one for one in candidates if isinstance(one, list) and _are_texts(one)]


def _are_texts(values: Sequence[object]) -> bool:
    return bool(values) and isinstance(values[0], str)


def _name_of(index: int, length: int, names: tuple[list[str], ...]) -> str:
    return next((some[index] for some in names if len(some) == length), "")


def _own_name(message: Any) -> str:
    candidates = (getattr(message, name, None) for name in _OWN_NAMES)
    return next((one for one in candidates if isinstance(one, str) and one), "")
