"""Access to fields of a message by path: ``pose.position``, ``name[0]``, ``ranges[:10]``."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, NamedTuple, Sequence
from teleopctl.errors import InvalidMessageError, UsageError
from teleopctl.interfaces.definition import Shape

if TYPE_CHECKING:
    import re


_STEP = r"\.?(?P<name>[A-Za-z_]\w*)|\.?\[(?:(?P<index>-?\d+)|(?P<first>-?\d*):(?P<end>-?\d*))\]"


# Any: message classes are made from definitions, and the path determines the value.
def field_reader(path: str) -> Callable[[Any], Any]:
    """Return a function that takes a message and returns the value at a field path.

    Args:
        path: Field path, such as ``pose.position``, ``transforms[0].header`` or ``ranges[:10]``.

    Raises:
        TeleopctlError: The path is malformed. The returned function also raises TeleopctlError,
            when a message has no such field.
    """
    import re

    one_step = re.compile(_STEP)
    steps: list[str | int | slice] = []
    position = 0
    while position < len(path):
        match = one_step.match(path, position)
        if match is None or (path[position] == "." and not steps):
            raise UsageError(
                f"Invalid field '{path}'",
                hint="Write it as in Python, such as pose.position or transforms[0].header.",
            )
        position = match.end()
        steps.append(_step(match))
    if not steps:
        raise UsageError(f"Invalid field value '{path}'")

    def read(message: Any) -> Any:
        value = message
        for step in steps:
            try:
                value = getattr(value, step) if isinstance(step, str) else value[step]
            except (AttributeError, IndexError, TypeError, KeyError) as error:
                raise InvalidMessageError(
                    f"Invalid field '{path}': {_reason(value, step)}", hint=_known_fields(value)
                ) from error
        return value

    return read


def _step(match: re.Match[str]) -> str | int | slice:
    if match["name"]:
        return match["name"]
    if match["index"]:
        return int(match["index"])
    first, end = (int(match[bound]) if match[bound] else None for bound in ("first", "end"))
    return slice(first, end)


def _reason(value: object, step: str | int | slice) -> str:
    kind = getattr(value, "TYPE_NAME", type(value).__name__)
    if isinstance(step, str):
        return f"{kind} has no field '{step}'"
    return f"there is no element {step}" if hasattr(value, "__len__") else f"{kind} is no list"


def _known_fields(value: object) -> str | None:
    fields = getattr(value, "get_fields_and_field_types", None)
    return f"its fields are {', '.join(fields())}" if fields else None


MOST_FIELDS = 500
MOST_ELEMENTS = 64

# Fields with the names of the elements of arrays in the same message, or in nested messages.
_NAMES = ("name", "names", "joint_names", "interface_names")
# Fields that identify a message in an array.
_OWN_NAMES = ("child_frame_id", "name", "joint_name")


class NumericField(NamedTuple):
    """Description of a number or array of numbers in a message: field path, label, length.

    Attributes:
        path: Field path for `field_reader`.
        label: Name that the message has for the number, such as the joint's name; empty if none.
        length: Length of the array; None for a single number.
    """

    path: str
    label: str = ""
    length: int | None = None


# Any: a message, whose class is made from its definition at run time.
def numeric_fields(message: Any) -> list[NumericField]:
    """Return `NumericField`s of all numbers and bools in a message, also nested; header last.

    An array is listed as a whole and by its first `MOST_ELEMENTS` elements; the list ends after
    `MOST_FIELDS` fields.

    Args:
        message: Message to list; a message with default values has no elements of sequences.
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
