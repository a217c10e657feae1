"""Shapes of the objects of a planning scene, and their geoms in a MuJoCo model."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.poses import Array, pose_transform
from teleopctl.kinematics.scene.meshes import Indices, convex_pieces

_ALL_BITS = 0x7FFFFFFF
# Corners of the circle of a cone, which encloses it.
_CORNERS = 32


class ShapeKind(enum.Enum):
    """Kinds of shapes, with the numbers of ``shape_msgs/msg/SolidPrimitive`` as far as they go."""

    BOX = 1
    SPHERE = 2
    CYLINDER = 3
    CONE = 4
    MESH = -1
    PLANE = -2


_DIMENSIONS = {
    ShapeKind.BOX: ("x", "y", "z"),
    ShapeKind.SPHERE: ("radius",),
    ShapeKind.CYLINDER: ("height", "radius"),
    ShapeKind.CONE: ("height", "radius"),
}


@dataclass(frozen=True, slots=True)
class CollisionShape:
    """Shape of a collision object, in a frame of its own.

    Attributes:
        kind: Kind of shape.
        dimensions: Box: lengths of the edges along x, y, z, m; sphere: radius, m; cylinder and
            cone: height along z and radius, m, with the origin at half the height; plane: a, b, c,
            d of a x + b y + c z + d = 0; mesh: empty.
        vertices: Vertices of a mesh, (n, 3), m; otherwise None.
        triangles: Numbers of the vertices of each triangle of a mesh, (m, 3); otherwise None.
        pieces: Convex pieces of a mesh, each by its vertices, (k, 3).
        warning: How the pieces differ from the mesh; empty if they do not.
    """

    kind: ShapeKind
    dimensions: tuple[float, ...] = ()
    vertices: Array | None = field(default=None, compare=False)
    triangles: Indices | None = field(default=None, compare=False)
    pieces: tuple[Array, ...] = field(default=(), compare=False)
    warning: str = ""

    @classmethod
    def primitive(cls, kind: ShapeKind, dimensions: tuple[float, ...]) -> CollisionShape:
        """Return a box, sphere, cylinder or cone.

        Raises:
            UsageError: A dimension is missing, or not above 0.
        """
        names = _DIMENSIONS[kind]
        word = kind.name.lower()
        if len(dimensions) < len(names):
            raise UsageError(
                f"A {word} has the dimensions {', '.join(names)}, got {len(dimensions)} of them"
            )
        values = tuple(float(value) for value in dimensions[: len(names)])
        for name, value in zip(names, values, strict=True):
            if not (math.isfinite(value) and value > 0.0):
                raise UsageError(f"The {name} of a {word} must be above 0 m, got {value:g}")
        return cls(kind, values)

    @classmethod
    def plane(cls, a: float, b: float, c: float, d: float) -> CollisionShape:
        """Return the plane a x + b y + c z + d = 0.

        Raises:
            UsageError: The normal a, b, c is zero, or a value is not finite.
        """
        values = (float(a), float(b), float(c), float(d))
        if not all(map(math.isfinite, values)) or math.hypot(*values[:3]) < 1e-9:
            raise UsageError(f"A plane needs a normal, got a, b, c, d = {values}")
        return cls(ShapeKind.PLANE, values)

    @classmethod
    def mesh(cls, vertices: Array, triangles: Indices) -> CollisionShape:
        """Return a mesh, see `convex_pieces`.

        Raises:
            UsageError: The numbers are no mesh.
        """
        pieces, warning = convex_pieces(vertices, triangles)
        return cls(
            ShapeKind.MESH,
            vertices=vertices,
            triangles=triangles,
            pieces=tuple(pieces),
            warning=warning,
        )


# Any: MuJoCo's elements, which have no types.
def add_geoms(
    spec: Any,
    parent: Any,
    shape: CollisionShape,
    pose: Array,
    prefix: str,
    density: float = 0.0,
) -> list[str]:
    """Add the geoms of a shape to a body of a ``mujoco.MjSpec``; return their names.

    Args:
        spec: The spec.
        parent: Body of the spec.
        shape: The shape.
        pose: Pose of the shape in the frame of the body, (4, 4).
        prefix: Prefix of all names.
        density: Density, kg/m³; 0 for shapes that have no mass.
    """
    kinds = mujoco.mjtGeom
    size = shape.dimensions
    match shape.kind:
        case ShapeKind.BOX:
            half = [0.5 * s for s in size]
            return [_add(parent, prefix, pose, kinds.mjGEOM_BOX, half, density)]
        case ShapeKind.SPHERE:
            radius = [size[0], 0.0, 0.0]
            return [_add(parent, prefix, pose, kinds.mjGEOM_SPHERE, radius, density)]
        case ShapeKind.CYLINDER:
            half = [size[1], 0.5 * size[0], 0.0]
            return [_add(parent, prefix, pose, kinds.mjGEOM_CYLINDER, half, density)]
        case ShapeKind.PLANE:
            upright = pose @ _plane_pose(shape)
            return [_add(parent, prefix, upright, kinds.mjGEOM_PLANE, [0.0, 0.0, 1.0], 0.0)]
        case ShapeKind.CONE:
            pieces: tuple[Array, ...] = (_cone(*size),)
        case ShapeKind.MESH:
            pieces = shape.pieces
    names = []
    for number, vertices in enumerate(pieces):
        name = f"{prefix}/{number}"
        mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        mesh.uservert = vertices.ravel().tolist()
        no_size = [0.0, 0.0, 0.0]
        names.append(_add(parent, name, pose, kinds.mjGEOM_MESH, no_size, density, meshname=name))
    return names


def plane_side(shape: CollisionShape, T_root_shape: Array) -> CollisionShape:
    """Return a plane with its normal towards the origin of the root link.

    MuJoCo's planes are solid on the other side of the normal, and a description of a table by its
    plane need not think of that.
    """
    normal, offset = np.array(shape.dimensions[:3]), shape.dimensions[3]
    origin = -T_root_shape[:3, :3].T @ T_root_shape[:3, 3]
    if float(normal @ origin) + offset < -1e-3 * float(np.linalg.norm(normal)):
        return CollisionShape(ShapeKind.PLANE, tuple(-value for value in shape.dimensions))
    return shape


# Any: MuJoCo's elements, which have no types.
def _add(
    parent: Any,
    name: str,
    pose: Array,
    kind: Any,
    size: list[float],
    density: float,
    *,
    meshname: str = "",
) -> str:
    x, y, z, w = pose_transform(pose).rotation
    parent.add_geom(
        name=name,
        type=kind,
        size=size,
        pos=pose[:3, 3],
        quat=[w, x, y, z],
        meshname=meshname,
        contype=_ALL_BITS,
        conaffinity=_ALL_BITS,
        density=density,
    )
    return name


def _plane_pose(shape: CollisionShape) -> Array:
    """Return the pose of MuJoCo's plane, whose normal is z, in the frame of the shape, (4, 4)."""
    normal = np.array(shape.dimensions[:3])
    length = float(np.linalg.norm(normal))
    normal = normal / length
    side = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = side, np.cross(normal, side), normal
    pose[:3, 3] = -shape.dimensions[3] / length * normal
    return pose


def _cone(height: float, radius: float) -> Array:
    turn = 2.0 * np.pi * np.arange(_CORNERS) / _CORNERS
    outside = radius / math.cos(math.pi / _CORNERS)
    circle = np.stack(
        (outside * np.cos(turn), outside * np.sin(turn), np.full(_CORNERS, -0.5 * height)), axis=1
    )
    return np.vstack((circle, (0.0, 0.0, 0.5 * height)))
