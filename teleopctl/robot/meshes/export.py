"""Triangles as files, for those who take meshes by a URI: kept in the user's cache by content."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from teleopctl.base.folders import cache_dir

_HEADER_BYTES = 80
# How finely an ellipsoid and a cone are drawn, which URDF has no shapes for.
_SLICES = 24
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def exported_stl(vertices: npt.NDArray[np.float32], faces: npt.NDArray[np.int32]) -> Path:
    """Write triangles to a cached binary STL file, and return its path.

    Args:
        vertices: Corners, (n, 3), in metres.
        faces: Triangles as numbers of corners, (m, 3).

    Raises:
        OSError: The cache cannot be written.
    """
    triangles = np.zeros(len(faces), _TRIANGLE)
    triangles["corners"] = vertices[faces]
    content = bytes(_HEADER_BYTES) + np.uint32(len(faces)).tobytes() + triangles.tobytes()
    folder = Path(cache_dir()) / "meshes"
    file = folder / f"{hashlib.sha256(content).hexdigest()}.stl"
    if not file.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        # Others may be writing the same one.
        unfinished = file.with_suffix(f".{os.getpid()}")
        unfinished.write_bytes(content)
        unfinished.replace(file)
    return file


def unit_ball() -> Path:
    """Return an STL file of a unit sphere.

    Raises:
        OSError: The cache cannot be written.
    """
    around = np.linspace(0.0, 2.0 * np.pi, _SLICES, endpoint=False)
    down = np.linspace(0.0, np.pi, _SLICES // 2 + 1)
    theta, phi = np.meshgrid(down, around, indexing="ij")
    corners = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    rows, columns = np.meshgrid(np.arange(_SLICES // 2), np.arange(_SLICES), indexing="ij")
    beside = (columns + 1) % _SLICES
    first, second = rows * _SLICES + columns, rows * _SLICES + beside
    third, fourth = first + _SLICES, second + _SLICES
    upper = np.stack([first, third, second], axis=-1).reshape(-1, 3)
    lower = np.stack([second, third, fourth], axis=-1).reshape(-1, 3)
    faces = np.concatenate([upper[_SLICES:], lower[:-_SLICES]])
    return exported_stl(corners.reshape(-1, 3).astype(np.float32), faces.astype(np.int32))


def unit_cone() -> Path:
    """Return an STL file of a cone of radius and height 1 m, centred at the origin.

    Raises:
        OSError: The cache cannot be written.
    """
    around = np.linspace(0.0, 2.0 * np.pi, _SLICES, endpoint=False)
    rim = np.stack([np.cos(around), np.sin(around), np.full(_SLICES, -0.5)], axis=-1)
    corners = np.concatenate([rim, [[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]])
    here = np.arange(_SLICES)
    beside = (here + 1) % _SLICES
    base = np.stack([beside, here, np.full(_SLICES, _SLICES)], axis=-1)
    side = np.stack([here, beside, np.full(_SLICES, _SLICES + 1)], axis=-1)
    faces = np.concatenate([base, side])
    return exported_stl(corners.astype(np.float32), faces.astype(np.int32))
