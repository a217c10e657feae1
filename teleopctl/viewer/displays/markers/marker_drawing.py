"""Conversion of ``visualization_msgs/msg/Marker`` messages to drawings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.conversions import pose_of, vector_of
from teleopctl.viewer.displays.markers.marker_files import MESH, TRIANGLES, marker_file_key
from teleopctl.viewer.scene.drawing import (
    OWN,
    ArrowSize,
    Drawing,
    Floats,
    Text,
    TriangleMesh,
    drawable_rows,
    is_drawable,
    moved_points,
    pose_along,
)

# Any: messages, whose classes are created from definitions at run time.

ARROW, CUBE, SPHERE, CYLINDER = 0, 1, 2, 3
LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS = 4, 5, 6, 7, 8
TEXT, ARROW_STRIP = 9, 12
MOST_POINTS = 500_000
_LONGEST_TEXT = 2000
# RViz's default head length of an arrow through two points, relative to the arrow's length.
_HEAD_SHARE = 0.23
_NO_SIZE = "is invisible: its scale is 0"
_SHAPES = {CUBE: "box", SPHERE: "sphere", CYLINDER: "cylinder", CUBE_LIST: "box"}
_SHAPES[SPHERE_LIST] = "sphere"


class MarkerError(Exception):
    """Error: a marker cannot be drawn.

    The message continues a sentence: "Marker NAME has no text".
    """


def marker_pose(marker: Any) -> Transform:
    """Return a marker's pose; raise MarkerError if pose, scale or colour is not finite.

    Raises:
        MarkerError: The marker has numbers that are not finite.
    """
    pose = pose_of(marker.pose)
    scale, color = marker.scale, marker.color
    others = (scale.x, scale.y, scale.z, color.r, color.g, color.b, color.a)
    if pose is None or not is_drawable(others):
        raise MarkerError("has numbers that are not finite")
    return pose


def draw_marker(marker: Any, pose: Transform) -> tuple[Drawing, str]:
    """Return the drawing of a Marker message, and a text on parts left out or invisible, or "".

    Args:
        marker: The message, checked by `marker_pose`.
        pose: The marker's pose in the frame of the drawing.

    Returns:
        The drawing, and the reason why a part of it is invisible or left out, or an empty text.

    Raises:
        MarkerError: The marker cannot be drawn.
    """
    drawer = _DRAWERS.get(marker.type)
    if drawer is None:
        raise MarkerError(f"is of type {marker.type}, which is unknown")
    drawing = Drawing()
    fault = drawer(drawing, marker, pose)
    return drawing, fault


def _rgba(marker: Any) -> tuple[float, float, float, float]:
    color = marker.color
    rgba = (color.r, color.g, color.b, color.a)
    if min(rgba) >= 0.0 and max(rgba) <= 1.0:
        return rgba
    red, green, blue, alpha = (min(max(part, 0.0), 1.0) for part in rgba)
    return (red, green, blue, alpha)


def _invisibility(marker: Any, *sizes: float) -> str:
    """Return why a marker of one colour is invisible, or an empty text."""
    if marker.color.a <= 0.0:
        return "is invisible: its color.a is 0"
    return _NO_SIZE if 0.0 in sizes else ""


def _points(marker: Any, least: int) -> tuple[Floats, str]:
    """Return a marker's points, shape (n, 3), and a text if some are left out."""
    points = marker.points[:MOST_POINTS]
    if len(points) < least:
        raise MarkerError(f"has {len(points)} points and needs {least}")
    rows = np.array([(p.x, p.y, p.z) for p in points], np.float64).reshape(-1, 3)
    if not drawable_rows(rows).all():
        raise MarkerError("has points that are not finite")
    if len(points) < len(marker.points):
        return rows, f"has {len(marker.points)} points, of which {MOST_POINTS} are drawn"
    return rows, ""


def _colors(marker: Any, count: int) -> tuple[Floats, str]:
    """Return a colour per point, shape (count, 4), or one for all, (4,), and any fault as text."""
    said = marker.colors
    if not said:
        return np.array(_rgba(marker)), "" if marker.color.a > 0 else _invisibility(marker)
    if len(said) not in (len(marker.points), count):
        fault = f"has {len(said)} colours for {len(marker.points)} points: they are not used"
        return np.array(_rgba(marker)), fault
    rows = np.array([(c.r, c.g, c.b, c.a) for c in said[:count]], np.float64)
    if not drawable_rows(rows).all():
        raise MarkerError("has colours that are not finite")
    seen = bool((rows[:, 3] > 0).any())
    return np.clip(rows, 0.0, 1.0), "" if seen else "is invisible: the a of all its colours is 0"


def _arrow(drawing: Drawing, marker: Any, pose: Transform) -> str:
    scale = marker.scale
    if len(marker.points) >= 2:
        points, _ = _points(marker, 2)
        _arrow_between(drawing, marker, moved_points(points[:2], pose))
        return _invisibility(marker, scale.x) or (
            f"has {len(points)} points, of which an arrow uses 2" if len(points) > 2 else ""
        )
    length = abs(scale.x)
    width, height = abs(scale.y), abs(scale.z)
    size = ArrowSize(0.77 * length, width, 0.23 * length, 2 * width, height)
    drawing.arrow(pose, size, _rgba(marker))
    return _invisibility(marker, scale.x, scale.y, scale.z)


def _arrow_between(drawing: Drawing, marker: Any, ends: Floats) -> None:
    pose, length = pose_along(ends[0].tolist(), ends[1].tolist())
    head = min(abs(marker.scale.z) or _HEAD_SHARE * length, length)
    size = ArrowSize(length - head, abs(marker.scale.x), head, abs(marker.scale.y))
    drawing.arrow(pose, size, _rgba(marker))


def _arrow_strip(drawing: Drawing, marker: Any, pose: Transform) -> str:
    points, fault = _points(marker, 2)
    placed = moved_points(points, pose)
    for number in range(len(placed) - 1):
        _arrow_between(drawing, marker, placed[number : number + 2])
    return fault or _invisibility(marker, marker.scale.x)


def _solid(drawing: Drawing, marker: Any, pose: Transform) -> str:
    x, y, z = vector_of(marker.scale)
    drawing.solid(_SHAPES[marker.type], pose, (abs(x), abs(y), abs(z)), _rgba(marker))
    return _invisibility(marker, x, y, z)


def _solids(drawing: Drawing, marker: Any, pose: Transform) -> str:
    points, fault = _points(marker, 1)
    colors, wrong = _colors(marker, len(points))
    x, y, z = vector_of(marker.scale)
    size = (abs(x), abs(y), abs(z))
    drawing.solids_at(_SHAPES[marker.type], points, pose, size, colors)
    return fault or wrong or (_NO_SIZE if 0.0 in size else "")


def _lines(drawing: Drawing, marker: Any, pose: Transform) -> str:
    points, fault = _points(marker, 2)
    colors, wrong = _colors(marker, len(points))
    width = abs(marker.scale.x)
    is_strip = marker.type == LINE_STRIP
    if not is_strip and len(points) % 2:
        fault = fault or "has an odd number of points: the last is not used"
    if width and (colors[..., 3] > 0).any():
        drawing.line(moved_points(points, pose), colors, width, strip=is_strip)
    return fault or wrong or ("" if width else "is invisible: its scale.x is 0")


def _dots(drawing: Drawing, marker: Any, pose: Transform) -> str:
    points, fault = _points(marker, 1)
    colors, wrong = _colors(marker, len(points))
    if marker.scale.x:
        shown = np.broadcast_to(colors[..., 3] > 0, (len(points),))
        colors = np.broadcast_to(colors, (len(points), 4))[shown]
        drawing.dots(moved_points(points[shown], pose), colors, abs(marker.scale.x))
    return fault or wrong or ("" if marker.scale.x else "is invisible: its scale.x is 0")


def _text(drawing: Drawing, marker: Any, pose: Transform) -> str:
    if not marker.text.strip():
        raise MarkerError("has no text")
    fault = _invisibility(marker, marker.scale.z)
    if not fault:
        text = marker.text[:_LONGEST_TEXT]
        drawing.texts.append(Text(pose.translation, text, abs(marker.scale.z)))
    return fault


def _triangles(drawing: Drawing, marker: Any, pose: Transform) -> str:
    points, fault = _points(marker, 3)
    whole = len(points) // 3 * 3
    if whole < len(points):
        fault = fault or "has a number of points that is not a multiple of 3"
    # A colour for each corner, or one for each triangle.
    by_triangle = len(marker.colors) == len(marker.points) // 3 > 0
    colors, wrong = _colors(marker, whole // 3 if by_triangle else len(points))
    if colors.ndim == 2:
        colors = np.repeat(colors, 3, axis=0) if by_triangle else colors[:whole]
    texture, uv, unmapped = _texture(marker, whole)
    size = np.array(vector_of(marker.scale))
    if size.all() and (colors[..., 3] > 0).any():
        drawing.surfaces.append(TriangleMesh(points[:whole] * size, colors, pose, texture, uv))
    return fault or wrong or unmapped or ("" if size.all() else _NO_SIZE)


def _texture(marker: Any, corners: int) -> tuple[str, Floats | None, str]:
    """Return a marker's texture key, its texture coordinates, and any fault as text."""
    if not marker.texture_resource:
        return "", None, ""
    said = marker.uv_coordinates
    if len(said) != len(marker.points):
        fault = f"has {len(said)} uv_coordinates for {len(marker.points)} points: "
        return "", None, f"{fault}its texture is not used"
    uv = np.array([(one.u, one.v) for one in said[:corners]], np.float64).reshape(-1, 2)
    if not drawable_rows(uv).all():
        return "", None, "has uv_coordinates that are not finite: its texture is not used"
    return marker_file_key(marker), uv, ""


def _mesh(drawing: Drawing, marker: Any, pose: Transform) -> str:
    if not marker.mesh_resource:
        raise MarkerError("has no mesh_resource")
    color = _rgba(marker)
    own = marker.mesh_use_embedded_materials
    if own and color == (0.0, 0.0, 0.0, 0.0):
        color = OWN
    size = vector_of(marker.scale)
    drawing.solid(marker_file_key(marker), pose, size, color)
    if color is OWN:
        return _NO_SIZE if 0.0 in size else ""
    return _invisibility(marker, *size)


_DRAWERS: dict[int, Callable[[Drawing, Any, Transform], str]] = {
    ARROW: _arrow,
    CUBE: _solid,
    SPHERE: _solid,
    CYLINDER: _solid,
    LINE_STRIP: _lines,
    LINE_LIST: _lines,
    CUBE_LIST: _solids,
    SPHERE_LIST: _solids,
    POINTS: _dots,
    TEXT: _text,
    MESH: _mesh,
    TRIANGLES: _triangles,
    ARROW_STRIP: _arrow_strip,
}
