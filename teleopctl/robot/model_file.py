"""A robot's file of any kind: told apart by its root element, and read as URDF.

Whoever takes a robot's file takes it from here, so that each kind works wherever one does.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from lxml import etree

from teleopctl.packages import include_package_of
from teleopctl.robot.xacro.expansion import ExpandedXacro, read_xacro

ModelKind = Literal["urdf", "mjcf", "sdf"]

# What xacro does something with, and what only a whole reader of XML gets right.
_EXPANDED = re.compile(r"xacro|\$[({]|<!DOCTYPE|encoding\s*=\s*.(?!utf-8)", re.IGNORECASE)

# SDF was <gazebo> until 1.2.
_KINDS: dict[str, ModelKind] = {"robot": "urdf", "mujoco": "mjcf", "sdf": "sdf", "gazebo": "sdf"}


def model_kind(path: Path | str) -> ModelKind:
    """Return the kind of a robot's file by its root element.

    What cannot be read, and what has another root, counts as URDF: its reader says what is wrong.
    """
    try:
        with Path(path).open("rb") as file:
            events = etree.iterparse(
                file,
                events=("start",),
                resolve_entities=False,
                remove_comments=True,
                recover=True,
            )
            _, root = next(events)
    except (OSError, etree.XMLSyntaxError, StopIteration):
        return "urdf"
    return _KINDS.get(str(root.tag), "urdf")


def read_model(
    path: Path | str,
    mappings: Mapping[str, str] | None = None,
    *,
    safe: bool | None = None,
    places: bool = False,
) -> ExpandedXacro:
    """Read a robot's file of any kind, and the files that it includes.

    Args:
        path: URDF, xacro, SDF or MJCF, told apart by the root element.
        mappings: Values of a xacro file's ``<xacro:arg>`` by name; the others take none.
        safe: See `expand_xacro`.
        places: Whether to note where each line was written.

    Returns:
        URDF as text. That of an MJCF file says which file it is of (`RobotDescription.mjcf`),
        which is what a simulator simulates.

    Raises:
        InvalidDescriptionError: When it cannot be read.
    """
    kind = model_kind(path)
    if kind == "mjcf":
        from teleopctl.robot.mjcf.mjcf_as_urdf import mjcf_as_urdf

        return mjcf_as_urdf(Path(path))
    if kind == "sdf":
        from teleopctl.robot.sdf.sdf_as_urdf import sdf_as_urdf

        return sdf_as_urdf(Path(path))
    plain = _plain_urdf(Path(path))
    if plain is not None:
        include_package_of(Path(path))
        return ExpandedXacro(plain, (Path(path).absolute(),))
    return read_xacro(path, mappings, safe=safe, places=places)


def _plain_urdf(path: Path) -> str | None:
    """The text of a URDF file in which nothing is to be expanded, so that its lines stay its own.

    None for any other, and for what is not XML: xacro says what is wrong.
    """
    try:
        text = path.read_text(encoding="utf-8")
        if _EXPANDED.search(text):
            return None
        etree.fromstring(text.encode(), etree.XMLParser(encoding="utf-8", resolve_entities=False))
    except (OSError, UnicodeDecodeError, etree.XMLSyntaxError):
        return None
    return text
