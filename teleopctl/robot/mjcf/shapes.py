"""Shapes of an MJCF file as those of a URDF link."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from lxml import etree

from teleopctl.robot.meshes.export import exported_stl, unit_ball
from teleopctl.robot.mjcf.mjcf_file import Mjcf
from teleopctl.robot.urdf_text import add_origin, numbers, transform
from teleopctl.tf import Transform

_Kind = mujoco.mjtGeom
# Shapes that MuJoCo's own viewer leaves out: mostly those that touch.
_FIRST_HIDDEN_GROUP = 3
# What MuJoCo gives to a shape that nobody gave a colour: then its material's counts.
_UNSET_RGBA = np.array([0.5, 0.5, 0.5, 1.0], np.float32)
_READ_BY_ALL = (".stl", ".obj")


def add_shapes(link: etree._Element, mjcf: Mjcf, body: int) -> list[str]:
    """Add a body's visual and collision shapes to its link.

    Returns:
        A sentence for each that URDF has no shape for.
    """
    m = mjcf.model
    remarks = []
    first = int(m.body_geomadr[body])
    for geom in range(first, first + int(m.body_geomnum[body])):
        touches = bool(m.geom_contype[geom] or m.geom_conaffinity[geom])
        drawn = int(m.geom_group[geom]) < _FIRST_HIDDEN_GROUP and _color(m, geom)[3] > 0.0
        shape = _shape(mjcf, geom) if drawn or touches else None
        if shape is None:
            if drawn or touches:
                kind = _Kind(int(m.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
                remarks.append(f"A {kind} of link '{link.get('name')}' is simulated, not shown")
            continue
        for tag, wanted in (("visual", drawn), ("collision", touches)):
            if not wanted:
                continue
            element = etree.SubElement(link, tag)
            place, attributes = shape
            add_origin(element, place)
            geometry = etree.SubElement(element, "geometry")
            etree.SubElement(geometry, attributes[0], attributes[1])
            if tag == "visual":
                rgba = _color(m, geom)
                # One name for one colour, since a name means one material.
                material = etree.SubElement(element, "material", name=f"rgba {numbers(*rgba)}")
                etree.SubElement(material, "color", rgba=numbers(*rgba))
    return remarks


_Shape = tuple[Transform, tuple[str, dict[str, str]]]


def _shape(mjcf: Mjcf, geom: int) -> _Shape | None:
    """Where a shape is, its tag and the attributes of that; None where URDF has none."""
    m = mjcf.model
    place = transform(m.geom_pos[geom], m.geom_quat[geom])
    a, b, c = (float(size) for size in m.geom_size[geom])
    match m.geom_type[geom]:
        case _Kind.mjGEOM_BOX:
            return place, ("box", {"size": numbers(2 * a, 2 * b, 2 * c)})
        case _Kind.mjGEOM_SPHERE:
            return place, ("sphere", {"radius": numbers(a)})
        case _Kind.mjGEOM_CYLINDER:
            return place, ("cylinder", {"radius": numbers(a), "length": numbers(2 * b)})
        case _Kind.mjGEOM_CAPSULE:
            return place, ("capsule", {"radius": numbers(a), "length": numbers(2 * b)})
        case _Kind.mjGEOM_ELLIPSOID:
            return place, ("mesh", {"filename": unit_ball().as_uri(), "scale": numbers(a, b, c)})
        case _Kind.mjGEOM_MESH | _Kind.mjGEOM_SDF if m.geom_dataid[geom] >= 0:
            return _mesh(mjcf, int(m.geom_dataid[geom]), place)
        case _:
            return None


def _mesh(mjcf: Mjcf, mesh: int, place: Transform) -> _Shape:
    """A mesh by its own file where others read that as MuJoCo does, else by one made of it."""
    m = mjcf.model
    element = mjcf.spec.mesh(m.mesh(mesh).name)
    file = _file_of(mjcf, element)
    if file is not None and _is_plain(element):
        # MuJoCo turns a mesh into the axes of its inertia, and the shape back.
        own = transform(m.mesh_pos[mesh], m.mesh_quat[mesh])
        scale = numbers(*(float(value) for value in element.scale))
        return place @ own.inverse(), ("mesh", {"filename": file.as_uri(), "scale": scale})
    first, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
    start, faces = int(m.mesh_faceadr[mesh]), int(m.mesh_facenum[mesh])
    made = exported_stl(m.mesh_vert[first : first + count], m.mesh_face[start : start + faces])
    return place, ("mesh", {"filename": made.as_uri()})


def _file_of(mjcf: Mjcf, mesh: Any) -> Path | None:
    """A mesh's file, where it has one and that lies where the file says."""
    if not mesh.file:
        return None
    spec = mjcf.spec
    name = Path(mesh.file).name if spec.strippath else mesh.file
    file = mjcf.path.parent / (spec.meshdir or "") / name
    return file.resolve() if file.is_file() else None


def _is_plain(mesh: Any) -> bool:
    """Whether a mesh is what its file says, scaled."""
    still = not np.any(mesh.refpos) and np.allclose(mesh.refquat, [1.0, 0.0, 0.0, 0.0])
    return still and Path(mesh.file).suffix.lower() in _READ_BY_ALL


def _color(m: Any, geom: int) -> tuple[float, ...]:
    rgba, material = m.geom_rgba[geom], int(m.geom_matid[geom])
    if material >= 0 and np.array_equal(rgba, _UNSET_RGBA):
        rgba = m.mat_rgba[material]
    return tuple(round(float(part), 4) for part in rgba)
