"""Objects of the planning scene: their shapes, and how messages add, move and remove them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.reading import pose_of
from teleopctl.viewer.scene.drawing import Drawing, Rgba, drawable_rows, is_drawable
from teleopctl.viewer.scene.mesh_files import MeshFile

# Any stands for messages throughout: their classes are made at run time, from definitions.

ADD, REMOVE, APPEND, MOVE = range(4)
_BOX, _SPHERE, _CYLINDER, _CONE = 1, 2, 3, 4
# How many numbers each has.
_NUMBERS = {_BOX: 3, _SPHERE: 1, _CYLINDER: 2, _CONE: 2}


@dataclass(slots=True)
class SceneObject:
    """A collision object of a planning scene.

    Attributes:
        frame: The frame that it stands in.
        pose: Where it stands there.
        shapes: Its shapes, and where they stand in it; solids, or the key of a mesh.
        color: Its own colour; None is the scene's.
        attached: Whether the robot holds it.
    """

    frame: str
    pose: Transform
    shapes: list[tuple[str, Transform, tuple[float, float, float]]] = field(default_factory=list)
    color: Rgba | None = None
    attached: bool = False


class SceneObjects:
    """The collision objects of a planning scene.

    Attributes:
        by_id: The objects.
        meshes: The triangles of their meshes, by key.
        left_out: How many shapes of the last message cannot be drawn.
    """

    def __init__(self) -> None:
        self.by_id: dict[str, SceneObject] = {}
        self.meshes: dict[str, MeshFile] = {}
        self.left_out = 0

    def clear(self) -> None:
        """Remove all collision objects."""
        self.by_id.clear()
        self.meshes.clear()

    def take(self, message: Any, link: str = "") -> None:
        """Add, append, move or remove a ``moveit_msgs/msg/CollisionObject``.

        Args:
            message: The object.
            link: The link that holds it; empty for one that nobody holds.
        """
        operation = operation_of(message)
        if operation == REMOVE:
            # What has been let go of is at once added to the world and removed from the robot.
            self.by_id = {
                key: one
                for key, one in self.by_id.items()
                if one.attached != bool(link) or message.id not in ("", key)
            }
            return
        frame = message.header.frame_id.removeprefix("/") or link
        pose = pose_of(message.pose)
        known = self.by_id.get(message.id)
        if pose is None:
            self.left_out += 1
            return
        if operation == MOVE and known is not None:
            known.pose, known.frame = pose, frame
            return
        if operation != APPEND or known is None:
            color = known.color if known is not None else None
            known = self.by_id[message.id] = SceneObject(frame, pose, color=color)
        elif link and known.frame != link:
            known.frame = frame
        known.attached = bool(link)
        self._add_shapes(known, message)

    def paint(self, colors: Any) -> None:
        """Set the objects' colours from ``moveit_msgs/msg/ObjectColor``."""
        for one in colors:
            found = self.by_id.get(one.id)
            if found is not None and is_drawable((one.color.r, one.color.g, one.color.b)):
                # alpha 0 is the unset default
                alpha = one.color.a if 0.0 < one.color.a <= 1.0 else 1.0
                found.color = (one.color.r, one.color.g, one.color.b, alpha)

    def drawings(self, color: Rgba, attached_color: Rgba) -> dict[str, Drawing]:
        """Return the drawings of the collision objects, by the frame of each.

        Args:
            color: Of objects without a colour.
            attached_color: Of those that the robot holds.
        """
        drawn: dict[str, Drawing] = {}
        for one in self.by_id.values():
            drawing = drawn.setdefault(one.frame, Drawing())
            if one.color is not None:
                rgba = (*one.color[:3], one.color[3] * color[3])
            else:
                rgba = attached_color if one.attached else color
            for shape, pose, size in one.shapes:
                drawing.solid(shape, one.pose @ pose, size, rgba)
        return drawn

    def forget_unused_meshes(self) -> None:
        """Drop the meshes of objects that were removed."""
        used = {shape for one in self.by_id.values() for shape, _, _ in one.shapes}
        for key in self.meshes.keys() - used:
            del self.meshes[key]

    def _add_shapes(self, known: SceneObject, message: Any) -> None:
        for solid, pose in _placed(message.primitives, message.primitive_poses):
            found = _solid(solid)
            if found is None or pose is None:
                self.left_out += 1
            else:
                known.shapes.append((found[0], pose, found[1]))
        for mesh, pose in _placed(message.meshes, message.mesh_poses):
            key = self._keep(mesh)
            if not key or pose is None:
                self.left_out += 1
            else:
                known.shapes.append((key, pose, (1.0, 1.0, 1.0)))
        self.left_out += len(message.planes)

    def _keep(self, mesh: Any) -> str:
        """Keep the triangles of a ``shape_msgs/msg/Mesh``; its key, or nothing for an odd one."""
        corners = np.array([(v.x, v.y, v.z) for v in mesh.vertices], np.float64).reshape(-1, 3)
        faces = np.array([one.vertex_indices for one in mesh.triangles], np.uint32).reshape(-1, 3)
        if not len(faces) or not len(corners) or int(faces.max()) >= len(corners):
            return ""
        if not drawable_rows(corners).all():
            return ""
        vertices = corners.astype(np.float32)
        digest = hashlib.sha256(vertices.tobytes() + faces.tobytes()).hexdigest()[:16]
        key = f"mesh_{digest}"
        self.meshes.setdefault(key, MeshFile(Path(), b"", vertices, faces))
        return key


def operation_of(message: Any) -> int:
    """Return the operation of a collision object message as an int."""
    operation = message.operation
    return operation[0] if isinstance(operation, bytes) else int(operation)


def _placed(shapes: Sequence[Any], poses: Sequence[Any]) -> Iterator[tuple[Any, Transform | None]]:
    """Shapes and where each stands in its object; of an object without poses, at its origin."""
    stand = [pose_of(pose) for pose in poses] if poses else [Transform()] * len(shapes)
    for number, shape in enumerate(shapes):
        yield shape, stand[number] if number < len(stand) else None


def _solid(message: Any) -> tuple[str, tuple[float, float, float]] | None:
    """The shape of a ``shape_msgs/msg/SolidPrimitive`` and its size."""
    numbers = [float(number) for number in message.dimensions]
    needed = _NUMBERS.get(message.type, 0)
    if not needed or len(numbers) < needed or not is_drawable(numbers[:needed]):
        return None
    if any(number <= 0.0 for number in numbers[:needed]):
        return None
    if message.type == _BOX:
        return "box", (numbers[0], numbers[1], numbers[2])
    if message.type == _SPHERE:
        return "sphere", (2 * numbers[0],) * 3
    shape = "cylinder" if message.type == _CYLINDER else "cone"
    return shape, (2 * numbers[1], 2 * numbers[1], numbers[0])
