"""Mesh files, read with trimesh for the page, for physics and for `robot check` alike.

All three accept, repair or reject a mesh alike, with the same messages. Files are untrusted: the
sizes that they claim are checked before memory is allocated, triangles with invalid corners are
left out, and a missing texture is reported and left out. Coordinates are in metres: as in RViz, the
unit of a COLLADA file is applied and its up axis is ignored.
"""

from __future__ import annotations

import hashlib
import io
import json
import logging
import os
import struct
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from teleopctl.base.files import missing_content
from teleopctl.base.folders import cache_dir
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    import trimesh

# Reading takes up to fourteen times the file's size in memory for COLLADA, and eleven times for
# STL, measured with 1.3 million triangles.
_MOST_BYTES = {".dae": 60_000_000}
_MOST_BYTES_OF_OTHERS = 100_000_000
MESH_SUFFIXES = frozenset({".stl", ".obj", ".dae", ".glb", ".gltf", ".ply", ".off"})

_MOST_TRIANGLES = 5_000_000
_MOST_NODES = 20_000
# Largest coordinate, in metres: beyond it a browser's 32-bit numbers cannot separate two points.
# MuJoCo's own STL reader ends at 2**30.
_FAR_M = 1e9
# A unit outside this range in a COLLADA header is a mistake.
_SMALLEST_UNIT_M, _LARGEST_UNIT_M = 1e-6, 1e6
_STL_HEADER = 84
# The last bytes, in which a complete text STL has "endsolid"; a name may follow.
_STL_TAIL = 1000
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("color", "<u2")])
_COLUMN_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
# Resolution of spheres (1280 triangles) and cones (24 sections).
_SUBDIVISIONS, _SLICES = 3, 24

Vertices = npt.NDArray[np.float32]
Faces = npt.NDArray[np.uint32]


class InvalidMeshError(TeleopctlError):
    """Raised when a mesh file cannot be read or is rejected."""


class LoadedMesh(NamedTuple):
    """Content of a mesh file: trimesh scene, or an STL's triangles, in metres, and its faults.

    Attributes:
        scene: trimesh scene, with materials; None for an STL file, which has no materials.
        vertices: Corners of an STL file, (n, 3); empty for other formats.
        faces: Triangles of an STL file as corner indices, (m, 3); empty for other formats.
        bounds: Minimum and maximum corner of the bounding box, (2, 3).
        faults: Problems, each the rest of a sentence that starts with the file's name.
        unit_m: Length of the file's unit in metres, already applied; 1 except for COLLADA.
    """

    scene: trimesh.Scene | None
    vertices: Vertices
    faces: Faces
    bounds: npt.NDArray[np.float64]
    faults: list[str]
    unit_m: float = 1.0

    def triangles(self) -> tuple[Vertices, Faces]:
        """Return the whole mesh: corners, (n, 3), and triangles as corner indices, (m, 3)."""
        if self.scene is None:
            return self.vertices, self.faces
        whole: Any = self.scene.to_mesh()
        return whole.vertices.astype(np.float32), whole.faces.astype(np.uint32)


def read_mesh(path: Path, data: bytes | None = None) -> LoadedMesh:
    """Return the content of a mesh file, without invalid triangles.

    Args:
        path: Path of the file; its suffix is the format.
        data: Content of the file, if the file is on another machine.

    Raises:
        InvalidMeshError: The file is too large, of an unknown format, or cannot be read.
    """
    check_mesh_file(path, None if data is None else len(data))
    try:
        return _read(path, data)
    except InvalidMeshError:
        raise
    except ImportError as error:
        raise InvalidMeshError(f"cannot be read: {path.suffix} files need {error.name}") from error
    except Exception as error:  # trimesh's readers raise whatever their parsers do
        kind = type(error).__name__
        reason = " ".join(f"{kind}: {str(error).removeprefix(f'{kind}: ')}".split())[:200]
        raise InvalidMeshError(f"cannot be read: {reason}") from error


def check_mesh_file(path: Path, size: int | None = None) -> None:
    """Check that a mesh file exists, is not too large and has a known suffix; else raise.

    Args:
        path: Path of the file.
        size: Size of the file in bytes, if the file is on another machine.

    Raises:
        InvalidMeshError: The file is missing, too large or of an unknown format.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        known = ", ".join(sorted(MESH_SUFFIXES))
        raise InvalidMeshError(f"is of an unsupported format: {known}")
    if size is None:
        try:
            size, is_file = path.stat().st_size, path.is_file()
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise InvalidMeshError(f"cannot be read: {reason}") from error
        if not is_file:
            raise InvalidMeshError("is no file")
        if why := missing_content(path):
            raise InvalidMeshError(why)
    most = _MOST_BYTES.get(suffix, _MOST_BYTES_OF_OTHERS)
    if size > most:
        raise InvalidMeshError(f"has {size / 1e6:.0f} MB; at most {most / 1e6:.0f} MB are read")


def _read(path: Path, data: bytes | None) -> LoadedMesh:
    suffix = path.suffix.lower()
    raw = path.read_bytes() if data is None else data
    if suffix == ".stl":
        return _read_stl(raw)
    import trimesh

    from teleopctl.robot.mesh_textures import MeshFileResolver

    if suffix in (".glb", ".gltf"):
        _check_gltf(raw)
    # trimesh logs a traceback for a missing texture, which `faults` reports in one sentence.
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    named = MeshFileResolver(path) if data is None else None
    # Any, here and below: trimesh's results have no types that hold for every kind of file.
    # `process` would remove triangles whose corners are no numbers without a report.
    scene: Any = trimesh.load_scene(
        io.BytesIO(raw), file_type=suffix.removeprefix("."), resolver=named, process=False
    )
    if len(scene.graph.nodes_geometry) > _MOST_NODES:
        raise InvalidMeshError(f"has more than {_MOST_NODES} parts")
    meshes = [mesh for mesh in scene.geometry.values() if hasattr(mesh, "faces")]
    missing = {} if named is None else named.faults
    faults = [f"names {name}, which {why}" for name, why in missing.items()]
    if suffix == ".dae" and not any(map(_lacks_texture, meshes)):
        faults.clear()
    _check_triangles(sum(len(mesh.faces) for mesh in meshes))
    faults += _remove_invalid(meshes)
    if suffix in (".obj", ".ply", ".off"):
        # These formats may repeat the same corner.
        for mesh in meshes:
            mesh.merge_vertices()
    for name in [
        name for name, part in scene.geometry.items() if not len(getattr(part, "faces", ()))
    ]:
        scene.delete_geometry(name)
    unit_m = _collada_unit_m(mesh.metadata for mesh in meshes) if suffix == ".dae" else 1.0
    if unit_m != 1.0:
        scene.apply_scale(unit_m)
    none = np.empty((0, 3))
    corners, triangles = none.astype(np.float32), none.astype(np.uint32)
    return LoadedMesh(scene, corners, triangles, np.asarray(scene.bounds), faults, unit_m)


def _collada_unit_m(metadata: Iterable[Mapping[str, object]]) -> float:
    """Return how many metres the unit of a COLLADA file has; 1 where its header makes no sense.

    trimesh returns the unit as metadata, such as ``{"units": "0.001 * meter"}``, but does not
    apply it.
    """
    words = next((str(one.get("units", "")) for one in metadata), "").split()
    try:
        unit_m = float(words[0]) if len(words) == 3 else 1.0
    except ValueError:
        return 1.0
    return unit_m if _SMALLEST_UNIT_M < unit_m < _LARGEST_UNIT_M else 1.0


def _valid_rows(rows: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    # A comparison with NaN is false.
    possible: npt.NDArray[np.bool_] = np.all(np.abs(rows) < _FAR_M, axis=1)
    return possible


def _read_stl(raw: bytes) -> LoadedMesh:
    faults: list[str] = []
    room = (len(raw) - _STL_HEADER) // _STL_TRIANGLE.itemsize
    claimed = int.from_bytes(raw[_STL_HEADER - 4 : _STL_HEADER], "little") if room >= 0 else -1
    # Binary files may begin with "solid" as well: a file is text only if, in addition, its length
    # does not match its triangle count.
    if room < 0 or (room != claimed and raw.lstrip()[:5].lower() == b"solid"):
        corners = _corners_of_text(raw)
        if b"endsolid" not in raw[-_STL_TAIL:].lower():
            faults.append(f"ends after {len(corners) // 3} triangles without an 'endsolid'")
    else:
        if room < claimed:
            faults.append(f"ends after {room} of the {claimed} triangles that it claims")
        count = min(claimed, room)
        _check_triangles(count)
        triangles = np.frombuffer(raw, _STL_TRIANGLE, count, _STL_HEADER)
        corners = np.ascontiguousarray(triangles["corners"], np.float32).reshape(-1, 3)
    good: npt.NDArray[np.bool_] = np.all(_valid_rows(corners).reshape(-1, 3), axis=1)
    if not good.all():
        faults.append(_left_out(int(len(good) - good.sum())))
        corners = corners.reshape(-1, 3, 3)[good].reshape(-1, 3)
    _check_triangles(len(corners) // 3)
    vertices, faces = _joined(corners)
    bounds = np.array((vertices.min(axis=0), vertices.max(axis=0)), float)
    return LoadedMesh(None, vertices, faces, bounds, faults)


def _corners_of_text(raw: bytes) -> Vertices:
    """Return the corners of a text STL's complete triangles: three numbers per ``vertex``."""
    numbers = [piece.split(None, 3)[:3] for piece in raw.lower().split(b"vertex")[1:]]
    while numbers and (len(numbers) % 3 or len(numbers[-1]) < 3):
        numbers.pop()
    corners = np.fromiter((float(word) for row in numbers for word in row), np.float32)
    return corners.reshape(-1, 3)


def _joined(corners: Vertices) -> tuple[Vertices, Faces]:
    """Return corners without duplicates, and triangles as indices: a third of the bytes.

    Corners are matched by a hash of their bits: 2.8 s for 1.3 million triangles, where comparing
    them took 10.4 s.
    """
    # Adding 0 turns -0 into 0, which has other bits.
    bits = (corners + np.float32(0.0)).view(np.uint32).astype(np.uint64)
    bits *= _COLUMN_FACTORS
    bits ^= bits >> np.uint64(29)
    keys = (bits[:, 0] * np.uint64(3)) ^ (bits[:, 1] * np.uint64(5)) ^ (bits[:, 2] * np.uint64(7))
    _, first, numbers = np.unique(keys, return_index=True, return_inverse=True)
    # The order of the file compresses better than that of the hash.
    order = np.argsort(first)
    rank = np.empty(len(order), np.uint32)
    rank[order] = np.arange(len(order), dtype=np.uint32)
    return corners[first[order]], rank[numbers].reshape(-1, 3)


def _check_triangles(count: int) -> None:
    if not count:
        raise InvalidMeshError("holds no triangles")
    if count > _MOST_TRIANGLES:
        raise InvalidMeshError(f"holds {count} triangles; at most {_MOST_TRIANGLES} are read")


def _remove_invalid(meshes: Iterable[Any]) -> list[str]:
    """Remove triangles with invalid corners; return a fault about their number, if any."""
    count = left = 0
    for mesh in meshes:
        good = _valid_rows(np.asarray(mesh.vertices))
        if not good.all():
            keep = good[mesh.faces].all(axis=1)
            count += int(len(keep) - keep.sum())
            mesh.update_faces(keep)
            mesh.remove_unreferenced_vertices()
        left += len(mesh.faces)
    if not left:
        raise InvalidMeshError("has coordinates that are not numbers")
    return [_left_out(count)] if count else []


def _left_out(count: int) -> str:
    lost = "1 triangle is" if count == 1 else f"{count} triangles are"
    return f"has coordinates that are not numbers; {lost} left out"


def _lacks_texture(mesh: Any) -> bool:
    """Return whether a mesh of a COLLADA file has texture coordinates but no texture.

    Other missing files, such as bump maps, do not matter: RViz does not show them either.
    """
    visual = mesh.visual
    return (
        getattr(visual, "uv", None) is not None
        and getattr(visual.material, "baseColorTexture", None) is None
    )


def _check_gltf(raw: bytes) -> None:
    """Check that a glTF file claims no more numbers than it has: trimesh would allocate them."""
    if raw[:4] == b"glTF":
        if len(raw) < 20:
            raise InvalidMeshError("ends within its header")
        (length,) = struct.unpack_from("<I", raw, 12)
        raw = raw[20 : 20 + length]
    described = json.loads(raw)
    views = described.get("bufferViews", [])
    total = 0
    for accessor in described.get("accessors", []):
        count = int(accessor.get("count", 0))
        view = accessor.get("bufferView")
        room = int(views[view].get("byteLength", 0)) if view is not None else 0
        if count < 0 or (view is not None and count > room):
            raise InvalidMeshError(f"claims {count} numbers in {room} bytes")
        total += count
    if total > 6 * _MOST_TRIANGLES:
        raise InvalidMeshError(f"claims {total} numbers")


def cached_stl(vertices: npt.NDArray[np.float32], faces: npt.NDArray[np.int32]) -> Path:
    """Write triangles to a binary STL file in the user's cache folder; return the file's path.

    The file is named by a hash of its content. trimesh could write the same file, but importing it
    takes ten times as long as reading a small MJCF file, all of whose meshes may be converted.

    Args:
        vertices: Corners, (n, 3), in metres.
        faces: Triangles as indices of corners, (m, 3).

    Raises:
        OSError: The cache folder cannot be written.
    """
    triangles = np.zeros(len(faces), _STL_TRIANGLE)
    triangles["corners"] = vertices[faces]
    count = np.uint32(len(faces)).tobytes()
    content = bytes(_STL_HEADER - len(count)) + count + triangles.tobytes()
    folder = Path(cache_dir()) / "meshes"
    file = folder / f"{hashlib.sha256(content).hexdigest()}.stl"
    if not file.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        # Another process may be writing the same file.
        unfinished = file.with_suffix(f".{os.getpid()}")
        unfinished.write_bytes(content)
        unfinished.replace(file)
    return file


def unit_sphere_stl() -> Path:
    """Return the path of an STL file of a sphere of radius 1 m, for ellipsoids, which URDF lacks.

    Raises:
        OSError: The cache folder cannot be written.
    """
    from trimesh.creation import icosphere

    return _primitive_stl(icosphere(subdivisions=_SUBDIVISIONS))


def unit_cone_stl() -> Path:
    """Return the path of an STL file of a cone of radius and height 1 m, centred at the origin.

    Raises:
        OSError: The cache folder cannot be written.
    """
    from trimesh.creation import cone

    mesh = cone(radius=1.0, height=1.0, sections=_SLICES)
    mesh.apply_translation([0.0, 0.0, -0.5])  # the base of trimesh's cone is at the origin
    return _primitive_stl(mesh)


def _primitive_stl(mesh: trimesh.Trimesh) -> Path:
    return cached_stl(mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32))
