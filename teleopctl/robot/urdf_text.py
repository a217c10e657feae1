"""Poses, numbers and topic names as texts of URDF and ROS, for converters to URDF."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from lxml import etree

from teleopctl.tf import Transform, quaternion_from_axis_angle, rpy_from_quaternion


def transform(position: Sequence[float], quaternion: Sequence[float]) -> Transform:
    """Return the transform of a position and a MuJoCo quaternion (w x y z)."""
    x, y, z = (float(value) for value in position)
    w, i, j, k = (float(value) for value in quaternion)
    return Transform((x, y, z), (i, j, k, w))


def rotation_from_z(direction: Sequence[float]) -> Transform:
    """Return the shortest rotation that turns z into a direction; the identity for length 0."""
    x, y, z = direction
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return Transform()
    angle = math.acos(max(-1.0, min(1.0, z / length)))
    axis = (-y, x, 0.0) if x or y else (1.0, 0.0, 0.0)
    flat = math.hypot(*axis[:2])
    turn = quaternion_from_axis_angle((axis[0] / flat, axis[1] / flat, 0.0), angle)
    return Transform(rotation=turn)


def add_origin(element: etree._Element, place: Transform) -> None:
    """Add an ``<origin>`` to a URDF element, unless the transform is the identity."""
    rpy = rpy_from_quaternion(place.rotation)
    if any(place.translation) or any(rpy):
        etree.SubElement(element, "origin", xyz=numbers(*place.translation), rpy=numbers(*rpy))


def pose_text(place: Transform) -> str:
    """Return a transform as SDF pose text: "x y z roll pitch yaw"."""
    return numbers(*place.translation, *rpy_from_quaternion(place.rotation))


def topic_name(name: str) -> str:
    """Return a name as a valid relative topic name: other characters become underscores."""
    parts = (re.sub(r"\W", "_", part, flags=re.ASCII) for part in name.split("/") if part)
    return "/".join(f"_{part}" if part[0].isdigit() else part for part in parts)


def numbers(*values: float) -> str:
    """Return numbers as text separated by blanks, with full precision."""
    # Adding zero turns -0.0 into 0.0.
    return " ".join(repr(float(value) + 0.0) for value in values)
