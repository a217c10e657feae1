"""Robot files of any format (URDF, xacro, SDF, MJCF), read as URDF.

All robot files are read by this module, so that each format works everywhere.
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

# Text that xacro would change, or that needs a full XML parser (DOCTYPE, another encoding).
_EXPANDED = re.compile(r"xacro|\$[({]|<!DOCTYPE|encoding\s*=\s*.(?!utf-8)", re.IGNORECASE)

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)

# The root element of SDF was <gazebo> until version 1.2.
_KINDS: dict[str, ModelKind] = {"robot": "urdf", "mujoco": "mjcf", "sdf": "sdf", "gazebo": "sdf"}


def model_kind(path: Path | str) -> ModelKind:
    """Return a robot file's format by its root element: "sdf", "mjcf", else "urdf", also for xacro.

    An unreadable file, or one with another root, counts as URDF, whose reader reports the fault.
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
    """Read a robot file of any format; return URDF text and all files read as `ExpandedXacro`.

    Args:
        path: Path of the file: URDF, xacro, SDF or MJCF.
        mappings: Values of a xacro file's ``<xacro:arg>`` by name; unused for other formats.
        safe: See `expand_xacro`.
        places: Whether to record the source file and line of each line.

    Returns:
        The URDF. The URDF of an MJCF file names that file (`RobotDescription.mjcf`), which
        simulators use instead of the URDF.

    Raises:
        InvalidDescriptionError: When the file cannot be read.
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
    """Return the text of a URDF file without xacro, which keeps its lines.

    None for a file with xacro, and for invalid XML, which xacro reports.
    """
    try:
        text = path.read_text(encoding="utf-8")
        # Files that were expanded by xacro say so in a comment.
        if _EXPANDED.search(_COMMENT.sub("", text)):
            return None
        etree.fromstring(text.encode(), etree.XMLParser(encoding="utf-8", resolve_entities=False))
    except (OSError, UnicodeDecodeError, etree.XMLSyntaxError):
        return None
    return text
