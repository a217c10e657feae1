"""Matching of expected texts and lines in output."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

# Start and end of a match.
Span = tuple[int, int]

_Output = TypeVar("_Output")
# Finds a match in output, from an index on.
_Match = Callable[[_Output, int], Span | None]

_ESCAPE_SEQUENCE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|[@-Z\\-_])")


def without_escape_sequences(text: str) -> str:
    """Return a text without the escape sequences of a terminal."""
    return _ESCAPE_SEQUENCE.sub("", text)


def normalize_lineseps(lines: str) -> str:
    r"""Return a text with the line ends of any platform replaced by ``\n``."""
    return lines.replace(os.linesep, "\n").replace("\r\n", "\n")


# Any: texts, patterns, or lists of them.
def build_text_match(expected_text: Any, *, strict: bool = False) -> Callable[..., Span | None]:
    """Return a function that finds an expected text in a text, from an index on.

    Args:
        expected_text: A text, a pattern, or several of them in their order.
        strict: Whether it has to stand at the index; a text has to reach to the end, too.

    Raises:
        ValueError: Nothing of these kinds is expected.
    """
    if isinstance(expected_text, str):
        find = _text_in_text(expected_text, strict)
    elif isinstance(expected_text, re.Pattern):
        look = expected_text.match if strict else expected_text.search

        def find(text: str, start: int) -> Span | None:
            found = look(text, start)
            return None if found is None else found.span()

    elif isinstance(expected_text, Iterable):
        find = _one_after_another([build_text_match(each) for each in expected_text], strict)
    else:
        raise ValueError("Unknown format for expected text")
    return lambda actual_text, start=0: find(normalize_lineseps(actual_text), start)


def _text_in_text(expected: str, strict: bool) -> _Match[str]:
    def find(text: str, start: int) -> Span | None:
        if strict:
            return (start, len(text)) if text[start:] == expected else None
        found = text.find(expected, start)
        return (found, found + len(expected)) if found >= 0 else None

    return find


# Any: texts, patterns, or lists of them.
def build_line_match(expected_lines: Any, *, strict: bool = False) -> Callable[..., Span | None]:
    """Return a function that finds expected lines in a list of lines, from an index on.

    Args:
        expected_lines: A part of a line, a pattern of its beginning, or several in their order.
        strict: Whether all lines have to be so, and those of several to follow each other.

    Raises:
        ValueError: Nothing of these kinds is expected.
    """
    if isinstance(expected_lines, str):
        wanted = expected_lines
        find = _lines(lambda line: line == wanted if strict else wanted in line, strict)
    elif isinstance(expected_lines, re.Pattern):
        pattern = expected_lines
        find = _lines(lambda line: pattern.match(line) is not None, strict)
    elif isinstance(expected_lines, Iterable):
        find = _one_after_another([build_line_match(each) for each in expected_lines], strict)
    else:
        raise ValueError("Unknown format for expected lines")
    return lambda actual_lines, start=0: find(actual_lines, start)


def _lines(fits: Callable[[str], bool], strict: bool) -> _Match[Sequence[str]]:
    def find(lines: Sequence[str], start: int) -> Span | None:
        if strict:
            return (start, len(lines)) if all(map(fits, lines[start:])) else None
        return next(
            ((index, index + 1) for index in range(start, len(lines)) if fits(lines[index])), None
        )

    return find


def _one_after_another(matches: list[Callable[..., Span | None]], strict: bool) -> _Match[Any]:
    def find(output: Any, start: int) -> Span | None:
        begin, end = None, start
        for match in matches:
            span = match(output, end)
            if span is None or (strict and span[0] != end):
                return None
            begin = span[0] if begin is None else begin
            end = span[1]
        return (start if begin is None else begin, end)

    return find
