"""Reader of XML launch files: tags with line numbers; launch files of ROS 1 are refused.

The parser is expat: its import takes 2 ms, that of lxml 50 ms; and it reports the line on which a
tag begins, where lxml reports the line on which it ends.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.parsers import expat

from teleopctl.base.budget import DEEPEST_TAGS
from teleopctl.base.files import read_text
from teleopctl.base.typed import Iterator, Mapping, NamedTuple, Sequence
from teleopctl.errors import LaunchError
from teleopctl.launch.frontends.steps import launch_file
from teleopctl.launch.model import values
from teleopctl.launch.model.action import LaunchFile
from teleopctl.launch.model.descriptions import Place
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.records import dataclass

_ATTRIBUTE = re.compile(rb"""\s+([^\s=]+)\s*=\s*(?:"[^"]*"|'[^']*')""")
_SEPARATOR = "-sep"


class Attribute(Element):
    """XML attribute as a launch file element, with its file and line."""

    __slots__ = ()
    noun = "attribute"

    def items(self, expected: str) -> Iterator[Element]:
        """Yield the items of an attribute that ``NAME-sep`` splits; raise for other attributes."""
        del expected  # describes YAML
        if not isinstance(self.value, list):
            name = self.path.rpartition(".")[2]
            raise self.error(f"expected tags <{name}>, got an attribute with {self.describe()}")
        yield from self.value

    def typed(self) -> Element:
        """Return an element with the attribute's value, parsed as YAML (number, list, …)."""
        if isinstance(self.value, list):
            return Element([item.typed() for item in self.value], self.place, self.path)
        value = values.typed(self.value)
        if isinstance(value, list):
            value = [Element(item, self.place, self.path) for item in value]
        return Element(value, self.place, self.path)

    def flag(self) -> bool:
        """Return the attribute as a boolean; ``1`` and ``0`` are accepted too."""
        if self.value in ("1", "0"):
            return bool(self.value == "1")
        return super().flag()


@dataclass(frozen=True, slots=True)
class XmlTag(Element):
    """XML tag as a launch file element, with attributes, nested tags, file and line.

    Attributes:
        name: Name of the tag.
        attributes: Attributes by name.
        nested: Nested tags, in order.
    """

    noun = "tag"

    name: str
    attributes: Mapping[str, Element]
    nested: list[XmlTag]

    def fields(self, keys: Sequence[str]) -> Mapping[str, Element]:
        """Return attributes and nested tags by key; tags named like a key form a list.

        All other tags form the list ``children``, if that is among the keys.
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
                raise tags[0].error(f"'{name}' is given as an attribute and as a tag")
            fields[name] = _Tags(tags, tags[0].place, tags[0].path)
        if "children" in keys:
            fields.setdefault("children", _Tags(children, self.place, self.path))
        return fields

    def action(self) -> tuple[str, Element]:
        """Return the tag's name as the action's name, and the tag as its content."""
        return self.name, self

    def describe(self) -> str:
        """Return ``a tag <NAME>`` with the launch file tag's own name, for error messages."""
        return f"a tag <{self.name}>"


class _Tags(Element):
    """Nested tags of one name in an XML launch file, or the actions in a tag."""

    __slots__ = ()
    noun = "tag"

    def describe(self) -> str:
        """Return ``a tag <NAME>`` with the launch file tag's own name, for error messages."""
        return f"a tag <{self.path.rpartition('.')[2]}>"


def _load(path: Path) -> XmlTag:
    """Read an XML file.

    Raises:
        LaunchError: The file cannot be read, is not XML, or declares entities; the message has the
            line.
    """
    return parse_xml(read_text(path), path)


def parse_xml(text: str, path: Path) -> XmlTag:
    """Parse the text of an XML file, and return its root tag.

    Raises:
        LaunchError: The text is not XML or declares entities; the message has the line.
    """
    return _Reader(path).read(text)


class _Reader:
    """Builder of the tree of `XmlTag` from expat's callbacks."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._open: list[XmlTag] = []
        self._root: XmlTag | None = None
        self._source = b""
        # The text is decoded already, so its encoding declaration no longer applies.
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
    """Split each attribute NAME into a list where the tag has an attribute ``NAME-sep``."""
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
            raise separator.error("expected the text between the items, got nothing")
        items = element.value.split(separator.value)
        divided[name] = Attribute(
            [Attribute(item, element.place, element.path) for item in items],
            element.place,
            element.path,
        )
    return divided


def _canonical(name: str) -> str:
    return name.replace("-", "_")


_SUBSTITUTION = re.compile(r"(?<!\\)\$\(\s*(find|arg)\s+([^\s()]+)")
# Substitutions that ROS 1 does not have.
_OF_ROS_2 = re.compile(r"(?<!\\)\$\(\s*(var|find-pkg-\w+)\s")
_IN_ROS_2 = {"find": "find-pkg-share", "arg": "var"}

_TAGS = {
    "rosparam": "<param from=…/> in a node",
    "machine": "one launch on each machine",
    "test": "a test in Python with launch_testing",
}
_OUTSIDE_OF_NODES = {
    "param": "<set_parameter name=… value=…/>, or <param> in a node,",
    "remap": "<set_remap from=… to=…/>",
    "env": "<set_env name=… value=…/>",
}
_ATTRIBUTES = {
    ("node", "type"): "<node exec=…>",
    ("node", "ns"): "<node namespace=…>",
    ("group", "ns"): "<push_ros_namespace namespace=…/> in the group",
    ("include", "ns"): "<push_ros_namespace namespace=…/> in a group around it",
    ("include", "pass_all_args"): "needless, since the included file has every argument,",
    ("arg", "doc"): "<arg description=…>",
}


class _Sign(NamedTuple):
    """Sign of a ROS 1 launch file: an attribute or tag that ROS 2 would not have.

    Attributes:
        element: The attribute or tag.
        text: Text that names the element, and its equivalent in ROS 2.
        is_proof: Whether the element is certainly of ROS 1; otherwise it may be an error in ROS 2.
    """

    element: Element
    text: str
    is_proof: bool


def refuse_ros1(root: XmlTag) -> None:
    """Raise an error if an XML launch file is one of ROS 1.

    Raises:
        LaunchError: The file is one of ROS 1; the message names the first such line, and its
            equivalent in ROS 2.
    """
    signs = list(_signs(root))
    is_certain = any(sign.is_proof for sign in signs)
    if not signs or (not is_certain and _is_of_ros_2(root)):
        return
    first, *others = sorted(signs, key=lambda sign: sign.element.place.line)
    lines = sorted({sign.element.place.line for sign in others} - {first.element.place.line})
    raise LaunchError(
        f"{first.element.place}: this is a launch file of ROS 1: {first.text} in ROS 2",
        hint=f"Its other lines of ROS 1: {', '.join(map(str, lines))}." if lines else None,
    )


def _signs(tag: XmlTag) -> Iterator[_Sign]:
    for name, element in tag.attributes.items():
        if (known := _ATTRIBUTES.get((tag.name, name))) is not None:
            proof = name == "type" and "exec" not in tag.attributes
            yield _Sign(element, f"<{tag.name} {name}=…> is {known}", proof)
        # A description is text: ROS 2 shows it as written.
        if name != "description" and isinstance(element.value, str):
            for word, argument in _SUBSTITUTION.findall(element.value):
                text = f"$({word} {argument}) is $({_IN_ROS_2[word]} {argument})"
                yield _Sign(element, text, is_proof=True)
    for nested in tag.nested:
        if nested.name == "arg" and tag.name != "include" and "value" in nested.attributes:
            value = nested.attributes["value"]
            yield _Sign(value, "<arg value=…> is <let name=… value=…/>", is_proof=False)
        if nested.name in _TAGS:
            yield _Sign(nested, f"<{nested.name}> is {_TAGS[nested.name]}", is_proof=True)
        elif nested.name in _OUTSIDE_OF_NODES and tag.name in ("launch", "group"):
            text = f"<{nested.name}> outside of a node is {_OUTSIDE_OF_NODES[nested.name]}"
            yield _Sign(nested, text, is_proof=False)
        yield from _signs(nested)


def _is_of_ros_2(tag: XmlTag) -> bool:
    """Return whether a tag contains an attribute or tag that only ROS 2 has."""
    if tag.name == "node" and "exec" in tag.attributes:
        return True
    texts = (element.value for element in tag.attributes.values())
    if any(isinstance(text, str) and _OF_ROS_2.search(text) for text in texts):
        return True
    return any(map(_is_of_ros_2, tag.nested))


def parse_file(path: Path) -> LaunchFile:
    """Read an XML launch file, and return its path and steps; raise for one of ROS 1.

    Attributes of ``<launch>`` itself are ignored, as in ROS 2, except ``deprecated``.

    Raises:
        TeleopctlError: The file cannot be read or is no valid launch file. The message names file,
            line, tag and attribute, and what was expected there.
    """
    root = _load(path)
    if root.name != "launch":
        raise root.error(f"expected <launch> as the outermost tag, got <{root.name}>")
    refuse_ros1(root)
    actions = root.fields(("children",))["children"]
    return launch_file(path, actions, root.attributes.get("deprecated"))
