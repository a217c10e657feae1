"""Mesh files as the picture wants them: glTF with their materials, or bare triangles.

STL holds no colours, so it is drawn in the URDF's. OBJ, COLLADA, glTF and PLY bring their own
materials and textures. As in RViz, a COLLADA file's unit counts and its upward axis does not.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.errors import TeleopctlError
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from teleopctl.tf import Vector3


class MeshError(TeleopctlError):
    """A mesh cannot be shown; the message names its file."""


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A loaded mesh, in metres.

    Attributes:
        path: The file.
        glb: The whole as binary glTF; empty for a mesh without materials.
        vertices: Their coordinates, shape (n, 3), where there is no glTF.
        faces: Indices of triangles, shape (m, 3), likewise.
        box: Its lowest and highest corner.
        faults: What is not shown of it, one sentence each, that name the file.
        stamp: The file's size and time when it was read; see `stamp_of_file`.
    """

    path: Path
    glb: bytes
    vertices: npt.NDArray[np.float32] | None = None
    faces: npt.NDArray[np.uint32] | None = None
    box: tuple[Vector3, Vector3] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    faults: tuple[str, ...] = ()
    stamp: tuple[int, int] = (0, 0)


def load_mesh(uri: str, folder: Path | None = None, *, bare: bool = False) -> MeshFile:
    """Load a mesh file.

    Args:
        uri: ``package://``, ``file://`` or a path.
        folder: Where the description that names it is from; see `file_of`.
        bare: Whether to leave its materials out.

    Raises:
        MeshError: There is none, or it cannot be read.
    """
    try:
        path = file_of(uri, folder)
    except (TeleopctlError, ValueError, RuntimeError) as error:
        raise MeshError(f"Mesh '{uri}': {error}") from error
    named = f"Mesh {path}" if str(path) == uri else f"Mesh '{uri}': {path}"
    stamp = (0, 0)
    with contextlib.suppress(OSError, ValueError):  # the reader says what is wrong
        stamp = stamp_of_file(path)
    return _read(named, path, None, stamp, bare=bare)


def load_embedded_mesh(name: str, data: bytes, *, bare: bool = False) -> MeshFile:
    """Load a mesh that came in a message.

    Args:
        name: The name of a file, whose ending tells the format.
        data: What the file holds.
        bare: Whether to leave its materials out.

    Raises:
        MeshError: It cannot be read.
    """
    if not data:
        raise MeshError(f"Mesh '{name}' came without data")
    return _read(f"Mesh '{name}'", Path(name), data, (len(data), 0), bare=bare)


def _read(
    named: str, path: Path, data: bytes | None, stamp: tuple[int, int], *, bare: bool
) -> MeshFile:
    from teleopctl.viewer.scene.mesh_reading import drawn_mesh

    try:
        content = drawn_mesh(path, data, bare=bare)
    except TeleopctlError as error:
        raise MeshError(f"{named} {error.message}") from error
    except Exception as error:
        # trimesh writes what it has read, materials and all, and may stumble over it.
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise MeshError(f"{named} cannot be read: {reason}") from error
    faults = tuple(f"{named} {fault}" for fault in content.faults)
    return MeshFile(path, content.glb, content.vertices, content.faces, content.box, faults, stamp)


def packed(mesh: MeshFile) -> MeshFile:
    """Return a mesh of bare triangles as glTF, whose colour `dressed` sets."""
    if mesh.glb or mesh.vertices is None or mesh.faces is None:
        return mesh
    from teleopctl.viewer.scene.mesh_reading import bare_glb

    return replace(mesh, glb=bare_glb(mesh.vertices, mesh.faces), vertices=None, faces=None)


def file_of(uri: str, folder: Path | None = None) -> Path:
    """Return the path of a mesh URI.

    Args:
        uri: ``package://``, ``file://`` or a path.
        folder: Where the description is from. What is sent over the wire is from nowhere, so that
            RViz finds no relative path; many descriptions of small robots have them.

    Raises:
        NotFoundError: Its package is unknown.
    """
    path = resolve_uri(uri)
    if folder is None or path.is_absolute() or path.exists():
        return path
    return folder / path


def stamp_of_file(path: Path) -> tuple[int, int]:
    """Return a file's size and modification time, which change when the file does.

    Raises:
        OSError: It is not there.
    """
    status = path.stat()
    return status.st_size, status.st_mtime_ns
