"""The flags by which verbs write messages: how long lists and texts are, and on how many lines."""

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.topic.text import TextStyle
from teleopctl.cli.words.numbers import check_not_negative

TRUNCATE = 128

Csv = Annotated[bool, Option("--csv", help="Print all values on one line.")]
FlowStyle = Annotated[bool, Option("--flow-style", help="Print lists and mappings on one line.")]
FullLength = Annotated[
    bool, Option("-f", "--full-length", help="Print long lists and texts in full.")
]
TruncateLength = Annotated[
    int, Option("-l", "--truncate-length", help="Longest list or text that is printed in full.")
]
NoArr = Annotated[bool, Option("--no-arr", help="Print no elements of lists.")]
NoStr = Annotated[bool, Option("--no-str", help="Print no texts.")]


def style_of(
    *, flow_style: bool, full_length: bool, truncate_length: int, no_arr: bool, no_str: bool
) -> TextStyle:
    """Return the text style for the given options.

    Raises:
        UsageError: The length is negative.
    """
    check_not_negative(truncate_length=truncate_length)
    return TextStyle(
        truncate=None if full_length else truncate_length,
        flow=flow_style,
        no_arr=no_arr,
        no_str=no_str,
    )
