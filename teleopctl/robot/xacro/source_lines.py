"""Source files and lines of the elements in an expanded robot description (xacro or SDF).

xacro does not keep line numbers. So each element gets an attribute with its place when its file is
read; macros copy the attribute with the element, and it is removed from the result.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from lxml import etree

# Source file and line, by line of a text.
Places = Mapping[int, tuple[Path, int]]

_NOTE = "teleopctl-place"
_LINES = re.compile(r"\bline (\d+(?:, \d+)*)")


def with_source_places(sentence: str, places: Places) -> str:
    """Return a sentence with "line N" of the expanded text replaced by "FILE:LINE" of the source.

    Args:
        sentence: A sentence with "line 3" or "line 3, 5".
        places: File and line of each line of the expanded text.
    """

    def written(match: re.Match[str]) -> str:
        numbers = [int(number) for number in match[1].split(", ")]
        if not all(number in places for number in numbers):
            return match[0]
        lines = (f"{_shown(places[number][0])}:{places[number][1]}" for number in numbers)
        return ", ".join(dict.fromkeys(lines))

    return _LINES.sub(written, sentence) if places else sentence


def _shown(path: Path) -> str:
    """Return a path relative to the current folder, if it is below that."""
    here = Path.cwd()
    return os.path.relpath(path, here) if path.is_relative_to(here) else str(path)


class SourceLines:
    """Recorder of the file and line of each element that xacro reads.

    Attributes:
        files: Files that were read; their indices are recorded in the elements.
    """

    def __init__(self) -> None:
        self.files: list[Path] = []

    # Any: minidom documents, as xacro uses them.
    def record(self, document: Any, path: Path) -> None:
        """Store the source file and line in an attribute of each element of a parsed document.

        Args:
            document: Document that xacro has parsed.
            path: Path of the document's file.
        """
        parser = etree.XMLParser(resolve_entities=False, remove_comments=True, remove_pis=True)
        try:
            lines = [element.sourceline for element in etree.parse(path, parser).iter("*")]
        except (OSError, etree.XMLSyntaxError):
            return  # xacro reports it
        self.files.append(path)
        for element, line in zip(document.getElementsByTagName("*"), lines, strict=False):
            # xacro's own elements are not in the result, and raise for unknown attributes.
            if ":" not in element.tagName:
                element.setAttribute(_NOTE, f"{len(self.files) - 1}:{line}")

    # Any: a minidom document.
    def remove(self, document: Any) -> list[tuple[Path, int] | None]:
        """Remove the stored attributes; return each element's file and line, in document order."""
        found: list[tuple[Path, int] | None] = []
        for element in document.getElementsByTagName("*"):
            file, _, line = element.getAttribute(_NOTE).partition(":")
            found.append((self.files[int(file)], int(line)) if line.isdecimal() else None)
            if element.hasAttribute(_NOTE):
                element.removeAttribute(_NOTE)
        return found


@contextlib.contextmanager
def recorded_lines(xacro: ModuleType) -> Iterator[SourceLines]:
    """Yield `SourceLines` that record the source line of each element that xacro then reads."""
    notes, parse = SourceLines(), vars(xacro)["parse"]

    # Any: as in xacro's `parse`.
    def noting(source: Any, filename: str | None = None) -> Any:
        document = parse(source, filename)
        if source is None and filename is not None:
            notes.record(document, Path(filename).absolute())
        return document

    vars(xacro).update(parse=noting)
    try:
        yield notes
    finally:
        vars(xacro).update(parse=parse)


def source_places(
    text: str, element_places: list[tuple[Path, int] | None]
) -> dict[int, tuple[Path, int]]:
    """Return source file and line by line of the expanded XML; elements are in document order.

    Args:
        text: Expanded XML.
        element_places: Source file and line of each element, in document order, as
            `SourceLines.remove` returns them.
    """
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, remove_comments=True, remove_pis=True
    )
    elements = list(etree.fromstring(text.encode(), parser).iter("*"))
    if len(elements) != len(element_places):
        return {}
    return {
        element.sourceline: place
        for element, place in zip(elements, element_places, strict=True)
        if place is not None and element.sourceline
    }
