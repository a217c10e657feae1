"""XML with line numbers: tags, and the elements that their attributes and nested tags are.

Read with expat: it is there in 2 ms where lxml takes 50, and knows the line on which a tag begins,
where lxml knows that on which it ends.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from teleopctl.base.budget import DEEPEST_TAGS
from teleopctl.base.text_file import read_text
from teleopctl.errors import LaunchError
from teleopctl.launch.model import values
from teleopctl.launch.model.descriptions import Place
from teleopctl.launch.model.element import Element

_ATTRIBUTE = re.compile(rb"""\s+([^\s=]+)\s*=\s*(?:"[^"]*"|'[^']*')""")
_SEPARATOR = "-sep"


class Attribute(Element):
    """Attribute of a tag, with its place."""

    __slots__ = ()
    noun = "attribute"

    def items(self, what: str) -> Iterator[Element]:
        """Return the value as a list; see `Element.items`."""
        del what  # which is in the words of YAML
        if not isinstance(self.value, list):
            name = self.path.rpartition(".")[2]
            raise self.error(f"expected tags <{name}>, got an attribute with {self.describe()}")
        yield from self.value

    def typed(self) -> Element:
        """Return the attribute's text parsed as YAML, as ROS 2 does."""
        if isinstance(self.value, list):
            return Element([item.typed() for item in self.value], self.place, self.path)
        value = values.typed(self.value)
        if isinstance(value, list):
            value = [Element(item, self.place, self.path) for item in value]
        return Element(value, self.place, self.path)

    def flag(self) -> bool:
        """Return the value as a truth value, also for 1 and 0."""
        if self.value in ("1", "0"):
            return bool(self.value == "1")
        return super().flag()


@dataclass(frozen=True, slots=True)
class XmlTag(Element):
    """XML tag with its attributes, children and place.

    Attributes:
        name: Its name.
        attributes: Attributes by name.
        nested: Nested tags, in order.
    """

    noun = "tag"

    name: str
    attributes: Mapping[str, Element]
    nested: list[XmlTag]

    def fields(self, keys: Sequence[str]) -> Mapping[str, Element]:
        """Return attributes and nested tags by key.

        Tags that have the name of a key are a list of that key; the others are ``children`` where
        there may be such.
        """
        known = {_canonical(key) for key in keys} - {"children"}
        fields = dict(self.attributes)
        lists: dict[str, list[XmlTag]] = {}
        children: list[XmlTag] = []
        for tag in self.nested:
            if _canonical(tag.name) in known:
                lists.setdefault(tag.name, []).append(tag)
            elif "children" in keys:
                children.append(tag)
            else:
                fields[tag.name] = tag
        for name, tags in lists.items():
            if name in fields:
                raise tags[0].error(f"'{name}' stands here as an attribute and as a tag")
            fields[name] = _Tags(tags, tags[0].place, tags[0].path)
        if "children" in keys:
            fields.setdefault("children", _Tags(children, self.place, self.path))
        return fields

    def action(self) -> tuple[str, Element]:
        """Return the name and content of an action."""
        return self.name, self

    def describe(self) -> str:
        """Return a description of the tag, for messages."""
        return f"a tag <{self.name}>"


class _Tags(Element):
    """Nested tags of one name, or the actions in a tag."""

    __slots__ = ()
    noun = "tag"

    def describe(self) -> str:
        """Return a description of the tags, for messages."""
        return f"a tag <{self.path.rpartition('.')[2]}>"


def load(path: Path) -> XmlTag:
    """Read an XML file.

    Raises:
        LaunchError: When the file cannot be read, is not XML, or has entities of its own, which
            are left alone; the message has the line.
    """
    return parsed(read_text(path), path)


def parsed(text: str, path: Path) -> XmlTag:
    """Parse XML text; see `load`."""
    return _Reader(path).read(text)


class _Reader:
    """Makes the tree from what expat reports."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._open: list[XmlTag] = []
        self._root: XmlTag | None = None
        self._source = b""
        # The text is decoded already, so an encoding that it declares no longer holds.
        self._expat = expat.ParserCreate("utf-8")
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.EntityDeclHandler = self._refuse_entity

    def read(self, text: str) -> XmlTag:
        self._source = text.encode()
        try:
            self._expat.Parse(self._source, True)
        except expat.ExpatError as error:
            reason = expat.errors.messages[error.code]
            raise LaunchError(f"{self._path}:{error.lineno}: not XML: {reason}") from error
        assert self._root is not None  # expat refuses a text without a tag
        return self._root

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        place = Place(self._path, self._expat.CurrentLineNumber)
        if len(self._open) > DEEPEST_TAGS:
            raise LaunchError(f"{place}: nested too deeply")
        path = f"{self._open[-1].path}.{name}".lstrip(".") if self._open else ""
        lines = self._lines_of_attributes(name)
        elements: dict[str, Element] = {
            key: Attribute(
                text, Place(self._path, lines.get(key, place.line)), f"{path}.{key}".lstrip(".")
            )
            for key, text in attributes.items()
        }
        tag = XmlTag(None, place, path, name, _split(elements), [])
        if self._open:
            self._open[-1].nested.append(tag)
        else:
            self._root = tag
        self._open.append(tag)

    def _end(self, _: str) -> None:
        self._open.pop()

    def _lines_of_attributes(self, name: str) -> dict[str, int]:
        at = self._expat.CurrentByteIndex + 1 + len(name.encode())
        line = self._expat.CurrentLineNumber
        lines: dict[str, int] = {}
        while match := _ATTRIBUTE.match(self._source, at):
            lines[match[1].decode()] = line + self._source.count(b"\n", at, match.start(1))
            line += self._source.count(b"\n", at, match.end())
            at = match.end()
        return lines

    def _refuse_entity(self, name: str, *_: object) -> None:
        raise LaunchError(
            f"{self._path}:{self._expat.CurrentLineNumber}: an entity, '{name}', is not read",
            hint="Use a launch variable: <let name=… value=…/> and $(var …).",
        )


def _split(attributes: dict[str, Element]) -> dict[str, Element]:
    """Divide the texts for which there is an attribute ``NAME-sep``."""
    separators = {
        name: f"{name}{_SEPARATOR}" for name in attributes if f"{name}{_SEPARATOR}" in attributes
    }
    if not separators:
        return attributes
    divided = {
        name: element for name, element in attributes.items() if name not in separators.values()
    }
    for name, key in separators.items():
        element, separator = attributes[name], attributes[key]
        if not separator.value:
            raise separator.error("expected a text that stands between the items, got nothing")
        items = element.value.split(separator.value)
        divided[name] = Attribute(
            [Attribute(item, element.place, element.path) for item in items],
            element.place,
            element.path,
        )
    return divided


def _canonical(name: str) -> str:
    return name.replace("-", "_")
