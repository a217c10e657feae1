"""One field of a message by its path: ``pose.position``, ``name[0]``, ``ranges[:10]``.

An element may also be written with a dot before it, ``name.[0]``, as newer ROS tools have it.
"""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.errors import InvalidMessageError, UsageError

if TYPE_CHECKING:
    import re

_STEP = r"\.?(?P<name>[A-Za-z_]\w*)|\.?\[(?:(?P<index>-?\d+)|(?P<first>-?\d*):(?P<end>-?\d*))\]"


# Any: a message's class is made from its definition, and the path decides on the value.
def field_reader(path: str) -> Callable[[Any], Any]:
    """Return a function that reads a field by its path.

    Args:
        path: Such as ``pose.position``, ``transforms[0].header`` or ``ranges[:10]``.

    Raises:
        TeleopctlError: The path is malformed. The returned function raises it as well, when a
            message has no such field.
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
