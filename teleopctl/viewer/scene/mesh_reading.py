"""Reads mesh files with trimesh, as far as they can be shown.

A file is from anywhere: what it claims is checked before memory is taken for it, triangles with
impossible corners are left out, and a missing texture costs the texture alone.
"""

from __future__ import annotations

import io
import json
import logging
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import trimesh

from teleopctl.base.text_file import absence
from teleopctl.errors import TeleopctlError
from teleopctl.robot import collada_unit_m
from teleopctl.tf import Vector3
from teleopctl.viewer.scene.drawing import drawable_rows
from teleopctl.viewer.scene.glb import furnished
from teleopctl.viewer.scene.srgb import linear_light
from teleopctl.viewer.scene.textures import Neighbours, fit_textures

# A missing texture makes trimesh log a traceback; one sentence of ours says it.
logging.getLogger("trimesh").setLevel(logging.CRITICAL)

_MOST_TRIANGLES = 5_000_000
_MOST_NODES = 20_000
_STL_HEADER = 84
# Where a text says that it is complete; a name may follow.
_STL_TAIL = 1000
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("color", "<u2")])
_COLUMN_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)

Vertices = npt.NDArray[np.float32]
Faces = npt.NDArray[np.uint32]


class _Unusable(TeleopctlError):
    """What follows the file's name in the sentence about it."""


class Content(NamedTuple):
    """What a file holds; see `MeshFile`.

    Attributes:
        glb: All as binary glTF.
        vertices: Their coordinates, where there is no glTF.
        faces: Indices of triangles, likewise.
        box: The lowest and highest corner.
        faults: What is not shown, each as what follows the file's name in a sentence.
    """

    glb: bytes
    vertices: Vertices | None
    faces: Faces | None
    box: tuple[Vector3, Vector3]
    faults: list[str]


def read_mesh(path: Path, data: bytes | None = None, *, bare: bool = False) -> Content:
    """Read a file.

    Args:
        path: Its name.
        data: What it holds, where it is nowhere on this machine.
        bare: Whether to leave its materials out.

    Raises:
        TeleopctlError: It cannot be shown; the message is what follows the file's name.
        Exception: Whatever trimesh's readers raise.
    """
    suffix = path.suffix.lower()
    if data is None and (why := absence(path)):
        raise _Unusable(why)
    raw = path.read_bytes() if data is None else data
    if suffix == ".stl":
        return _read_stl(raw)
    is_gltf = suffix in (".glb", ".gltf")
    if is_gltf:
        _check_gltf(raw)
    neighbours = Neighbours(path) if data is None else None
    # Any, here and below: trimesh's results have no types that hold for every kind of file. Left
    # to itself it takes triangles without a word whose corners are no numbers.
    scene: Any = trimesh.load_scene(
        io.BytesIO(raw), file_type=suffix.removeprefix("."), resolver=neighbours, process=False
    )
    if len(scene.graph.nodes_geometry) > _MOST_NODES:
        raise _Unusable(f"has more than {_MOST_NODES} parts")
    meshes = [mesh for mesh in scene.geometry.values() if hasattr(mesh, "faces")]
    missing = {} if neighbours is None else neighbours.faults
    faults = [f"names {name}, which {why}" for name, why in missing.items()]
    if suffix == ".dae" and not any(map(_lacks_picture, meshes)):
        faults.clear()
    _check_triangles(sum(len(mesh.faces) for mesh in meshes))
    faults += _without_impossible(meshes)
    if suffix in (".obj", ".ply"):
        # Their formats have or allow corners that are the same place.
        for mesh in meshes:
            mesh.merge_vertices()
    for name in [
        name for name, part in scene.geometry.items() if not len(getattr(part, "faces", ()))
    ]:
        scene.delete_geometry(name)
    if suffix == ".dae" and (unit := collada_unit_m(mesh.metadata for mesh in meshes)) != 1.0:
        scene.apply_scale(unit)
    box = _box(scene.bounds)
    if bare:
        whole: Any = scene.to_mesh()
        vertices = whole.vertices.astype(np.float32)
        return Content(b"", vertices, whole.faces.astype(np.uint32), box, faults)
    faults += fit_textures(meshes)
    for mesh in meshes:
        _forget_invented(mesh)
        if not is_gltf:
            _paint_in_light(mesh)
    written = bytes(scene.export(file_type="glb"))
    glb = furnished(written, is_gltf=is_gltf)
    return Content(glb, None, None, box, faults)


def bare_glb(vertices: Vertices, faces: Faces) -> bytes:
    """Triangles as binary glTF, without normals: so they are shown as flat as they are."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    written: Any = mesh.export(file_type="glb", include_normals=False)
    return furnished(bytes(written), is_gltf=False)


def _box(bounds: npt.NDArray[np.floating[Any]]) -> tuple[Vector3, Vector3]:
    (lx, ly, lz), (hx, hy, hz) = bounds.tolist()
    return (lx, ly, lz), (hx, hy, hz)


def _read_stl(raw: bytes) -> Content:
    faults: list[str] = []
    room = (len(raw) - _STL_HEADER) // _STL_TRIANGLE.itemsize
    claimed = int.from_bytes(raw[_STL_HEADER - 4 : _STL_HEADER], "little") if room >= 0 else -1
    # Binary files may begin with "solid" as well; only those that say so and whose length does not
    # fit are text.
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
    good: npt.NDArray[np.bool_] = np.all(drawable_rows(corners).reshape(-1, 3), axis=1)
    if not good.all():
        faults.append(_left_out(int(len(good) - good.sum())))
        corners = corners.reshape(-1, 3, 3)[good].reshape(-1, 3)
    _check_triangles(len(corners) // 3)
    vertices, faces = _joined(corners)
    box = _box(np.array((vertices.min(axis=0), vertices.max(axis=0))))
    return Content(b"", vertices, faces, box, faults)


def _corners_of_text(raw: bytes) -> Vertices:
    """The corners of a text STL's whole triangles: three numbers after each ``vertex``."""
    numbers = [piece.split(None, 3)[:3] for piece in raw.lower().split(b"vertex")[1:]]
    while numbers and (len(numbers) % 3 or len(numbers[-1]) < 3):
        numbers.pop()
    corners = np.fromiter((float(word) for row in numbers for word in row), np.float32)
    return corners.reshape(-1, 3)


def _joined(corners: Vertices) -> tuple[Vertices, Faces]:
    """Number equal corners once: a third of the bytes to send.

    By a hash of their bits: of 1.3 million triangles in 2.8 s, where comparing them took 10.4 s.
    """
    # -0 and 0 are the same place.
    bits = (corners + np.float32(0.0)).view(np.uint32).astype(np.uint64)
    bits *= _COLUMN_FACTORS
    bits ^= bits >> np.uint64(29)
    keys = (bits[:, 0] * np.uint64(3)) ^ (bits[:, 1] * np.uint64(5)) ^ (bits[:, 2] * np.uint64(7))
    _, first, numbers = np.unique(keys, return_index=True, return_inverse=True)
    # In the order of the file, which compresses better than that of the hash.
    order = np.argsort(first)
    rank = np.empty(len(order), np.uint32)
    rank[order] = np.arange(len(order), dtype=np.uint32)
    return corners[first[order]], rank[numbers].reshape(-1, 3)


def _check_triangles(count: int) -> None:
    if not count:
        raise _Unusable("holds no triangles")
    if count > _MOST_TRIANGLES:
        raise _Unusable(f"holds {count} triangles; at most {_MOST_TRIANGLES} are shown")


def _without_impossible(meshes: Iterable[Any]) -> list[str]:
    """Take out triangles that cannot be drawn."""
    count = left = 0
    for mesh in meshes:
        good = drawable_rows(np.asarray(mesh.vertices))
        if not good.all():
            keep = good[mesh.faces].all(axis=1)
            count += int(len(keep) - keep.sum())
            mesh.update_faces(keep)
            mesh.remove_unreferenced_vertices()
        left += len(mesh.faces)
    if not left:
        raise _Unusable("has coordinates that are no numbers")
    return [_left_out(count)] if count else []


def _left_out(count: int) -> str:
    return f"has coordinates that are no numbers; {count} triangles are left out"


def _lacks_picture(mesh: Any) -> bool:
    """Whether a mesh of a COLLADA file has a place for a picture and none.

    What else a file may name, such as its bumps, RViz does not show either.
    """
    visual = mesh.visual
    return (
        getattr(visual, "uv", None) is not None
        and getattr(visual.material, "baseColorTexture", None) is None
    )


def _forget_invented(mesh: Any) -> None:
    """Take from a mesh the material that trimesh makes up where the file names none."""
    from trimesh.visual import ColorVisuals, material as materials

    made_up: Any = materials
    material: Any = getattr(mesh.visual, "material", None)
    if not isinstance(material, made_up.SimpleMaterial) or material.kwargs:
        return
    # Its picture is one of 2 x 2 equal pixels.
    if material.image is None or max(material.image.size) <= 2:
        mesh.visual = ColorVisuals(mesh)


def _paint_in_light(mesh: Any) -> None:
    """Turn the colours of corners or triangles, if there are any, into those of glTF."""
    visual = mesh.visual
    if getattr(visual, "kind", None) not in ("vertex", "face"):
        return
    colors = np.array(visual.vertex_colors, np.uint8)
    light = linear_light(colors[:, :3] / 255.0)
    colors[:, :3] = np.rint(255.0 * light)
    visual.vertex_colors = colors


def _check_gltf(raw: bytes) -> None:
    """Refuse what claims more numbers than it has, for which trimesh would take memory."""
    if raw[:4] == b"glTF":
        if len(raw) < 20:
            raise _Unusable("ends within its header")
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
            raise _Unusable(f"claims {count} numbers in {room} bytes")
        total += count
    if total > 6 * _MOST_TRIANGLES:
        raise _Unusable(f"claims {total} numbers")
