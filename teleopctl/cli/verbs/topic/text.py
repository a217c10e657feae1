"""A message, or one field of it, as YAML, CSV or JSON."""

from __future__ import annotations

import array
import math

from teleopctl.base.typed import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from teleopctl.cli.console import Json


_EVENTS = ("REQUEST_SENT", "REQUEST_RECEIVED", "RESPONSE_SENT", "RESPONSE_RECEIVED")


class TextStyle:
    """Text style of ``topic echo``; the names are those of its options.

    Args:
        truncate: Longest list or text to write in full, None for any.
        flow: Write lists on one line.
        no_arr: Write only type and length of lists.
        no_str: Write only the length of texts.
    """

    __slots__ = ("flow", "no_arr", "no_str", "truncate")

    def __init__(
        self,
        *,
        truncate: int | None = 128,
        flow: bool = False,
        no_arr: bool = False,
        no_str: bool = False,
    ) -> None:
        self.truncate = truncate
        self.flow = flow
        self.no_arr = no_arr
        self.no_str = no_str

    # Any, here and below: a message of any type, or a part of one.
    def yaml(self, value: Any) -> str:
        """Return a message as YAML, or another value as Python prints it, with a line break."""
        if not is_message(value):
            return f"{value}\n"
        from teleopctl.interfaces import message_to_yaml

        return message_to_yaml(
            value,
            truncate=self.truncate,
            flow=self.flow,
            no_arr=self.no_arr,
            no_str=self.no_str,
        )

    def event(self, message: Any) -> str:
        """Return a service event as YAML, its kind by name; see `yaml`."""
        head = "  event_type: "
        lines = self.yaml(message).split("\n")
        return "\n".join(
            f"{head}{_EVENTS[int(line[-1])]}" if line[:-1] == head and line[-1] in "0123" else line
            for line in lines
        )

    def csv(self, value: Any) -> str:
        """Return all values of a message in order, with commas between them."""
        if is_message(value):
            from teleopctl.interfaces import message_to_csv

            return message_to_csv(
                value, truncate=self.truncate, no_arr=self.no_arr, no_str=self.no_str
            )
        if is_list(value):
            return ",".join(self.csv(element) for element in value)
        return str(value)


# Any: as above.
def json_value(value: Any) -> Json:
    """Return a message or a field as a JSON value."""
    if is_message(value):
        from teleopctl.interfaces import message_to_dict

        document: Json = message_to_dict(value)
        return document
    if is_list(value):
        elements = value.tolist() if hasattr(value, "tolist") else value
        return [json_value(element) for element in elements]
    if isinstance(value, bytes):
        return list(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value  # type: ignore[no-any-return] # what is left of a field's types is JSON's own


def is_message(value: object) -> bool:
    """Return whether a value is a message."""
    return hasattr(value, "get_fields_and_field_types")


def is_list(value: object) -> bool:
    """Return whether a value is an array or a sequence."""
    return isinstance(value, list | tuple | array.array) or type(value).__name__ == "ndarray"
