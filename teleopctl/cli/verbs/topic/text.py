"""Messages and fields as YAML, CSV or JSON, and the options for the text."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli.options import check_not_negative
from teleopctl.cli.verb import Option, OptionSet
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.cli.console import Json


_INFINITY = float("inf")
_EVENTS = ("REQUEST_SENT", "REQUEST_RECEIVED", "RESPONSE_SENT", "RESPONSE_RECEIVED")


class TextStyle:
    """Format of messages as YAML or CSV, with the settings of ``topic echo``.

    Args:
        truncate: Length of the longest list or text that is written in full; None for no limit.
        flow: Whether lists are written on one line.
        no_arr: Whether only type and length of lists are written.
        no_str: Whether only the length of texts is written.
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
        """Return a service event as YAML, with its event type by name."""
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


# Any: a message of any type, or a part of one.
def json_value(value: Any) -> "Json":
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
    if isinstance(value, float) and not -_INFINITY < value < _INFINITY:
        return "NaN" if value != value else "Infinity" if value > 0 else "-Infinity"
    return value  # type: ignore[no-any-return] # other types of fields are types of JSON too


def is_message(value: object) -> bool:
    """Return whether a value is a message."""
    return hasattr(value, "get_fields_and_field_types")


def is_list(value: object) -> bool:
    """Return whether a value is an array or a sequence."""
    return isinstance(value, list | tuple) or type(value).__name__ in ("array", "ndarray")


class TextOptions(OptionSet):
    """Options for how messages are printed as text."""

    csv: Annotated[bool, Option("--csv", help="Print all values on one line.")] = False
    flow_style: Annotated[
        bool, Option("--flow-style", help="Print lists and mappings on one line.")
    ] = False
    full_length: Annotated[
        bool, Option("-f", "--full-length", help="Print long lists and texts in full.")
    ] = False
    truncate_length: Annotated[
        int, Option("-l", "--truncate-length", help="Longest list or text printed in full.")
    ] = 128
    no_arr: Annotated[bool, Option("--no-arr", help="Print no elements of lists.")] = False
    no_str: Annotated[bool, Option("--no-str", help="Print no texts.")] = False

    def check(self) -> None:
        """Raise a UsageError if the length is negative."""
        check_not_negative(truncate_length=self.truncate_length)

    def style(self, *, as_json: bool) -> TextStyle:
        """Return the text style that the options select.

        Args:
            as_json: Whether the verb prints JSON instead.

        Raises:
            UsageError: Both JSON and CSV are selected.
        """
        if as_json and self.csv:
            raise UsageError("--csv and --json contradict each other; give one of them")
        return TextStyle(
            truncate=None if self.full_length else self.truncate_length,
            flow=self.flow_style,
            no_arr=self.no_arr,
            no_str=self.no_str,
        )
