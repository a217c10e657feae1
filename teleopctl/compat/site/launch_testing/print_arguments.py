"""``launch_testing.print_arguments``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from launch import LaunchDescription


def print_arguments_of_launch_description(*, launch_description: LaunchDescription) -> None:
    """Print the launch arguments of a description, for ``launch_test --show-args``."""
    arguments = launch_description.get_launch_arguments()
    lines = ["Arguments (pass arguments as '<name>:=<value>'):"]
    for argument in arguments:
        # launch sets this attribute on arguments under a condition.
        star = "*" if argument._conditionally_included else ""  # noqa: SLF001
        lines += ["", f"    '{argument.name}':{star}", f"        {argument.description}"]
        if argument.default_value is not None:
            default = " + ".join(token.describe() for token in argument.default_value)
            lines.append(f"        (default: {default})")
    if not arguments:
        lines += ["", "  No arguments."]
    elif any(argument._conditionally_included for argument in arguments):  # noqa: SLF001
        lines += ["", "* argument(s) which are only used if specific conditions occur"]
    print("\n".join(lines))  # noqa: T201 -- what the command is for
