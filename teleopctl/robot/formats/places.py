"""Places of MuJoCo's, and of others, as URDF writes them."""

from __future__ import annotations

from collections.abc import Sequence

from lxml import etree

from teleopctl.tf import Transform, rpy_from_quaternion


def transform(position: Sequence[float], quaternion: Sequence[float]) -> Transform:
    """A transform of a position and a quaternion w x y z, as MuJoCo has it."""
    x, y, z = (float(value) for value in position)
    w, i, j, k = (float(value) for value in quaternion)
    return Transform((x, y, z), (i, j, k, w))


def add_origin(element: etree._Element, place: Transform) -> None:
    """Add an ``<origin>``, unless it says nothing."""
    rpy = rpy_from_quaternion(place.rotation)
    if any(place.translation) or any(rpy):
        etree.SubElement(element, "origin", xyz=numbers(*place.translation), rpy=numbers(*rpy))


def numbers(*values: float) -> str:
    """Numbers with blanks between them; what is read back is the same number."""
    # Adding zero makes -0.0 a plain one.
    return " ".join(repr(float(value) + 0.0) for value in values)
