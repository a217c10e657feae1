"""What a person picks out of messages: ``--filter``."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import Any
from teleopctl.errors import InvalidMessageError, UsageError


# Any: a message's class is made from its definition.
def filter_predicate(expression: str) -> Callable[[Any], bool]:
    """Return a function that decides by an expression whether a message is printed.

    Args:
        expression: Python, with the message as ``m``: ``m.data > 3``.

    Raises:
        TeleopctlError: The expression is not Python. The returned function raises it as well,
            when the expression fails on a message.
    """
    try:
        code = compile(expression, "--filter", "eval")
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"Invalid filter expression '{expression}': {error}") from error

    def wanted(message: Any) -> bool:
        try:
            # The expression comes from the person who runs the command, with their own rights.
            return bool(eval(code, {"m": message}))  # noqa: S307
        except Exception as error:
            raise InvalidMessageError(
                f"Filter expression '{expression}' failed: {error}"
            ) from error

    return wanted
