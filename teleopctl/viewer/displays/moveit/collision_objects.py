"""Collision objects of a planning scene, as `moveit_msgs/msg/CollisionObject` changes them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.conversions import pose_of
from teleopctl.viewer.scene.assets import MeshFile
from teleopctl.viewer.scene.drawing import Drawing, Rgba, drawable_rows, is_drawable

# Any: messages, whose classes are created from definitions at run time.

ADD, REMOVE, APPEND, MOVE = range(4)
SIMULATED_DB = "mujoco_sim"
"""``type.db`` of the objects that move_group takes from the simulator's world."""
_BOX, _SPHERE, _CYLINDER, _CONE = 1, 2, 3, 4
# Number of dimensions of each shape.
_NUMBERS = {_BOX: 3, _SPHERE: 1, _CYLINDER: 2, _CONE: 2}


@dataclass(slots=True)
class SceneObject:
    """Collision object of a MoveIt planning scene: frame, pose, shapes and colour.

    Attributes:
        frame: Frame of the pose.
        pose: Pose of the object in that frame.
        shapes: Name of a solid or key of a mesh, pose in the object, and size of each shape.
        color: Colour of the object; None for the default of the scene.
        attached: Whether the object is attached to a link of the robot.
        simulated: Whether it is a body of the simulator's world.
    """

    frame: str
    pose: Transform
    shapes: list[tuple[str, Transform, tuple[float, float, float]]] = field(default_factory=list)
    color: Rgba | None = None
    attached: bool = False
    simulated: bool = False


class SceneObjects:
    """Collision objects of a MoveIt planning scene, changed by CollisionObject messages.

    Attributes:
        by_id: Objects by ID.
        meshes: Triangles of the objects' meshes by key.
        left_out: Number of shapes of the last message that cannot be drawn.
    """

    def __init__(self) -> None:
        self.by_id: dict[str, SceneObject] = {}
        self.meshes: dict[str, MeshFile] = {}
        self.left_out = 0

    def clear(self) -> None:
        """Remove all collision objects and their meshes."""
        self.by_id.clear()
        self.meshes.clear()

    def apply(self, message: Any, link: str = "") -> None:
        """Add, append, move or remove a CollisionObject; ``link`` is the link it is attached to.

        Args:
            message: The ``moveit_msgs/msg/CollisionObject``.
            link: Link that the object is attached to; empty for an object of the world.
        """
        operation = operation_of(message)
        if operation == REMOVE:
            # A detached object is added to the world and removed from the robot in one message.
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
            known.simulated = message.type.db == SIMULATED_DB
        elif link and known.frame != link:
            known.frame = frame
        known.attached = bool(link)
        self._add_shapes(known, message)

    def set_colors(self, colors: Any) -> None:
        """Set the objects' colours from a list of ``moveit_msgs/msg/ObjectColor``."""
        for one in colors:
            found = self.by_id.get(one.id)
            if found is not None and is_drawable((one.color.r, one.color.g, one.color.b)):
                # alpha 0 is the unset default
                alpha = one.color.a if 0.0 < one.color.a <= 1.0 else 1.0
                found.color = (one.color.r, one.color.g, one.color.b, alpha)

    def drawings(
        self, color: Rgba, attached_color: Rgba, *, simulated: bool = True
    ) -> dict[str, Drawing]:
        """Return one drawing of collision objects per tf frame, by frame name.

        Args:
            color: Colour of objects without a colour; its opacity also applies to coloured objects.
            attached_color: Colour of attached objects without a colour.
            simulated: Whether to draw the bodies of the simulator's world.
        """
        drawn: dict[str, Drawing] = {}
        for one in self.by_id.values():
            if one.simulated and not simulated:
                continue
            drawing = drawn.setdefault(one.frame, Drawing())
            if one.color is not None:
                rgba = (*one.color[:3], one.color[3] * color[3])
            else:
                rgba = attached_color if one.attached else color
            for shape, pose, size in one.shapes:
                drawing.solid(shape, one.pose @ pose, size, rgba)
        return drawn

    def drop_unused_meshes(self) -> None:
        """Drop the meshes that no collision object uses any more."""
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
        """Store the triangles of a ``shape_msgs/msg/Mesh``; return their key, empty if invalid."""
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
    """Return the operation of a CollisionObject message (ADD, REMOVE, …) as an int."""
    operation = message.operation
    return operation[0] if isinstance(operation, bytes) else int(operation)


def _placed(shapes: Sequence[Any], poses: Sequence[Any]) -> Iterator[tuple[Any, Transform | None]]:
    """Yield shapes with their poses; None where one is invalid or missing."""
    stand = [pose_of(pose) for pose in poses] if poses else [Transform()] * len(shapes)
    for number, shape in enumerate(shapes):
        yield shape, stand[number] if number < len(stand) else None


def _solid(message: Any) -> tuple[str, tuple[float, float, float]] | None:
    """Return the name and size of a ``shape_msgs/msg/SolidPrimitive``, or None if invalid."""
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
