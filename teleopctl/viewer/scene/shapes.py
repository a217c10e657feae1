"""Shapes of a URDF as nodes of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from teleopctl.robot import Box, Capsule, Cylinder, Geometry, Material, Mesh, Sphere
from teleopctl.tf import Vector3, quaternion_from_rpy

if TYPE_CHECKING:
    import viser

    from teleopctl.robot import Pose
    from teleopctl.viewer.scene.mesh_files import MeshFile

# What RViz gives to a link without a material is red; an even grey tells shapes apart better.
_DEFAULT_RGBA = (0.7, 0.7, 0.72, 1.0)


def draw_shape(
    scene: viser.SceneApi,
    path: str,
    shape: Geometry,
    origin: Pose,
    material: Material | None,
    meshes: Mapping[str, MeshFile],
    alpha: float = 1.0,
) -> viser.SceneNodeHandle | None:
    """Draw one shape.

    Args:
        scene: Where to draw.
        path: The name of its node.
        shape: What to draw.
        origin: Where it stands in the node above.
        material: Its colour, where the URDF gives one.
        meshes: The files of meshes by URI.
        alpha: From 0, invisible, to 1.

    Returns:
        The node; None for a mesh that is not among the files.
    """
    x, y, z, w = quaternion_from_rpy(*origin.rpy)
    wxyz, position = (w, x, y, z), origin.xyz
    rgba = material.rgba if material is not None and material.rgba is not None else _DEFAULT_RGBA
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in rgba[:3])
    color = (red, green, blue)
    opacity = min(max(rgba[3] * alpha, 0.0), 1.0)
    see_through = None if opacity >= 1.0 else opacity
    if isinstance(shape, Box):
        return scene.add_box(
            path, color, shape.size, opacity=see_through, wxyz=wxyz, position=position
        )
    if isinstance(shape, Sphere):
        return scene.add_icosphere(
            path, shape.radius, color, opacity=see_through, wxyz=wxyz, position=position
        )
    if isinstance(shape, Cylinder):
        return scene.add_cylinder(
            path,
            shape.radius,
            shape.length,
            color,
            opacity=see_through,
            wxyz=wxyz,
            position=position,
        )
    if isinstance(shape, Capsule):
        import trimesh

        capsule = trimesh.creation.capsule(height=shape.length, radius=shape.radius)
        return scene.add_mesh_simple(
            path,
            capsule.vertices,
            capsule.faces,
            color=color,
            opacity=see_through,
            wxyz=wxyz,
            position=position,
        )
    mesh = meshes.get(shape.uri)
    if mesh is None:
        return None
    if mesh.vertices is None or mesh.faces is None:
        return scene.add_glb(path, mesh.glb, scale=shape.scale, wxyz=wxyz, position=position)
    return scene.add_mesh_simple(
        path,
        mesh.vertices,
        mesh.faces,
        color=color,
        opacity=see_through,
        flat_shading=True,
        side="double",
        scale=shape.scale,
        wxyz=wxyz,
        position=position,
    )


def mesh_uris(shapes: list[Geometry]) -> list[str]:
    """The meshes among shapes, each once."""
    return list(dict.fromkeys(shape.uri for shape in shapes if isinstance(shape, Mesh)))


def box_around(shape: Geometry, meshes: Mapping[str, MeshFile]) -> tuple[Vector3, Vector3] | None:
    """The lowest and highest corner of a shape in its own frame; None for a missing mesh."""
    match shape:
        case Box((x, y, z)):
            half = (x / 2, y / 2, z / 2)
        case Sphere(radius):
            half = (radius, radius, radius)
        case Cylinder(radius, length):
            half = (radius, radius, length / 2)
        case Capsule(radius, length):
            half = (radius, radius, length / 2 + radius)
        case Mesh(uri, scale):
            mesh = meshes.get(uri)
            if mesh is None:
                return None
            low, high = mesh.box
            return _scaled(low, scale), _scaled(high, scale)
    return (-half[0], -half[1], -half[2]), half


def _scaled(corner: Vector3, scale: Vector3) -> Vector3:
    return corner[0] * scale[0], corner[1] * scale[1], corner[2] * scale[2]
