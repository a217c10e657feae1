"""Mesh files of a robot: URIs into paths that MuJoCo can read.

MuJoCo reads STL and OBJ. COLLADA files are converted with trimesh. A mesh
that cannot be had costs its picture and its contacts, never the simulation.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.packages import resolve_uri
from teleopctl.robot import collada_unit_m

if TYPE_CHECKING:
    import mujoco

_READ_BY_MUJOCO = frozenset({".stl", ".obj", ".msh"})


def resolve_meshes(spec: mujoco.MjSpec) -> list[str]:
    """Point every mesh of a spec at a readable file, and drop those that have none.

    Args:
        spec: The ``mujoco.MjSpec`` whose meshes carry the URIs of the URDF.

    Returns:
        One warning per mesh that was dropped.
    """
    warnings: list[str] = []
    complained: set[str] = set()
    for mesh in list(spec.meshes):
        uri: str = mesh.file
        reason = _use_file(mesh, uri)
        if reason is None:
            continue
        if uri not in complained:
            complained.add(uri)
            warnings.append(f"Mesh '{uri}' is left out: {reason}")
        _drop_mesh(spec, mesh)
    return warnings


def _use_file(mesh: Any, uri: str) -> str | None:
    """Give a mesh its file or its vertices; returns why that was not possible, or None."""
    try:
        path = resolve_uri(uri)
    except TeleopctlError as error:
        return error.message
    if not path.is_file():
        return f"{path} does not exist"
    if path.suffix.lower() in _READ_BY_MUJOCO:
        mesh.file = str(path.absolute())
        return None
    return _convert(mesh, path)


def _convert(mesh: Any, path: Path) -> str | None:
    """Load a format that MuJoCo does not read through trimesh, as plain triangles."""
    import trimesh

    try:
        # One mesh of the whole scene graph.
        scene: Any = trimesh.load_scene(path)
        loaded: Any = scene.to_mesh()
        if path.suffix.lower() == ".dae":
            parts = scene.geometry.values()
            loaded.apply_scale(collada_unit_m(part.metadata for part in parts))
    except Exception as error:  # noqa: BLE001 - trimesh's readers raise whatever their parsers do
        return f"{path} cannot be read: {error}"
    if len(loaded.faces) == 0:
        return f"{path} holds no triangles"
    mesh.file = ""
    mesh.uservert = loaded.vertices.astype("float32").ravel().tolist()
    mesh.userface = loaded.faces.astype("int32").ravel().tolist()
    return None


def _drop_mesh(spec: mujoco.MjSpec, mesh: Any) -> None:
    for geom in list(spec.geoms):
        if geom.meshname == mesh.name:
            spec.delete(geom)
    spec.delete(mesh)
