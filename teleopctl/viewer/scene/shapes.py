"""Geometry of a URDF as viser scene nodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from teleopctl.robot import Box, Capsule, Cylinder, Geometry, Material, Mesh, Pose, Sphere
from teleopctl.tf import Vector3, quaternion_from_rpy
from teleopctl.viewer.scene.drawing import Rgba, is_drawable
from teleopctl.viewer.scene.gltf import colored_glb, surface_glb
from teleopctl.viewer.scene.unit_shapes import textured_shape

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.scene.assets import MeshFile
    from teleopctl.viewer.scene.gltf import Texture

# RViz draws links without material in red; shapes are easier to distinguish in a neutral grey.
_DEFAULT_RGBA: Rgba = (0.7, 0.7, 0.72, 1.0)


class ShapeDrawing:
    """Factory of viser nodes for a robot's geometries; equal meshes share their data.

    Args:
        scene: The viser scene.
        meshes: Loaded meshes by URI.
        textures: Loaded textures by URI.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        meshes: Mapping[str, MeshFile],
        textures: Mapping[str, Texture] | None = None,
    ) -> None:
        self._scene = scene
        self._meshes = meshes
        self._textures: Mapping[str, Texture] = textures or {}
        self._colored: dict[tuple[str, Rgba, float], bytes] = {}
        self._textured: dict[tuple[str, str | None, float], bytes] = {}

    def draw(
        self,
        path: str,
        shape: Geometry,
        origin: Pose,
        material: Material | None,
        alpha: float = 1.0,
    ) -> viser.SceneNodeHandle | None:
        """Add a viser node for a geometry and return it; None if invalid or its mesh is not loaded.

        Args:
            path: Scene path of the node.
            shape: Geometry to draw.
            origin: Pose of the geometry in the parent node.
            material: Material of the geometry in the URDF, or None.
            alpha: Opacity, from 0 to 1.

        Returns:
            The node; None for a mesh that is not loaded, or a geometry with invalid numbers.
        """
        if is_undrawable(shape, origin):
            return None
        x, y, z, w = quaternion_from_rpy(*origin.rpy)
        wxyz, position = (w, x, y, z), origin.xyz
        rgba = self._rgba(material)
        red, green, blue = (round(255 * part) for part in rgba[:3])
        scene, color = self._scene, (red, green, blue)
        opacity = rgba[3] * alpha
        see_through = None if opacity >= 1.0 else opacity
        if isinstance(shape, Mesh):
            mesh = self._meshes.get(shape.uri)
            if mesh is None:
                return None
            if mesh.glb:
                glb = self._colored_mesh(shape.uri, mesh, rgba, alpha)
                return scene.add_glb(path, glb, scale=shape.scale, wxyz=wxyz, position=position)
            assert mesh.vertices is not None
            assert mesh.faces is not None
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
        if (texture := self._texture(material)) is not None and not isinstance(shape, Capsule):
            glb, size = self._textured_shape(shape, material, texture, alpha)
            return scene.add_glb(path, glb, scale=size, wxyz=wxyz, position=position)
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
        assert isinstance(shape, Capsule)
        import trimesh

        capsule = trimesh.creation.capsule(height=shape.length, radius=shape.radius)
        # URDF's origin is the capsule's centre; trimesh's depends on the version
        return scene.add_mesh_simple(
            path,
            capsule.vertices - capsule.bounds.mean(axis=0),
            capsule.faces,
            color=color,
            opacity=see_through,
            wxyz=wxyz,
            position=position,
        )

    def _rgba(self, material: Material | None) -> Rgba:
        if material is None:
            return _DEFAULT_RGBA
        # As in RViz, a texture takes precedence over a colour.
        texture = self._texture(material)
        rgba = material.rgba if texture is None else texture.mean
        if rgba is None:
            return _DEFAULT_RGBA
        red, green, blue, opacity = (min(max(part, 0.0), 1.0) for part in rgba)
        return red, green, blue, opacity

    def _texture(self, material: Material | None) -> Texture | None:
        if material is None or material.texture is None:
            return None
        return self._textures.get(material.texture)

    def _textured_shape(
        self,
        shape: Box | Cylinder | Sphere,
        material: Material | None,
        texture: Texture,
        alpha: float,
    ) -> tuple[bytes, Vector3]:
        """Return a textured shape of unit size as glTF, which is cached, and its size."""
        match shape:
            case Box(size):
                name = "box"
            case Cylinder(radius, length):
                name, size = "cylinder", (2 * radius, 2 * radius, length)
            case Sphere(radius):
                name, size = "sphere", (2 * radius,) * 3
        key = (name, material.texture if material is not None else None, alpha)
        glb = self._textured.get(key)
        if glb is None:
            corners, normals, uv = textured_shape(name)
            white = np.array((1.0, 1.0, 1.0, alpha))
            glb = self._textured[key] = surface_glb(corners, white, uv, texture, normals)
        return glb, size

    def _colored_mesh(self, uri: str, mesh: MeshFile, rgba: Rgba, alpha: float) -> bytes:
        """Return a mesh as glTF with a colour for parts without material, which is cached."""
        key = (uri, rgba, alpha)
        glb = self._colored.get(key)
        if glb is None:
            glb = self._colored[key] = colored_glb(mesh.glb, rgba, alpha)
        return glb


def _lengths(shape: Geometry) -> tuple[float, ...]:
    if isinstance(shape, Box):
        return shape.size
    if isinstance(shape, Sphere):
        return (shape.radius,)
    if isinstance(shape, Mesh):
        return shape.scale
    return (shape.radius, shape.length)


def is_undrawable(shape: Geometry, origin: Pose | None = None) -> bool:
    """Return whether a geometry's sizes or pose are invalid; a mesh may have a negative scale."""
    lengths = _lengths(shape)
    if not is_drawable(lengths) or (origin and not is_drawable((*origin.xyz, *origin.rpy))):
        return True
    # A negative scale mirrors a mesh.
    return 0.0 in lengths if isinstance(shape, Mesh) else min(lengths) <= 0.0


def mesh_uris(shapes: list[Geometry]) -> list[str]:
    """Return the URIs of all meshes among some geometries, each URI once."""
    return list(dict.fromkeys(shape.uri for shape in shapes if isinstance(shape, Mesh)))


def bounding_box(shape: Geometry, meshes: Mapping[str, MeshFile]) -> tuple[Vector3, Vector3] | None:
    """Return a geometry's lowest and highest corner; None if invalid or its mesh is not loaded."""
    if is_undrawable(shape):
        return None
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
