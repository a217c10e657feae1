"""Mesh files of a robot: URIs into paths that MuJoCo can read.

MuJoCo reads OBJ, and binary STL of at most 200,000 triangles. What it does not read is converted
with trimesh. A mesh that cannot be had whole costs its picture and its contacts, never the
simulation: half of a shape would touch what the whole one does not.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from teleopctl.errors import TeleopctlError
from teleopctl.mujoco_model.convex import (
    can_decompose,
    collision_geoms,
    convex_pieces,
    decompose_files,
    measure_hull,
    replace_collisions,
)
from teleopctl.mujoco_model.mesh_content import load_mesh_content
from teleopctl.mujoco_model.paint import MeshTexture, add_textures, replace_visuals, visual_geoms
from teleopctl.packages import resolve_uri
from teleopctl.robot import InvalidMeshError, check_mesh_file

_READ_BY_MUJOCO = frozenset({".stl", ".obj", ".msh"})


def resolve_meshes(
    spec: mujoco.MjSpec, folder: Path | None = None, *, try_each: bool = False
) -> list[str]:
    """Give each mesh of a spec a readable file or its triangles; drop the rest with warnings.

    Args:
        spec: The ``mujoco.MjSpec`` whose meshes carry the URIs of the URDF.
        folder: What relative paths start at; None is the current folder.
        try_each: Whether to drop those as well that MuJoCo refuses. Of a whole model it tells the
            first only; each by itself costs the time of reading it once more.

    Returns:
        One warning per mesh that was dropped, or touches as something else than it is.
    """
    warnings: list[str] = []
    complained: set[str] = set()
    usable: list[tuple[Any, str, Path]] = []
    pictures: list[MeshTexture] = []
    for mesh in list(spec.meshes):
        uri: str = mesh.file
        if not uri:
            continue  # it has its corners
        reason = _use_file(spec, mesh, folder or Path(), pictures, warnings, try_each=try_each)
        if reason is None:
            if collision_geoms(spec, mesh):
                usable.append((mesh, uri, (folder or Path()) / resolve_uri(uri)))
            continue
        if uri not in complained:
            complained.add(uri)
            warnings.append(f"Mesh '{uri}' is left out: {reason}")
        _drop_mesh(spec, mesh)
    may_cut = not try_each and can_decompose()
    if may_cut:
        decompose_files([path for _, _, path in usable])
    for mesh, uri, path in usable:
        if words := _touch(spec, mesh, path, may_cut=may_cut):
            warnings.append(f"Mesh '{uri}' {words}")
    add_textures(spec, pictures)
    return warnings


# Any stands for MuJoCo's meshes, here and below: their class has no types.
def _touch(spec: mujoco.MjSpec, mesh: Any, path: Path, *, may_cut: bool) -> str:
    """Cut a mesh that touches into convex pieces where it needs that.

    Returns:
        What it touches as, as a sentence's end; empty for itself.
    """
    pieces = convex_pieces(path) if may_cut else []
    if not pieces:
        return measure_hull(path).fault
    replace_collisions(spec, mesh, pieces)
    return f"is hollow: it touches as {len(pieces)} convex pieces"


def _use_file(
    spec: mujoco.MjSpec,
    mesh: Any,
    folder: Path,
    pictures: list[MeshTexture],
    warnings: list[str],
    *,
    try_each: bool,
) -> str | None:
    """Give a mesh its file or its vertices, and the lists its pictures and what is left out of it.

    Returns:
        Why that was not possible, or None.
    """
    uri: str = mesh.file
    try:
        path = folder / resolve_uri(uri)
        if path.suffix.lower() != ".msh":  # MuJoCo's own
            check_mesh_file(path)
    except InvalidMeshError as error:
        return f"{path} {error.message}"
    except TeleopctlError as error:
        return error.message
    except ValueError as error:
        return f"{uri} cannot be read: {error}"
    if not path.is_file():
        return f"{path} is no file"
    refusal, is_read = None, False
    if path.suffix.lower() in _READ_BY_MUJOCO:
        mesh.file = str(path.absolute())
        refusal = _refusal(mesh) if try_each else None
        is_read = refusal is None
        if is_read and not (visual_geoms(spec, mesh) and _names_materials(path)):
            return None
    try:
        content = load_mesh_content(path)
    except InvalidMeshError as error:
        return None if is_read else f"{path} {error.message}"
    if not is_read:
        mesh.file = ""
        mesh.uservert = content.vertices.ravel().tolist()
        mesh.userface = content.faces.ravel().tolist()
        fault = _refusal(mesh) if try_each else None
        if fault is not None:
            return refusal or fault
    warnings += [f"Mesh '{uri}': {path} {fault}" for fault in content.faults]
    if content.parts and visual_geoms(spec, mesh):
        pictures += replace_visuals(
            spec, mesh, content.parts, lambda part: not (try_each and _refusal(part))
        )
    return None


def _names_materials(path: Path) -> bool:
    """Whether MuJoCo reads the triangles of a file, but not its colours."""
    return path.suffix.lower() == ".obj" and b"mtllib" in path.read_bytes()


def _refusal(mesh: Any) -> str | None:
    """What MuJoCo has against a mesh."""
    alone = mujoco.MjSpec()
    same = alone.add_mesh(name=mesh.name, file=mesh.file, scale=mesh.scale)
    same.uservert, same.userface = mesh.uservert, mesh.userface
    try:
        alone.compile()
    except ValueError as error:
        return str(error).partition("\n")[0].removeprefix("Error: ")
    return None


def _drop_mesh(spec: mujoco.MjSpec, mesh: Any) -> None:
    for geom in list(spec.geoms):
        if geom.meshname == mesh.name:
            spec.delete(geom)
    spec.delete(mesh)
