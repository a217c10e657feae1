"""Repair of URDFs that urdfdom accepts, into the form that our readers and MuJoCo's accept.

Many robots were written for urdfdom, which leaves out a shape that it cannot read, uses the first
of several elements where only one is allowed, and rejects a robot only for its joints or tree. Each
repair is reported.
"""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import XmlElement, to_number
from teleopctl.robot.urdf import read_collision, read_inertial, read_visual

# Children that may appear once, by parent tag.
_ONCE = {
    "link": ("inertial",),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "inertial": ("origin", "mass", "inertia"),
    "material": ("color", "texture"),
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics"),
}
# Tag of a remark that a converter adds to the URDF that it makes from another format.
REMARK = "remark"
_VECTORS = ("xyz", "rpy", "size", "scale", "rgba")
_INERTIAS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_PARTS: dict[str, Callable[[XmlElement], object]] = {
    "visual": lambda element: read_visual(element, {}),
    "collision": read_collision,
    "inertial": read_inertial,
}


def repair_urdf(robot: XmlElement) -> list[str]:
    """Repair a ``<robot>`` in place where urdfdom would accept it; return sentences on the repairs.

    Returns:
        One sentence for each kind of repair, with its lines.
    """
    notes = _Notes()
    for remark in robot.findall(REMARK):
        notes.add((remark.text or "").strip())
    for link in robot.findall("link"):
        _repair_tree(link, notes)
        for tag, read in _PARTS.items():
            for part in link.findall(tag):
                try:
                    read(part)
                except InvalidDescriptionError as error:
                    notes.add(f"<{tag}> of link '{link.get('name')}' is left out: {error.message}")
                    link.remove(part)
    joints = robot.findall("joint")
    names = {joint.get("name") for joint in joints}
    for joint in joints:
        _repair_tree(joint, notes)
        for dynamics in joint.findall("dynamics"):
            _repair_dynamics(dynamics, notes)
        mimic = joint.find("mimic")
        if mimic is not None and (leader := mimic.get("joint")) and leader not in names:
            notes.add(
                f"Joint '{joint.get('name')}' mimics the joint '{leader}', which does not exist: "
                "it moves independently"
            )
            joint.remove(mimic)
    for material in robot.findall("material"):
        _repair_tree(material, notes)
    return notes.sentences()


class _Notes:
    """Sentences about repairs, each with its lines."""

    def __init__(self) -> None:
        self._lines: dict[str, list[int]] = {}

    def add(self, sentence: str, at: XmlElement | None = None) -> None:
        lines = self._lines.setdefault(sentence, [])
        if at is not None and at.sourceline and at.sourceline not in lines:
            lines.append(at.sourceline)

    def sentences(self) -> list[str]:
        return [
            f"{sentence} (line {', '.join(map(str, lines))})" if lines else sentence
            for sentence, lines in self._lines.items()
        ]


def _repair_tree(element: XmlElement, notes: _Notes) -> None:
    """Repair an element and all elements in it."""
    for tag in _ONCE.get(element.tag, ()):
        for more in element.findall(tag)[1:]:
            notes.add(f"Of several <{tag}> in one <{element.tag}> the first is used", more)
            element.remove(more)
    _repair_vectors(element, notes)
    if element.tag == "inertia":
        for attribute in _INERTIAS:
            if element.get(attribute) is None:
                element.set(attribute, "0")
    for child in list(element):
        if child.tag == "texture" and not child.get("filename"):
            notes.add("A <texture> without a file is dropped", child)
            element.remove(child)
        else:
            _repair_tree(child, notes)
    if element.tag == "geometry":
        for more in list(element)[1:]:
            notes.add("Of several shapes in one <geometry> the first is used", more)
            element.remove(more)


def _repair_dynamics(dynamics: XmlElement, notes: _Notes) -> None:
    for attribute in ("damping", "friction"):
        value = to_number(dynamics.get(attribute) or "0")
        if value is not None and value < 0.0:
            notes.add(f"A negative {attribute} counts as 0", dynamics)
            dynamics.set(attribute, "0")


def _repair_vectors(element: XmlElement, notes: _Notes) -> None:
    for attribute in _VECTORS:
        text = element.get(attribute)
        if text is None:
            continue
        words = text.replace(",", " ").split()
        if "," in text:
            notes.add("Commas between numbers are read as spaces", element)
        if not words and element.tag == "origin":
            notes.add(f'{attribute}="" counts as 0 0 0', element)
            words = ["0"] * 3
        if len(words) == 1 and element.tag == "mesh" and to_number(words[0]) is not None:
            notes.add(f'scale="{text}" is used for all three axes', element)
            words *= 3
        if words != text.split():
            element.set(attribute, " ".join(words))
