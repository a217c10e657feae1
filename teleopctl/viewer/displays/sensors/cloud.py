"""Conversion of ``PointCloud2``, ``PointCloud`` and ``LaserScan`` messages to arrays of points."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import as_numpy
from teleopctl.tf import Transform

# The numbers of sensor_msgs/msg/PointField.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
# Farther points are not visible, and may become infinite in a browser's floats.
_FARTHEST_M = 1e6

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float32]


class CloudError(TeleopctlError):
    """Error: a message has no valid points; the text says why."""


@dataclass(frozen=True, slots=True)
class Cloud:
    """Points of a cloud or scan message, with further values per point, such as intensity.

    Attributes:
        points: Coordinates in the message's frame, (n, 3), in metres.
        total: Number of points in the message, including those left out.
        channels: Values of each channel, (n,), by name.
        spacing: Distance of neighbouring points in metres; 0 if unknown.
    """

    points: Floats
    total: int
    channels: dict[str, Array] = field(default_factory=dict)
    spacing: float = 0.0


# Any: a PointCloud2 message.
def read_cloud(message: Any, max_points: int) -> Cloud:
    """Return a PointCloud2's finite points as a `Cloud`, every n-th if more than ``max_points``.

    Args:
        message: A ``sensor_msgs/msg/PointCloud2``.
        max_points: Largest number of points to return; from a larger cloud every n-th is returned.

    Raises:
        CloudError: The message has no fields x, y, z, or its sizes contradict each other.
    """
    step, data = message.point_step, as_numpy(message, "data")
    if not message.width or not message.height or not data.size:
        return Cloud(np.empty((0, 3), np.float32), 0)
    row = message.row_step or message.width * step
    if not step or row < message.width * step:
        raise CloudError(
            f"Rows of {row} bytes do not hold {message.width} points of {step} bytes each"
        )
    # The last row may lack the padding.
    rows = min((data.size + row - message.width * step) // row, message.height)
    if rows < 1:
        raise CloudError(f"{data.size} bytes are not {message.width} points of {step} bytes each")
    every = -(-rows * message.width // max_points)
    order = ">" if message.is_bigendian else "<"
    channels: dict[str, Array] = {}
    for one in message.fields:
        dtype = np.dtype(order + _TYPES.get(one.datatype, "V0"))
        if dtype.itemsize and one.offset + dtype.itemsize <= step:
            values: Array = np.ndarray(
                (rows, message.width), dtype, data.data, one.offset, (row, step)
            )
            chosen = values.reshape(-1) if row == message.width * step else values.ravel()
            channels.setdefault(one.name, chosen[::every])
    missing = [name for name in "xyz" if name not in channels]
    if missing:
        raise CloudError(f"The cloud has no field {', '.join(map(repr, missing))}")
    with np.errstate(over="ignore"):
        points = np.stack([channels.pop(name) for name in "xyz"], -1).astype(np.float32)
    total = message.width * message.height
    return masked_cloud(points, total, channels, drawable_mask(points))


# Any: a PointCloud message.
def read_legacy_cloud(message: Any, max_points: int) -> Cloud:
    """Return a PointCloud's finite points as a `Cloud`, every n-th if more than ``max_points``.

    Args:
        message: A ``sensor_msgs/msg/PointCloud``.
        max_points: See `read_cloud`.
    """
    total = len(message.points)
    every = max(-(-total // max_points), 1)
    rows = [(one.x, one.y, one.z) for one in message.points[::every]]
    points = np.array(rows, np.float32).reshape(-1, 3)
    channels = {
        one.name: np.asarray(one.values, np.float32)[::every]
        for one in message.channels
        if len(one.values) == total
    }
    return masked_cloud(points, total, channels, drawable_mask(points))


# Any: a LaserScan message.
def read_scan(message: Any, motion: Transform | None = None) -> Cloud:
    """Return the points of a LaserScan's valid ranges, corrected by the scanner's ``motion``.

    Args:
        message: A ``sensor_msgs/msg/LaserScan``.
        motion: Pose of the scanner at the end of the scan, in its frame at the start, by which
            the points are corrected; None for a scanner at rest.
    """
    ranges = np.frombuffer(message.ranges, np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        across = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], -1)
        points = ranges[:, None] * across
        if motion is not None and len(points) > 1:
            points = _swept(points, motion)
        hit = (ranges >= message.range_min) & (ranges <= message.range_max) & drawable_mask(points)
        points = points.astype(np.float32)
    intensities = np.frombuffer(message.intensities, np.float32)
    channels = {"intensity": intensities} if len(intensities) == len(ranges) else {}
    return masked_cloud(points, len(ranges), channels, hit)


def drawable_mask(points: Array) -> npt.NDArray[np.bool_]:
    """Return a mask, (n,), of the points, (n, 3), with finite coordinates within 1000 km."""
    return np.asarray((np.abs(points) < _FARTHEST_M).all(axis=-1))


def masked_cloud(points: Floats, total: int, channels: dict[str, Array], mask: Array) -> Cloud:
    """Return a `Cloud` of those points and channel values for which ``mask`` is true.

    Args:
        points: All points, (n, 3).
        total: See `Cloud`.
        channels: Values of each channel, (n,), by name.
        mask: Whether each point is kept, (n,).
    """
    if mask.all():
        return Cloud(points, total, channels)
    return Cloud(points[mask], total, {name: values[mask] for name, values in channels.items()})


def _swept(points: Array, motion: Transform) -> Array:
    """Return points corrected by the scanner's motion, which is even from start to end."""
    part = np.linspace(0.0, 1.0, len(points))[:, None]
    x, y, z, w = motion.rotation if motion.rotation[3] >= 0.0 else [-one for one in motion.rotation]
    # Normalised linear interpolation, which is accurate for the small rotation during a scan.
    axis, real = part * np.array([x, y, z]), 1.0 + part * (w - 1.0)
    length = np.sqrt((axis**2).sum(axis=-1, keepdims=True) + real**2)
    axis, real = axis / length, real / length
    twice = 2.0 * np.cross(axis, points)
    turned: Array = points + real * twice + np.cross(axis, twice)
    moved: Array = turned + part * np.array(motion.translation)
    return moved


def has_moved(motion: Transform) -> bool:
    """Return whether a scanner's motion during a scan is more than 1 mm or 1 mrad."""
    return math.hypot(*motion.translation) > 1e-3 or abs(motion.rotation[3]) < math.cos(5e-4)
