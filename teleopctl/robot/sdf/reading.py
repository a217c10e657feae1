"""Readers of an SDF file's elements: numbers, poses and frames, with errors that name the line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import parse_file, to_number
from teleopctl.robot.scene.scene import NOWHERE, SceneModel, Vector3
from teleopctl.robot.tags.table import Table, TagFinding, gazebo_only_text, lines_text, local_name
from teleopctl.tf import Transform, quaternion_from_rpy

MODEL = "__model__"
_ORIGINS = (MODEL, "world", "")


class _Placed(NamedTuple):
    """Pose of a frame relative to another one, and the element that sets it."""

    relative: str
    pose: Transform
    # Any: an lxml element.
    element: Any


@dataclass
class SdfFrames:
    """Frames of an SDF model or world by name, and their poses in the model or world.

    Attributes:
        file: SDF file of the model or world.
        attached: Link or frame that each frame is attached to.
    """

    file: SdfFile
    attached: dict[str, str] = field(default_factory=dict)
    _placed: dict[str, _Placed] = field(default_factory=dict)
    _known: dict[str, Transform] = field(default_factory=dict)

    # Any, here and below: lxml elements.
    def add(self, name: str, element: Any, default: str = MODEL) -> None:
        """Add the frame of an element (link, joint, frame …) with its ``<pose>``.

        Args:
            name: Name of the frame.
            element: ``<link>``, ``<joint>`` or ``<frame>`` element.
            default: Frame that the pose is relative to without ``relative_to``.
        """
        pose = element.find("pose")
        self.add_at(name, relative_to(pose) or default, self.file.pose(pose), element)

    def add_at(self, name: str, relative: str, pose: Transform, element: Any) -> None:
        """Add a frame by its pose relative to another frame."""
        self._placed[name] = _Placed(relative, pose, element)

    def add_model(self, model: SceneModel, element: Any, prefix: str) -> None:
        """Add a nested model's frame and the frames in the model, these with a prefix.

        Args:
            model: Nested model.
            element: ``<model>`` or ``<include>`` element of the nested model.
            prefix: Prefix of the names of the model's frames.
        """
        self.add_at(model.name, relative_to(element.find("pose")) or MODEL, model.pose, element)
        self.attached[model.name] = f"{prefix}{next(iter(model.bodies), '')}"
        for name, (link, pose) in model.frames.items():
            self.add_at(f"{prefix}{name}", model.name, pose, element)
            if link != name:
                self.attached[f"{prefix}{name}"] = f"{prefix}{link}"

    def __iter__(self) -> Iterator[str]:
        return iter(self._placed)

    def pose_of(self, name: str, element: Any) -> Transform:
        """Return a frame's pose in the model or world.

        Args:
            name: Name of the frame.
            element: Element that names the frame, for error messages.

        Raises:
            InvalidDescriptionError: The frame does not exist, or is relative to itself.
        """
        path: dict[str, None] = {}
        while name not in self._known and name not in _ORIGINS:
            if name in path:
                raise InvalidDescriptionError(
                    f"{self.file.place(element)}: frame '{name}' is, in the end, relative to itself"
                )
            if name not in self._placed:
                raise InvalidDescriptionError(
                    f"{self.file.place(element)}: there is no frame '{name}'"
                )
            path[name] = None
            name, _, element = self._placed[name]
        place = self._known.get(name, NOWHERE)
        for name in reversed(path):
            place = place @ self._placed[name].pose
            self._known[name] = place
        return place

    def link_of(self, name: str) -> str:
        """Return the name of the link that a frame is attached to."""
        met = {name}
        while (name := self.attached.get(name, name)) not in met:
            met.add(name)
        return name


# The root element was <gazebo> until SDF 1.2.
SDF_ROOTS = ("sdf", "gazebo")
_IN_POSE, _EULER = 6, "euler_rpy"
_TRUE = frozenset({"1", "true"})
_VERSION = re.compile(r"(\d{1,4})\.(\d{1,4})", re.ASCII)
_UNSAID_VERSION = (1, 6)


@dataclass
class Remarks:
    """Record of the SDF elements that were left out, with their files and lines.

    Attributes:
        lines: Line numbers by file and reason.
        own: Line numbers of elements that concern only Gazebo, by file and tag.
    """

    lines: dict[tuple[Path, str], list[int]] = field(default_factory=dict)
    own: dict[Path, dict[str, list[int]]] = field(default_factory=dict)

    def add(self, path: Path, line: int, words: str) -> None:
        """Record an element that is left out, with its file, line and the reason."""
        self.lines.setdefault((path, words), []).append(line)

    def add_own(self, path: Path, line: int, tag: str) -> None:
        """Record an element that concerns only Gazebo, with its file and line."""
        self.own.setdefault(path, {}).setdefault(tag, []).append(line)

    def sentences(self) -> tuple[str, ...]:
        """Return the warnings: for each file, one per reason and one on Gazebo-only elements."""
        texts = [
            f"{path}:{lines_text(lines)}: {words}" for (path, words), lines in self.lines.items()
        ]
        return *texts, *(f"{path}: {gazebo_only_text(tags)}" for path, tags in self.own.items())


def _is_a_value(found: TagFinding) -> bool:
    """Return whether a finding is a property with a value, instead of an object."""
    entry, text = found.entry, (found.element.text or "").strip()
    return entry is None or entry.fate == "works" or bool(entry.because) or bool(text)


# Any, here and below: lxml elements, whose class has no types.
@dataclass(frozen=True)
class SdfFile:
    """SDF file being read: typed access to its elements, and remarks on what is left out.

    Attributes:
        path: Path of the file.
        version: Version of SDF.
        remarks: Record that elements which are left out are added to.
    """

    path: Path
    version: tuple[int, int]
    remarks: Remarks

    def place(self, element: Any) -> str:
        """Return "FILE:LINE" of an element, for error messages."""
        return f"{self.path}:{element.sourceline}"

    def leave_out(self, element: Any, words: str = "is left out") -> None:
        """Record that an element of the file is left out, with the reason."""
        name = element.get("name")
        named = f" '{name}'" if name and element.tag not in ("visual", "collision") else ""
        self.remarks.add(
            self.path, element.sourceline or 0, f"<{local_name(element.tag)}>{named} {words}"
        )

    def check_tags(self, element: Any, table: Table, path: str = "") -> None:
        """Record an element's attributes and children that are unknown or without effect.

        Args:
            element: Element of the file.
            table: Known tags.
            path: Path of the element in the table.
        """
        for found in table.findings(element, path):
            line = found.element.sourceline or 0
            if found.entry is not None and found.entry.fate == "gazebo's own":
                self.remarks.add_own(self.path, line, str(local_name(found.element.tag)))
            elif "@" in found.path or _is_a_value(found):
                self.remarks.add(self.path, line, found.sentence)
            else:
                self.leave_out(found.element)

    def numbers(self, element: Any, count: int) -> tuple[float, ...]:
        """Return the numbers in an element's text; raise for another count.

        Raises:
            InvalidDescriptionError: The text has another count, or a number is not finite.
        """
        words = (element.text or "").split()
        values = tuple(value for word in words if (value := to_number(word)) is not None)
        if not len(words) == len(values) == count or not all(map(math.isfinite, values)):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            raise InvalidDescriptionError(
                f"{self.place(element)}: <{element.tag}> should be {wanted}, "
                f"got '{' '.join(words)}'"
            )
        return values

    def number(self, parent: Any, path: str, default: float) -> float:
        """Return the number in a child element; the default if the child is missing."""
        child = parent.find(path)
        if child is None:
            return default
        text = (child.text or "").strip().lower()
        if text in ("inf", "+inf", "infinity"):
            return math.inf
        if text in ("-inf", "-infinity"):
            return -math.inf
        return self.numbers(child, 1)[0]

    def vector(self, parent: Any, path: str, default: Vector3) -> Vector3:
        """Return the three numbers in a child element; the default if the child is missing."""
        child = parent.find(path)
        if child is None:
            return default
        x, y, z = self.numbers(child, 3)
        return x, y, z

    def flag(self, parent: Any, path: str, *, default: bool = False) -> bool:
        """Return whether a child element is true; the default if the child is missing."""
        child = parent.find(path)
        return default if child is None else (child.text or "").strip().lower() in _TRUE

    def pose(self, element: Any | None) -> Transform:
        """Return a ``<pose>`` element as a transform; the identity if missing or empty.

        Raises:
            InvalidDescriptionError: The pose is invalid.
        """
        if element is None or not (element.text or "").strip():
            return NOWHERE
        if element.get("rotation_format") == "quat_xyzw":
            x, y, z, qx, qy, qz, qw = self.numbers(element, 7)
            length = math.hypot(qx, qy, qz, qw)
            if length == 0.0:
                raise InvalidDescriptionError(f"{self.place(element)}: a rotation of length 0")
            return Transform((x, y, z), (qx / length, qy / length, qz / length, qw / length))
        if (rotation := element.get("rotation_format") or _EULER) != _EULER:
            self.leave_out(element, f"has a rotation_format '{rotation}', and is read as {_EULER}")
        if len(words := (element.text or "").split()) > _IN_POSE:
            self.leave_out(element, f"has {len(words)} numbers: the first {_IN_POSE} count")
            element.text = " ".join(words[:_IN_POSE])
        x, y, z, roll, pitch, yaw = self.numbers(element, _IN_POSE)
        if element.get("degrees") in _TRUE:
            roll, pitch, yaw = map(math.radians, (roll, pitch, yaw))
        return Transform((x, y, z), quaternion_from_rpy(roll, pitch, yaw))


def parse_sdf(path: Path, content: bytes, remarks: Remarks) -> tuple[Any, SdfFile]:
    """Parse an SDF document; return its root element, and its `SdfFile`.

    Raises:
        InvalidDescriptionError: The content is no XML, or no SDF.
    """
    root: Any = parse_file(path, content)
    if root.tag not in SDF_ROOTS:
        raise InvalidDescriptionError(f"{path}:{root.sourceline}: <{root.tag}> is no SDF")
    said = _VERSION.match(root.get("version") or "")
    version = (int(said[1]), int(said[2])) if said else _UNSAID_VERSION
    return root, SdfFile(path, version, remarks)


def relative_to(pose: Any | None) -> str:
    """Return the ``relative_to`` frame of a ``<pose>`` (``frame`` before SDF 1.7), or ""."""
    return "" if pose is None else pose.get("relative_to") or pose.get("frame") or ""
