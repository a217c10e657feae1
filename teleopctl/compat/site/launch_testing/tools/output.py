"""``launch_testing.tools.output``."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from .._text import build_line_match, build_text_match, without_escape_sequences


def get_default_filtered_prefixes() -> list[str]:
    """Return the prefixes of lines that launch itself writes."""
    return ["pid", "rc"]


def get_default_filtered_patterns() -> list[str]:
    """Return the patterns of lines that launch itself writes: none."""
    return []


def basic_output_filter(
    filtered_prefixes: Iterable[str] | None = None,
    filtered_patterns: Iterable[str] | None = None,
) -> Callable[[str], str]:
    """Return a function that removes lines from a text.

    Args:
        filtered_prefixes: How they begin; None for `get_default_filtered_prefixes`.
        filtered_patterns: Patterns of their beginnings; None for `get_default_filtered_patterns`.
    """
    if filtered_prefixes is None:
        filtered_prefixes = get_default_filtered_prefixes()
    if filtered_patterns is None:
        filtered_patterns = get_default_filtered_patterns()
    prefixes = tuple(filtered_prefixes)
    patterns = [re.compile(pattern) for pattern in filtered_patterns]

    def keep(output: str) -> str:
        return "".join(
            line
            for line in output.splitlines(keepends=True)
            if not line.startswith(prefixes)
            and not any(pattern.match(line) for pattern in patterns)
        )

    return keep


# Any: what `expect_output` takes.
def expected_output_from_file(path: str, encoding: str | None = None) -> list[Any]:
    """Read the expected lines from a file.

    Args:
        path: A file without its ending: ``.txt`` for lines, ``.regex`` for patterns of lines.
        encoding: How the file is encoded; None for what the system has.

    Raises:
        RuntimeError: There is neither.
    """
    # Not with_suffix: a dot in the name does not begin a suffix here.
    lines, patterns = Path(f"{path}.txt"), Path(f"{path}.regex")
    if lines.is_file():
        return lines.read_text(encoding=encoding).splitlines()
    if patterns.is_file():
        return list(map(re.compile, patterns.read_text(encoding=encoding).splitlines()))
    raise RuntimeError(f"could not find output check file: {path}")


# Any: texts and patterns, as `build_text_match` and `build_line_match` take them.
def expect_output(
    text: str | None = None,
    *,
    lines: Sequence[str] | None = None,
    expected_text: Any = None,
    expected_lines: Any = None,
    strip_ansi_escape_sequences: bool = True,
    strict: bool = False,
) -> bool:
    """Return whether a text, or lines, match the expected ones.

    Args:
        text: The text; or `lines`.
        lines: The lines; or `text`.
        expected_text: What `build_text_match` takes; or `expected_lines`.
        expected_lines: What `build_line_match` takes; or `expected_text`.
        strip_ansi_escape_sequences: Whether colours do not count.
        strict: Whether nothing else may be there.

    Raises:
        ValueError: Both of two are given, or neither.
    """
    if (text is None) == (lines is None):
        raise ValueError("Either lines or text, but not both, must be specified")
    if (expected_text is None) == (expected_lines is None):
        raise ValueError("Either expected lines or text, but not both, must be specified")
    clean = without_escape_sequences if strip_ansi_escape_sequences else str
    if expected_text is not None:
        whole = text if text is not None else "\n".join(lines or ())
        return build_text_match(expected_text, strict=strict)(clean(whole)) is not None
    listed = lines if lines is not None else (text or "").splitlines()
    return build_line_match(expected_lines, strict=strict)(list(map(clean, listed))) is not None
