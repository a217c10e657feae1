"""``launch_testing.parse_arguments``."""

from __future__ import annotations

from collections.abc import Iterable


def parse_launch_arguments(launch_arguments: Iterable[str]) -> list[tuple[str, str]]:
    """Return name and value of each ``name:=value``; the last one of a name counts.

    Raises:
        RuntimeError: A word is not of that form.
    """
    values: dict[str, str] = {}
    for word in launch_arguments:
        name, given, value = word.partition(":=")
        if not name or not given or not value:
            raise RuntimeError(
                f"malformed launch argument '{word}', expected format '<name>:=<value>'"
            )
        values[name] = value
    return list(values.items())
