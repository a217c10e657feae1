"""Triangles as files, for those who take meshes by a URI: kept in the user's cache by content."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from teleopctl.folders import cache_dir

_HEADER_BYTES = 80
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def exported_stl(vertices: npt.NDArray[np.float32], faces: npt.NDArray[np.int32]) -> Path:
    """Return a binary STL file of some triangles; the same one for the same triangles.

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
