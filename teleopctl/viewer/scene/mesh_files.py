"""Mesh files as the picture wants them: glTF with their materials, or bare triangles.

STL holds no colours, so it is drawn in the URDF's. OBJ, COLLADA, glTF and PLY bring their own
materials and textures.
"""

from __future__ import annotations

import io
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from teleopctl.tf import Vector3

_TOO_LARGE_BYTES = 200_000_000
# Their colours, if they have any, are not those of a file of materials.
_WITHOUT_MATERIAL = frozenset({".stl"})
# A missing texture makes trimesh log a traceback; one sentence of ours says it.
logging.getLogger("trimesh").setLevel(logging.CRITICAL)


class MeshError(TeleopctlError):
    """A mesh cannot be shown; the message names its file."""


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh in memory, in the units of its file's header: metres, z up.

    Attributes:
        path: The file.
        glb: The whole as binary glTF, or empty for a mesh without materials.
        vertices: Their coordinates, shape (n, 3), where there is no glTF.
        faces: Indices of triangles, shape (m, 3), likewise.
        box: Its lowest and highest corner.
    """

    path: Path
    glb: bytes
    vertices: npt.NDArray[np.float32] | None = None
    faces: npt.NDArray[np.uint32] | None = None
    box: tuple[Vector3, Vector3] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def load_mesh(uri: str, *, bare: bool = False) -> MeshFile:
    """Read a mesh.

    Args:
        uri: ``package://``, ``file://`` or a path.
        bare: Whether to leave its materials out.

    Raises:
        MeshError: There is none, or it cannot be read.
    """
    try:
        path = resolve_uri(uri)
    except TeleopctlError as error:
        raise MeshError(f"Mesh '{uri}': {error.message}") from error
    try:
        size = path.stat().st_size
    except OSError as error:
        raise MeshError(f"Mesh '{uri}': {path} cannot be read: {error.strerror}") from error
    _check_size(uri, size)
    return _read(uri, path, path, bare=bare)


def load_embedded_mesh(name: str, data: bytes, *, bare: bool = False) -> MeshFile:
    """Read a mesh that came in a message.

    Args:
        name: The name of a file, whose ending tells the format.
        data: What the file holds.
        bare: Whether to leave its materials out.

    Raises:
        MeshError: It cannot be read.
    """
    if not data:
        raise MeshError(f"Mesh '{name}' came without data")
    _check_size(name, len(data))
    return _read(name, Path(name), io.BytesIO(data), bare=bare)


def _check_size(name: str, size: int) -> None:
    if size > _TOO_LARGE_BYTES:
        raise MeshError(
            f"Mesh '{name}' has {size / 1e6:.0f} MB; at most {_TOO_LARGE_BYTES / 1e6:.0f} MB "
            "are shown"
        )


def _read(name: str, path: Path, source: Path | io.BytesIO, *, bare: bool) -> MeshFile:
    try:
        return _parse(path, source, bare=bare)
    except MeshError:
        raise
    except ImportError as error:
        raise MeshError(f"Mesh '{name}': {path.suffix} files need {error.name}") from error
    except Exception as error:
        raise MeshError(
            f"Mesh '{name}': {path} cannot be read: {type(error).__name__}: {error}"
        ) from error


def _parse(path: Path, source: Path | io.BytesIO, *, bare: bool) -> MeshFile:
    import numpy as np
    import trimesh

    # trimesh's results have no types that hold for every kind of file.
    scene: Any = trimesh.load_scene(source, file_type=path.suffix.lower().lstrip("."))
    meshes = [mesh for mesh in scene.geometry.values() if hasattr(mesh, "faces")]
    if not any(len(mesh.faces) for mesh in meshes):
        raise MeshError(f"Mesh {path} holds no triangles")
    if not all(bool(np.isfinite(mesh.vertices).all()) for mesh in meshes):
        raise MeshError(f"Mesh {path} has coordinates that are no numbers")
    (lx, ly, lz), (hx, hy, hz) = scene.bounds.tolist()
    box = (lx, ly, lz), (hx, hy, hz)
    if bare or path.suffix.lower() in _WITHOUT_MATERIAL:
        mesh: Any = scene.to_mesh()
        vertices = mesh.vertices.astype(np.float32)
        return MeshFile(path, b"", vertices, mesh.faces.astype(np.uint32), box)
    return MeshFile(path, bytes(scene.export(file_type="glb")), box=box)
