"""Properties of displays, read from and written to the mappings of an ``.rviz`` file.

The file's mapping is kept complete: unknown properties are ignored, and written back when the view
is saved.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Color = tuple[int, int, int]
"""Red, green, blue, each from 0 to 255."""

Value = bool | int | float | str | Color


@dataclass(frozen=True, slots=True)
class Property:
    """Definition of a display's property: its name in ``.rviz`` files, default and range.

    Attributes:
        name: Name in an ``.rviz`` file; the levels of a nested property are joined by ``/``.
        default: Value if the file has none. A tuple is a colour.
        choices: Allowed values of a text; empty for any.
        low: Smallest allowed number.
        high: Largest allowed number.
        hint: Tooltip.
        is_frame: Whether the value is a tf frame, to be chosen from the known ones.
    """

    name: str
    default: Value
    choices: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None
    hint: str = ""
    is_frame: bool = False


class Properties:
    """Values of one display's properties, stored in its mapping of an ``.rviz`` file.

    Args:
        known: Definitions of the properties.
        given: The display's mapping, changed in place when a property is set.
    """

    # Any: YAML values.
    def __init__(self, known: tuple[Property, ...], given: dict[str, Any] | None = None) -> None:
        self.known = {one.name: one for one in known}
        self.given: dict[str, Any] = {} if given is None else given

    def __getitem__(self, name: str) -> Value:
        return read_property(self.known[name], self.given)

    def number(self, name: str) -> float:
        """Return the value of the named property, a number, as a float."""
        value = self[name]
        assert isinstance(value, int | float)
        return float(value)

    def flag(self, name: str) -> bool:
        """Return the value of the named property as a bool."""
        return bool(self[name])

    def text(self, name: str) -> str:
        """Return the value of the named property as a text."""
        return str(self[name])

    def color(self, name: str) -> Color:
        """Return the value of the named property, a colour: red, green, blue from 0 to 255."""
        value = self[name]
        assert isinstance(value, tuple)
        return value

    def set(self, name: str, value: Value) -> None:
        """Write a property's value into the display's mapping of the ``.rviz`` file."""
        *groups, last = name.split("/")
        place = self.given
        for group in groups:
            inner = place.get(group)
            if not isinstance(inner, dict):
                # a property with nested properties: its own value moves to "Value"
                inner = {} if inner is None else {"Value": inner}
                place[group] = inner
            place = inner
        written: Any = "; ".join(map(str, value)) if isinstance(value, tuple) else value
        if isinstance(place.get(last), dict):
            place[last]["Value"] = written
        else:
            place[last] = written


# Any: YAML values.
def read_property(definition: Property, mapping: Mapping[str, Any]) -> Value:
    """Return a property's value in an ``.rviz`` mapping, limited to its range; else the default."""
    value: Any = mapping
    for part in definition.name.split("/"):
        value = value.get(part) if isinstance(value, Mapping) else None
    if isinstance(value, Mapping):
        value = value.get("Value")
    default = definition.default
    if value is None:
        return default
    if isinstance(default, tuple):
        return _color(value, default)
    if isinstance(default, bool):
        return value if isinstance(value, bool) else default
    if isinstance(default, str):
        text = str(value)
        return text if not definition.choices or text in definition.choices else default
    if isinstance(value, bool) or not isinstance(value, int | float):
        return default
    try:
        if not math.isfinite(value):
            return default
    except OverflowError:  # an integer too large for a float
        return default
    number = max(value, definition.low) if definition.low is not None else value
    number = min(number, definition.high) if definition.high is not None else number
    return type(default)(number)


def _color(value: object, default: Color) -> Color:
    parts = str(value).split(";")
    try:
        red, green, blue = (min(max(int(float(part)), 0), 255) for part in parts)
    except (ValueError, OverflowError):
        return default
    return red, green, blue
