"""Mesh files of a robot: URIs into paths that MuJoCo can read.

MuJoCo reads OBJ, and binary STL of at most 200,000 triangles. Other files are converted with
trimesh. A mesh that cannot be read as a whole is left out, drawn and touched by nothing, and the
simulation runs without it: part of a shape would touch what the whole shape does not.
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
    """Resolve a spec's mesh files for MuJoCo, cut hollow ones, drop unusable ones; return warnings.

    Args:
        spec: The ``mujoco.MjSpec`` whose meshes carry the URIs of the URDF.
        folder: Folder of relative paths; None for the current folder.
        try_each: Whether to drop meshes that MuJoCo rejects, too. For a whole model MuJoCo reports
            the first of them only; to test each mesh alone, the mesh is read once more.

    Returns:
        One warning per mesh that was dropped, or whose collision shape is not the mesh itself.
    """
    warnings: list[str] = []
    complained: set[str] = set()
    usable: list[tuple[Any, str, Path]] = []
    pictures: list[MeshTexture] = []
    for mesh in list(spec.meshes):
        uri: str = mesh.file
        if not uri:
            continue  # its vertices are in the spec
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
    """Replace the collision shape of a hollow mesh by convex pieces, if possible.

    Returns:
        End of a warning about the collision shape; empty if the mesh itself is the shape.
    """
    pieces = convex_pieces(path) if may_cut else []
    if not pieces:
        return measure_hull(path).fault
    replace_collisions(spec, mesh, pieces)
    return f"is hollow: it collides as {len(pieces)} convex pieces"


def _use_file(
    spec: mujoco.MjSpec,
    mesh: Any,
    folder: Path,
    pictures: list[MeshTexture],
    warnings: list[str],
    *,
    try_each: bool,
) -> str | None:
    """Set a mesh's file or vertices; append its textures and warnings to the given lists.

    Returns:
        Reason why that was not possible, or None.
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
    """Return MuJoCo's error for a mesh, compiled alone; None if MuJoCo accepts the mesh."""
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
