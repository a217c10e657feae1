"""``launch_testing_ros.tools.output``."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from launch_testing.legacy.output import get_rmw_output_filter
from launch_testing.tools import output


def basic_output_filter(
    filtered_prefixes: Iterable[str] | None = None,
    filtered_patterns: Iterable[str] | None = None,
    filtered_rmw_implementation: str | None = None,
) -> Callable[[str], str]:
    """Return a function that removes lines from a text.

    Args:
        filtered_prefixes: How they begin; None for lines with a process's number or status.
        filtered_patterns: Patterns of their beginnings; None for none.
        filtered_rmw_implementation: A ROS middleware whose own lines are left out, too.
    """
    prefixes = (
        output.get_default_filtered_prefixes() if filtered_prefixes is None else filtered_prefixes
    )
    patterns = (
        output.get_default_filtered_patterns() if filtered_patterns is None else filtered_patterns
    )
    return output.basic_output_filter(
        [*prefixes, *_of(filtered_rmw_implementation, "prefixes")],
        [*patterns, *_of(filtered_rmw_implementation, "patterns")],
    )


def _of(rmw_implementation: str | None, kind: str) -> list[str]:
    if not rmw_implementation:
        return []
    return [line.decode() for line in get_rmw_output_filter(rmw_implementation, kind)]
