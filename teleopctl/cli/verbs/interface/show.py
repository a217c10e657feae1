"""``teleopctl interface show|proto``: what a type consists of."""

import sys
from collections.abc import Iterator

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError, UnsupportedError, UsageError
from teleopctl.interfaces import definition_lines, known_types, normalize

_Type = Annotated[
    str,
    Argument(
        metavar="TYPE",
        help="Full name, such as std_msgs/msg/String; - reads it from a pipe.",
        complete="interface_types",
    ),
]


def show(
    type_name: _Type,
    all_comments: Annotated[
        bool, Option("--all-comments", help="With the comments of the messages it holds, too.")
    ] = False,
    no_comments: Annotated[
        bool, Option("--no-comments", help="Without comments and empty lines.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the definition of a type, with those of the messages that it holds.

    The definitions that come with teleopctl have no comments, those of your packages have theirs.
    """
    if all_comments and no_comments:
        raise UsageError("--all-comments and --no-comments contradict each other")
    name = _known(type_name)
    lines = []
    for line in _shown(name, not no_comments, nested_comments=all_comments):
        lines.append(line)
        # The budget is asked for long ones only: a short command loads few modules.
        if len(lines) % 1000:
            continue
        from teleopctl.base.budget import MOST_ELEMENTS

        if len(lines) > MOST_ELEMENTS:
            raise UnsupportedError(f"{name} has more than {MOST_ELEMENTS:,} lines")
    if as_json:
        console.out_json({"type": name, "definition": "".join(f"{line}\n" for line in lines)})
    else:
        console.out_lines(lines)


def _shown(name: str, comments: bool, *, nested_comments: bool, depth: int = 0) -> Iterator[str]:
    for line in definition_lines(name):
        text = line.text if comments else line.code
        if text or comments:
            yield "\t" * depth * bool(text) + text
        if line.message is not None:
            yield from _shown(
                line.message, nested_comments, nested_comments=nested_comments, depth=depth + 1
            )


def proto(
    type_name: _Type,
    no_quotes: Annotated[bool, Option("--no-quotes", help="Without the quotes around it.")] = False,
    as_json: AsJson = False,
) -> None:
    """Print the values of a message, a request or a goal as YAML, for pub, call and send_goal."""
    from teleopctl.interfaces import get_class, message_to_dict, message_to_yaml

    made = get_class(_known(type_name))
    made = getattr(made, "Goal", None) or getattr(made, "Request", None) or made
    if as_json:
        console.out_json(message_to_dict(made()))
        return
    # With a line feed at its end, as in ROS 2.
    text = message_to_yaml(made())
    console.out_text(text if no_quotes else f'"{text}"')


def _known(written: str) -> str:
    """Return the full name of a type that there is.

    Raises:
        NotFoundError: There is none.
        UsageError: A pipe was to give it, and there is none or it gives nothing.
    """
    if written == "-":
        if sys.stdin.isatty():
            raise UsageError("expected stdin pipe")
        written = sys.stdin.readline().strip()
    if not written:
        raise UsageError("the passed value is empty")
    if written.count("/") != 2:
        raise NotFoundError(f"Invalid name '{written}'. Expected three parts separated by '/'")
    types = known_types()
    package = written.split("/", 1)[0]
    if types.find(name := normalize(written)) is not None:
        return name
    if not types.package_names(package):
        raise NotFoundError(f"Unknown package '{package}'")
    raise NotFoundError(f"Could not find the interface '{written}'")
