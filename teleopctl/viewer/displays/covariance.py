"""Drawing of a pose's covariance: an ellipsoid for the position, discs for the orientation."""

from __future__ import annotations

import math

import numpy as np

from teleopctl.tf import Quaternion, Transform
from teleopctl.viewer.displays.conversions import rgba_of
from teleopctl.viewer.displays.properties import Properties, Property
from teleopctl.viewer.scene.drawing import (
    BLUE,
    GREEN,
    RED,
    Drawing,
    Floats,
    Rgba,
    TriangleMesh,
    is_drawable,
)

COVARIANCE_PROPERTIES = (
    Property("Covariance", True, hint="Draw the covariance of the pose"),
    Property("Covariance/Position", True),
    Property("Covariance/Position/Color", (204, 51, 204)),
    Property("Covariance/Position/Alpha", 0.3, low=0.0, high=1.0),
    Property("Covariance/Position/Scale", 1.0, low=0.0, high=1000.0, hint="Standard deviations"),
    Property("Covariance/Orientation", True),
    Property("Covariance/Orientation/Frame", "Local", choices=("Local", "Fixed")),
    Property("Covariance/Orientation/Color Style", "Unique", choices=("Unique", "RGB")),
    Property("Covariance/Orientation/Color", (255, 255, 127)),
    Property("Covariance/Orientation/Alpha", 0.5, low=0.0, high=1.0),
    Property("Covariance/Orientation/Offset", 1.0, low=0.0, high=1000.0, hint="Metres"),
    Property("Covariance/Orientation/Scale", 1.0, low=0.0, high=1000.0),
)

# Smallest diameter, of an ellipsoid or disc without uncertainty in a direction.
_FLAT_M = 0.001
# Nearly a right angle, at which the disc in front of an axis becomes infinite.
_WIDEST_RAD = 1.5
_WEDGE_PARTS = 12


def draw_covariance(
    drawing: Drawing, pose: Transform, covariance: list[float], properties: Properties
) -> str:
    """Add a covariance's ellipsoid and discs to a drawing; return a fault text, empty for none.

    Args:
        drawing: Drawing in the frame of the message's header.
        pose: Pose in that frame.
        covariance: Covariance matrix, row by row, of x, y, z and the rotations about these axes.
        properties: The display's properties, among them `COVARIANCE_PROPERTIES`.
    """
    if not properties.flag("Covariance"):
        return ""
    # The roots of drawable variances are drawable too.
    if len(covariance) != 36 or not is_drawable(covariance):
        return "The covariance is not drawn: it must hold finite numbers"
    whole = np.array(covariance, np.float64).reshape(6, 6)
    whole = (whole + whole.T) / 2
    if properties.flag("Covariance/Position"):
        _draw_position(drawing, pose, whole[:3, :3], properties)
    if properties.flag("Covariance/Orientation"):
        is_flat = not whole[2, 2] and not whole[3, 3] and not whole[4, 4]
        _draw_orientation(drawing, pose, whole[3:, 3:], properties, is_flat=is_flat)
    return ""


def _draw_position(
    drawing: Drawing, pose: Transform, covariance: Floats, values: Properties
) -> None:
    if not covariance.any():
        return
    variances, axes = np.linalg.eigh(covariance)
    if np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    spread = 2 * np.sqrt(np.maximum(variances, 0.0)) * values.number("Covariance/Position/Scale")
    x, y, z = np.maximum(spread, _FLAT_M).tolist()
    color = rgba_of(
        values.color("Covariance/Position/Color"), values.number("Covariance/Position/Alpha")
    )
    here = Transform(pose.translation, _rotation_of(axes))
    drawing.solid("sphere", here, (x, y, z), color)


def _draw_orientation(
    drawing: Drawing, pose: Transform, covariance: Floats, values: Properties, *, is_flat: bool
) -> None:
    """Draw where the tips of the axes may be, at a distance from the origin."""
    group = "Covariance/Orientation"
    away, scale = values.number(f"{group}/Offset"), values.number(f"{group}/Scale")
    alpha = values.number(f"{group}/Alpha")
    unique = rgba_of(values.color(f"{group}/Color"), alpha)
    if values.text(f"{group}/Frame") == "Fixed":
        pose = Transform(pose.translation)
    if is_flat:
        half = min(scale * math.sqrt(max(covariance[2, 2], 0.0)), _WIDEST_RAD)
        if half > 0:
            drawing.surfaces.append(_wedge(pose, away, half, unique))
        return
    for axis, own in enumerate((RED, GREEN, BLUE)):
        # A small rotation about one of the other axes moves this axis's tip along the third axis.
        u, v = (axis + 1) % 3, (axis + 2) % 3
        part = np.array(
            [
                [covariance[v, v], -covariance[v, u]],
                [-covariance[u, v], covariance[u, u]],
            ]
        )
        variances, turns = np.linalg.eigh(part)
        half_angles = np.minimum(np.sqrt(np.maximum(variances, 0.0)) * scale, _WIDEST_RAD)
        if not half_angles.any():
            continue
        widths = np.maximum(2 * away * np.tan(half_angles), _FLAT_M).tolist()
        frame = np.zeros((3, 3))
        frame[[u, v], 0], frame[[u, v], 1] = turns[:, 0], turns[:, 1]
        frame[:, 2] = np.cross(frame[:, 0], frame[:, 1])
        tip = [0.0, 0.0, 0.0]
        tip[axis] = away
        place = pose @ Transform((tip[0], tip[1], tip[2]), _rotation_of(frame))
        is_unique = values.text(f"{group}/Color Style") == "Unique"
        color = unique if is_unique else (*own[:3], alpha)
        drawing.solid("cylinder", place, (widths[0], widths[1], _FLAT_M), color)


def _wedge(pose: Transform, length: float, half_angle: float, color: Rgba) -> TriangleMesh:
    angles = np.linspace(-half_angle, half_angle, _WEDGE_PARTS + 1)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1) * length
    corners = np.zeros((_WEDGE_PARTS, 3, 3))
    corners[:, 1], corners[:, 2] = rim[:-1], rim[1:]
    return TriangleMesh(corners.reshape(-1, 3), np.array(color), pose)


def _rotation_of(matrix: Floats) -> Quaternion:
    """The rotation x y z w whose columns are given, shape (3, 3)."""
    m = matrix
    # From the largest component, to avoid a division by a number near zero.
    squares = [
        1 + m[0, 0] - m[1, 1] - m[2, 2],
        1 - m[0, 0] + m[1, 1] - m[2, 2],
        1 - m[0, 0] - m[1, 1] + m[2, 2],
        1 + m[0, 0] + m[1, 1] + m[2, 2],
    ]
    largest = int(np.argmax(squares))
    half = math.sqrt(squares[largest]) / 2
    products = np.array(
        [
            [squares[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], squares[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[2], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]],
        ]
    )
    x, y, z, w = (products[largest] / (4 * half)).tolist()
    return (x, y, z, w)
