"""Tables of a format's tags and attributes, and whether each is supported.

A table is written as lines of a mark, the path of a tag, and its children:

    + surface/friction/ode: mu mu2
    - surface/friction/ode: slip1 fdir1 | friction is the same in all directions
    - .: kinematic=false=0
    * surface/contact/ode: max_vel=0.01
    > .: sensor@name@type

A ``+`` tag is supported, or the code that reads it reports what is missing. A ``-`` tag has no
effect, and is reported unless it only repeats its default: one of the texts after ``=``, or else
zero or false. A ``*`` tag has no effect either, and concerns only Gazebo's own window, drawing or
solver. A ``>`` tag is read, and its content is checked, by other code.
Attributes start with ``@``, after their tag or as separate words. Of several equal ``+`` tags only
the first one is used, unless the tag is followed by ``*``. Tags and attributes that are not in the
table are unknown.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Literal, NamedTuple

from teleopctl.errors import similar_names
from teleopctl.robot.elements import to_number

if TYPE_CHECKING:
    from lxml import etree

Fate = Literal["works", "no effect", "gazebo's own", "read by others"]

_MARKS: dict[str, Fate] = {
    "+": "works",
    "-": "no effect",
    "*": "gazebo's own",
    ">": "read by others",
}
# Attributes of a <pose>; `frame` was one until SDF 1.6.
_OF_POSES = ("relative_to", "rotation_format", "degrees", "frame")


# Maximum number of lines listed for one kind of finding.
_MOST_LINES = 5


class TagEntry(NamedTuple):
    """Known tag or attribute of a format: support, default, and why it has no effect.

    Attributes:
        fate: Support of the tag.
        usual: Texts of the default, with ``_`` for blanks; empty for zero and false.
        because: Reason why the tag has no effect; empty for no explanation.
        many: Whether several are allowed in one element.
    """

    fate: Fate
    usual: tuple[str, ...] = ()
    because: str = ""
    many: bool = True


class TagFinding(NamedTuple):
    """Finding about a tag or attribute in a description: unknown, repeated or without effect.

    Attributes:
        element: Element of the tag, or element with the attribute.
        path: Path of the tag or attribute in the table.
        entry: Entry of the tag or attribute in the table; None if unknown.
        alike: Known name similar to an unknown name; empty for none.
    """

    element: etree._Element
    path: str
    entry: TagEntry | None
    alike: str = ""

    @property
    def described(self) -> str:
        """Tag or attribute as text for a sentence: ``<tag>`` or ``'attribute' of <tag>``."""
        _, at, attribute = self.path.rpartition("@")
        if at:
            return f"'{attribute}' of <{local_name(self.element.tag)}>"
        if self.entry is not None:
            return f"<{self.path}>"
        parent = self.element.getparent()
        inside = "" if parent is None else f" in <{local_name(parent.tag)}>"
        return f"<{local_name(self.element.tag)}>{inside}"

    @property
    def sentence(self) -> str:
        """Sentence that the tag or attribute is unknown or repeated, or why it has no effect."""
        if self.entry is not None and self.entry.fate == "works":
            return f"Of several <{local_name(self.element.tag)}> side by side the first is used"
        if self.entry is None:
            hint = f" (is it {self.alike}?)" if self.alike else ""
            kind = "Attribute " if "@" in self.path else ""
            return f"{kind}{self.described} is unknown{hint}"
        because = f": {self.entry.because}" if self.entry.because else ""
        return f"{self.described} has no effect{because}"


class Table(Mapping[str, TagEntry]):
    """Table of a format's known tags and attributes, by path: ``path`` or ``path@attribute``.

    Args:
        text: Table as text; see the module's docstring.
        everywhere: Attributes that any tag may have.
    """

    def __init__(self, text: str, everywhere: tuple[str, ...] = ()) -> None:
        self._everywhere = everywhere
        self._entries: dict[str, TagEntry] = {}
        for line in filter(None, map(str.strip, text.splitlines())):
            mark, above, names = line.split(maxsplit=2)
            names, _, because = names.partition(" | ")
            parent = above.rstrip(":").strip(".")
            for word in names.split():
                self._add(parent, word, _MARKS[mark], because)
        self._below: dict[str, list[str]] = {}
        for path in self._entries:
            cut = "@" if "@" in path else "/"
            self._below.setdefault(path.rpartition(cut)[0] + cut.strip("/"), []).append(path)

    def _add(self, parent: str, word: str, fate: Fate, because: str) -> None:
        whole, *usual = word.split("=")
        entry = TagEntry(fate, tuple(usual), because)
        whole, *attributes = whole.split("@")
        path, name = "", ""
        parts = [part for part in f"{parent}/{whole}".split("/") if part]
        for part in parts:
            name, path = part, f"{path}/{part.removesuffix('*')}".lstrip("/")
            self._entries.setdefault(path, TagEntry("works", many=part.endswith("*")))
        if whole:
            self._entries[path] = entry._replace(many=fate != "works" or name.endswith("*"))
            entry = TagEntry("works")
        for attribute in (*attributes, *(_OF_POSES if name == "pose" else ())):
            self._entries[f"{path}@{attribute}"] = entry

    def __getitem__(self, path: str) -> TagEntry:
        return self._entries[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def findings(self, element: etree._Element, path: str = "") -> Iterator[TagFinding]:
        """Yield a finding for each tag and attribute in an element unknown or without effect.

        Args:
            element: Element of the description.
            path: Path of the element in the table.
        """
        yield from self._of_attributes(element, path)
        met: set[str] = set()
        for child in element:
            if not isinstance(child.tag, str):
                continue  # a comment
            here = f"{path}/{local_name(child.tag)}".lstrip("/")
            entry = self._entries.get(here)
            if entry is None:
                yield TagFinding(child, here, None, self._alike(path, local_name(child.tag)))
            elif here in met and not entry.many:
                yield TagFinding(child, here, entry)
            elif entry.fate == "works":
                met.add(here)
                yield from self.findings(child, here)
            elif entry.fate == "read by others":
                if any(known.startswith(f"{here}@") for known in self._entries):
                    yield from self._of_attributes(child, here)
            elif not is_default(child, entry.usual):
                yield TagFinding(child, here, entry)

    def _of_attributes(self, element: etree._Element, path: str) -> Iterator[TagFinding]:
        for attribute in element.attrib:
            here = f"{path}@{local_name(attribute)}"
            entry = self._entries.get(here)
            if entry is None and local_name(attribute) not in self._everywhere:
                yield TagFinding(
                    element, here, None, self._alike(f"{path}@", local_name(attribute))
                )
            elif entry is None:
                continue
            elif entry.fate == "no effect" and not _is_default_text(
                str(element.get(attribute)), entry.usual
            ):
                yield TagFinding(element, here, entry)

    def _alike(self, above: str, name: str) -> str:
        names = [path.removeprefix(above).lstrip("/") for path in self._below.get(above, ())]
        return next(iter(similar_names(name, names, 1)), "")


def is_default(element: etree._Element, usual: tuple[str, ...] = ()) -> bool:
    """Return whether a tag, with its children, only repeats its default.

    All children of the tag must be zero: a flag among them that is false may be true by default.
    A ``<type>`` child only names the kind of the parent, and is ignored.

    Args:
        element: Element of the tag.
        usual: Texts of the default; see `TagEntry`.
    """
    children = [child for child in element if isinstance(child.tag, str)]
    if not children:
        return _is_default_text(tag_value(element), usual)
    return all(
        is_default(child) and tag_value(child).lower() != "false"
        for child in children
        if child.tag != "type"
    )


def tag_value(tag: etree._Element) -> str:
    """Return the text of a tag, or else its attribute ``value``, with single blanks."""
    return " ".join((tag.text or tag.get("value") or "").split())


def gazebo_only_text(tags: Mapping[str, list[int]]) -> str:
    """Return one sentence about tags that only Gazebo's window, drawing or solver uses.

    Args:
        tags: Line numbers by tag.
    """
    listed = ", ".join(f"<{tag}> (line {lines_text(lines, 1)})" for tag, lines in tags.items())
    return f"Without meaning outside of Gazebo's window, drawing and solver: {listed}"


def lines_text(lines: list[int], most: int = _MOST_LINES) -> str:
    """Return line numbers as text, at most ``most`` of them: "3, 7 and 2 more lines"."""
    different = sorted({*lines})
    listed = ", ".join(map(str, different[:most]))
    more = len(different) - most
    if more <= 0:
        return listed
    return f"{listed} and {more} more line{'s' if more > 1 else ''}"


def local_name(name: object) -> str:
    """Return the name of a tag or attribute without its XML namespace."""
    return str(name).rpartition("}")[2]


def _is_default_text(text: str, usual: tuple[str, ...]) -> bool:
    words = text.lower().split()
    if " ".join(words) in (usual or ("false",)):
        return True
    numbers = [to_number(word) for word in words]
    if None in numbers or not numbers:
        return False
    if usual:
        return any(numbers == [to_number(part) for part in one.split("_")] for one in usual)
    return not any(numbers)
