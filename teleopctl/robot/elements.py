"""Readers of XML elements' attributes, numbers and vectors, whose errors name element and line.

Shared by the readers of URDF and of its extensions.
"""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from lxml import etree

from teleopctl.errors import InvalidDescriptionError

Vector3 = tuple[float, float, float]

_LATE_DECLARATION = re.compile(rb"\A\s+<\?xml[^>]*\?>")

# Errors that Gazebo's XML parser accepts and that occur in files: an undeclared prefix such as gz:,
# two hyphens in a comment, an XML declaration after a comment.
_LET_PASS = (
    etree.ErrorTypes.NS_ERR_UNDEFINED_NAMESPACE,
    etree.ErrorTypes.NS_ERR_QNAME,
    etree.ErrorTypes.ERR_HYPHEN_IN_COMMENT,
    etree.ErrorTypes.ERR_RESERVED_XML_NAME,
)


class XmlElement(Protocol):
    """Interface of an XML element, as in lxml."""

    tag: str
    text: str | None
    sourceline: int | None

    def get(self, key: str) -> str | None:
        """Return the value of an attribute of the element, or None."""
        ...

    def find(self, path: str) -> "XmlElement | None":
        """Return the first child element that matches a tag path, or None."""
        ...

    def findall(self, path: str) -> "list[XmlElement]":
        """Return every child element that matches a tag path."""
        ...

    def set(self, key: str, value: str) -> None:
        """Set an attribute of the element."""
        ...

    def remove(self, element: "XmlElement") -> None:
        """Remove a child element."""
        ...

    def __iter__(self) -> "Iterator[XmlElement]": ...


def parse(text: str) -> XmlElement:
    """Parse the text of a URDF; return its root element, without comments.

    Raises:
        InvalidDescriptionError: When the text is empty or not XML, with ros2_control's message.
    """
    if not text.strip():
        raise InvalidDescriptionError("empty URDF passed to robot")
    # The text is decoded already, so an encoding that it declares no longer holds. Entities are not
    # resolved: through them a description could read other files.
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, remove_comments=True, remove_pis=True
    )
    try:
        root: XmlElement = etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError as error:
        raise InvalidDescriptionError(
            f"invalid URDF passed in to robot parser: {error.msg}"
        ) from error
    return root


def parse_file(path: Path, content: bytes) -> XmlElement:
    """Parse a robot's or world's file as leniently as Gazebo does; return its root element.

    Blank lines before the XML declaration, undeclared prefixes and two hyphens in a comment are
    accepted.

    Args:
        path: Path of the file, for error messages.
        content: Content of the file.

    Raises:
        InvalidDescriptionError: When the file is empty or not XML, with file and line.
    """
    content = _LATE_DECLARATION.sub(lambda match: b"\n" * match[0].count(b"\n"), content)
    # Entities are not resolved: they could read other files.
    parser = etree.XMLParser(
        resolve_entities=False, remove_comments=True, remove_pis=True, recover=True
    )
    try:
        # The file's name stays with elements that are moved to another document.
        name = str(path).encode(errors="replace").decode()
        root: XmlElement | None = etree.fromstring(content, parser, base_url=name)
    except etree.XMLSyntaxError as error:
        raise InvalidDescriptionError(
            f"{path}:{error.lineno}: invalid XML: {error.msg or 'it is empty'}"
        ) from error
    for fault in parser.error_log:
        if fault.type not in _LET_PASS:
            raise InvalidDescriptionError(f"{path}:{fault.line}: invalid XML: {fault.message}")
    if root is None:
        raise InvalidDescriptionError(f"{path}:1: invalid XML: it is empty")
    return root


def describe(element: XmlElement) -> str:
    """Return an element's tag, name and line as text: "<joint> 'elbow' (line 7)"."""
    name = element.get("name")
    named = f" '{name}'" if name else ""
    return f"<{element.tag}>{named}{line_of(element.sourceline)}"


def line_of(number: int | None) -> str:
    """Return " (line 7)" for a line number, or an empty text for None or 0."""
    return f" (line {number})" if number else ""


def required(element: XmlElement, attribute: str) -> str:
    """Return the value of an element's attribute; raise if it is missing or empty.

    Raises:
        InvalidDescriptionError: When the attribute is missing or empty.
    """
    value = element.get(attribute)
    if not value:
        name = element.get("name")
        named = f" with name '{name}'" if name else ""
        raise InvalidDescriptionError(
            f"no attribute '{attribute}' in '{element.tag}' tag{named}",
            hint=f"See line {element.sourceline} of the URDF." if element.sourceline else None,
        )
    return value


def child_text(element: XmlElement, tag: str, default: str = "") -> str:
    """Return the stripped text of a child element; the default if it is missing."""
    child = element.find(tag)
    return default if child is None else (child.text or "").strip()


def to_number(text: str) -> float | None:
    """Return a text as a float, infinity included; None for NaN and texts that are no number."""
    try:
        value = float(text)
    except ValueError:
        return None
    # Python's grammar is wider than URDF's
    return None if math.isnan(value) or "_" in text else value


def number(
    element: XmlElement, attribute: str, default: float | None = None, *, finite: bool = True
) -> float:
    """Return an attribute as a number; raise if invalid, or if missing without a default.

    Args:
        element: Element with the attribute.
        attribute: Name of the attribute.
        default: Value for a missing attribute; None makes the attribute required.
        finite: Whether infinity is an error.

    Raises:
        InvalidDescriptionError: When the attribute is required and missing, or is no number.
    """
    text = element.get(attribute)
    if text is None and default is not None:
        return default
    value = to_number(required(element, attribute))
    if value is None or (finite and math.isinf(value)):
        kind = "a number" if value is None else "a finite number"
        raise InvalidDescriptionError(
            f"{describe(element)}: attribute '{attribute}' should be {kind}, got '{text}'"
        )
    return value


def numbers(element: XmlElement, attribute: str, count: int) -> tuple[float, ...]:
    """Return an attribute as exactly ``count`` finite numbers; raise if missing or invalid.

    Raises:
        InvalidDescriptionError: When the attribute is missing or is not ``count`` finite numbers.
    """
    text = required(element, attribute)
    values = [to_number(part) for part in text.split()]
    found = tuple(value for value in values if value is not None)
    if not len(values) == len(found) == count:
        raise InvalidDescriptionError(
            f"{describe(element)}: attribute '{attribute}' should be {count} numbers, got '{text}'"
        )
    if not all(map(math.isfinite, found)):
        raise InvalidDescriptionError(
            f"{describe(element)}: attribute '{attribute}' should be finite, got '{text}'"
        )
    return found


def vector(element: XmlElement, attribute: str, default: Vector3 | None = None) -> Vector3:
    """Return an attribute as three finite numbers; raise if invalid, or missing without a default.

    Raises:
        InvalidDescriptionError: When the attribute is required and missing, or is not three finite
            numbers.
    """
    if element.get(attribute) is None and default is not None:
        return default
    x, y, z = numbers(element, attribute, 3)
    return x, y, z


def boolean(text: str, where: str) -> bool:
    """Return the text ``true`` or ``false``, in any case, as a bool; raise for other texts.

    Raises:
        InvalidDescriptionError: When the text is anything else.
    """
    lowered = text.strip().lower()
    if lowered not in ("true", "false"):
        raise InvalidDescriptionError(f"{where} should be true or false, got '{text}'")
    return lowered == "true"
