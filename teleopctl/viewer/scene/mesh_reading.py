"""Mesh files as glTF, which is what a browser draws."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import trimesh

from teleopctl.robot import read_mesh
from teleopctl.tf import Vector3
from teleopctl.viewer.scene.glb import furnished
from teleopctl.viewer.scene.srgb import linear_light
from teleopctl.viewer.scene.textures import fit_textures

Vertices = npt.NDArray[np.float32]
Faces = npt.NDArray[np.uint32]


class Content(NamedTuple):
    """Content of a mesh file, as glTF or as bare triangles; see `MeshFile`.

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


def drawn_mesh(path: Path, data: bytes | None = None, *, bare: bool = False) -> Content:
    """Read a mesh file for the page.

    Args:
        path: The file.
        data: The file's content, where it is nowhere on this machine.
        bare: Whether to leave its materials out.

    Raises:
        InvalidMeshError: It cannot be read; see `teleopctl.robot.read_mesh`.
    """
    mesh = read_mesh(path, data)
    box = _box(mesh.bounds)
    # Any: trimesh's results have no types that hold for every kind of file.
    scene: Any = mesh.scene
    if bare or scene is None:
        return Content(b"", *mesh.triangles(), box, mesh.faults)
    meshes = list(scene.geometry.values())
    is_gltf = path.suffix.lower() in (".glb", ".gltf")
    faults = mesh.faults + fit_textures(meshes)
    for part in meshes:
        _forget_invented(part)
        if not is_gltf:
            _paint_in_light(part)
    written = bytes(scene.export(file_type="glb"))
    return Content(furnished(written, is_gltf=is_gltf), None, None, box, faults)


def bare_glb(vertices: Vertices, faces: Faces) -> bytes:
    """Return triangles as binary glTF without normals, for flat shading."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    written: Any = mesh.export(file_type="glb", include_normals=False)
    return furnished(bytes(written), is_gltf=False)


def _box(bounds: npt.NDArray[np.floating[Any]]) -> tuple[Vector3, Vector3]:
    (lx, ly, lz), (hx, hy, hz) = bounds.tolist()
    return (lx, ly, lz), (hx, hy, hz)


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
