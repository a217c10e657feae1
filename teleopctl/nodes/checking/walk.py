"""The robots' files in folders: not what they include, and not other people's XML."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from lxml import etree

_SUFFIXES = (".urdf", ".xacro", ".xml", ".sdf")
# Worlds, macros and other documents have other roots, or no links of their own.
_ROOTS = ("robot", "mujoco", "sdf")
_XACRO = "{http://www.ros.org/wiki/xacro}"
_MACROS = frozenset(f"{_XACRO}{tag}" for tag in ("macro", "property", "arg"))


def robots_in(places: Iterable[Path]) -> Iterator[Path]:
    """Return the robot files in folders, sorted.

    A xacro file without a name is a part of others, and so is what another MJCF file includes.

    Args:
        places: Files, which count whatever is in them, and folders.
    """
    for place in places:
        if place.is_file():
            yield place
            continue
        files = [file for file in sorted(place.rglob("*")) if file.suffix in _SUFFIXES]
        roots = {file: root for file in files if (root := _root(file)) is not None}
        included = {
            (file.parent / (element.get("file") or "")).resolve()
            for file, root in roots.items()
            for element in root.iter("include")
        }
        for file, root in roots.items():
            if file.resolve() not in included and _is_robot(root):
                yield file


def _root(file: Path) -> etree._Element | None:
    parser = etree.XMLParser(resolve_entities=False, remove_comments=True, remove_pis=True)
    try:
        root = etree.parse(str(file), parser).getroot()
    except (OSError, etree.XMLSyntaxError):
        return None
    return root if root.tag in _ROOTS else None


def _is_robot(root: etree._Element) -> bool:
    if root.tag == "robot":
        has_parts = any(str(child.tag) not in _MACROS for child in root)
        return bool(root.get("name")) and has_parts
    if root.tag == "sdf":
        return root.find("model") is not None
    return root.find(".//body") is not None or root.find("include") is not None
