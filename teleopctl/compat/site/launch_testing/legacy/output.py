"""``launch_testing.legacy.output``: tests of a process's output for `LaunchTestService`."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

_Expected = TypeVar("_Expected")

# Initial state, function that adds output, function that searches, and expected items.
OutputTest = tuple[
    bytes, Callable[[bytes, bytes], bytes], Callable[[bytes, _Expected], bool], list[_Expected]
]


def get_default_filtered_prefixes() -> list[bytes]:
    """Return the prefixes of lines that launch itself writes."""
    return [b"pid", b"rc"]


def get_default_filtered_patterns() -> list[bytes]:
    """Return the patterns of lines that launch itself writes: none."""
    return []


def get_rmw_output_filter(rmw_implementation: str, filter_type: str) -> list[bytes]:
    """Return prefixes or patterns of lines that a ROS middleware writes.

    Args:
        rmw_implementation: Its name, such as ``rmw_zenoh_cpp``.
        filter_type: ``prefixes`` or ``patterns``.

    Raises:
        TypeError: The argument is neither.
    """
    from ament_index_python import get_resource, has_resource

    if filter_type not in ("prefixes", "patterns"):
        raise TypeError(
            f'Unsupported filter_type "{filter_type}". Supported types: prefixes, patterns'
        )
    kind = f"rmw_output_{filter_type}"
    try:
        if not has_resource(kind, rmw_implementation):
            return []
    except OSError:
        return []  # without a sourced ROS there is no middleware with lines to filter
    return [line.encode() for line in get_resource(kind, rmw_implementation)[0].splitlines()]


def create_output_lines_filter(
    filtered_prefixes: Iterable[bytes] | None = None,
    filtered_patterns: Iterable[bytes] | None = None,
    filtered_rmw_implementation: str | None = None,
) -> Callable[[bytes], bytes]:
    """Return a function that removes lines from output.

    Args:
        filtered_prefixes: How they begin; None for `get_default_filtered_prefixes`.
        filtered_patterns: Patterns of them; None for `get_default_filtered_patterns`.
        filtered_rmw_implementation: A ROS middleware whose own lines are left out, too.
    """
    prefixes = list(filtered_prefixes or get_default_filtered_prefixes())
    patterns = list(filtered_patterns or get_default_filtered_patterns())
    if filtered_rmw_implementation:
        prefixes += get_rmw_output_filter(filtered_rmw_implementation, "prefixes")
        patterns += get_rmw_output_filter(filtered_rmw_implementation, "patterns")
    compiled = [re.compile(pattern) for pattern in patterns]
    line_end = os.linesep.encode()

    def keep(output: bytes) -> bytes:
        lines = [
            line
            for line in output.splitlines()
            if not line.startswith(tuple(prefixes))
            and not any(pattern.match(line) for pattern in compiled)
        ]
        if output.endswith(line_end):
            lines.append(line_end)
        return line_end.join(lines)

    return keep


def create_output_lines_test(expected_lines: Iterable[bytes]) -> OutputTest[bytes]:
    """Return a test that texts appear in lines of the output, in any order."""

    def is_there(written: bytes, text: bytes) -> bool:
        return any(text in line for line in written.splitlines())

    return b"", bytes.__add__, is_there, list(expected_lines)


def create_output_regex_test(
    expected_patterns: Iterable[re.Pattern[bytes]],
) -> OutputTest[re.Pattern[bytes]]:
    """Return a test that patterns match the output, in any order."""

    def is_there(written: bytes, pattern: re.Pattern[bytes]) -> bool:
        return pattern.search(written) is not None

    return b"", bytes.__add__, is_there, list(expected_patterns)


def create_output_test_from_file(
    output_file: str,
) -> OutputTest[bytes] | OutputTest[re.Pattern[bytes]]:
    """Return the output test that a file describes.

    Args:
        output_file: A file without its ending: ``.txt`` for lines, ``.regex`` for patterns.

    Raises:
        RuntimeError: There is neither.
    """
    lines, patterns = Path(f"{output_file}.txt"), Path(f"{output_file}.regex")
    if lines.is_file():
        return create_output_lines_test(lines.read_bytes().splitlines())
    if patterns.is_file():
        return create_output_regex_test(map(re.compile, patterns.read_bytes().splitlines()))
    raise RuntimeError(f"could not find output check file: {output_file}")
