"""Conversion of MoveIt's messages to and from `teleopctl.kinematics`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from teleopctl.commander import read_pose, write_joint_trajectory, write_pose
from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import (
    AllowedCollisions,
    AttachedBody,
    CollisionBody,
    CollisionShape,
    MotionPlan,
    ShapeKind,
)

# Any, here and below: message classes are generated at run time from definitions.
_CollisionObject: Any = get_message("moveit_msgs/msg/CollisionObject")
_SolidPrimitive: Any = get_message("shape_msgs/msg/SolidPrimitive")

ADD, REMOVE, APPEND, MOVE = 0, 1, 2, 3
"""Operations of ``moveit_msgs/msg/CollisionObject``."""


def is_default_pose(message: Any) -> bool:
    """Return whether a Pose was not set: the origin, without rotation."""
    position, turn = message.position, message.orientation
    return (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w) == (
        *(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        1.0,
    )


# --- collision objects ------------------------------------------------------------------------


def read_object(message: Any, T_root_header: np.ndarray) -> CollisionBody:
    """Return a CollisionObject as an object of the scene.

    Without a pose of the object, the pose of its only shape is that of the object, as in MoveIt.

    Args:
        message: A ``moveit_msgs/msg/CollisionObject``.
        T_root_header: Pose of the frame of its header, (4, 4).

    Raises:
        UsageError: A shape or a pose is invalid.
    """
    name = message.id
    shapes: list[CollisionShape] = []
    poses: list[np.ndarray] = []
    for kind, elements, element_poses, read in (
        ("primitive", message.primitives, message.primitive_poses, _read_primitive),
        ("mesh", message.meshes, message.mesh_poses, _read_mesh),
        ("plane", message.planes, message.plane_poses, _read_plane),
    ):
        if len(element_poses) > len(elements):
            raise UsageError(
                f"The collision object '{name}' has {len(elements)} shapes of the kind {kind}, and "
                f"{len(element_poses)} poses of them"
            )
        for number, element in enumerate(elements):
            try:
                shapes.append(read(element))
            except UsageError as error:
                raise UsageError(f"The collision object '{name}': {error.message}") from error
            poses.append(
                _object_pose(element_poses[number], name)
                if number < len(element_poses)
                else np.eye(4)
            )
    pose = _object_pose(message.pose, name)
    if len(shapes) == 1 and is_default_pose(message.pose):
        pose, poses = poses[0], [np.eye(4)]
    return CollisionBody(
        name,
        np.asarray(T_root_header @ pose),
        tuple(shapes),
        tuple(poses),
        subframes={
            subframe: _object_pose(at, name)
            for subframe, at in zip(message.subframe_names, message.subframe_poses, strict=False)
        },
        type=(message.type.key, message.type.db),
    )


def read_move(message: Any, T_root_header: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the pose of an object that is moved, and the new poses of its shapes, if any."""
    name = message.id
    shapes = (*message.primitive_poses, *message.mesh_poses, *message.plane_poses)
    return (
        np.asarray(T_root_header @ _object_pose(message.pose, name)),
        [_object_pose(pose, name) for pose in shapes],
    )


def write_object(one: CollisionBody, frame: str, *, with_shapes: bool = True) -> Any:
    """Return an object as a CollisionObject in a frame."""
    message = _CollisionObject(id=one.name, operation=ADD)
    message.header.frame_id = frame
    message.type.key, message.type.db = one.type
    if not with_shapes:
        return message
    message.pose = write_pose(one.pose)
    for shape, pose in zip(one.shapes, one.shape_poses, strict=True):
        if shape.kind is ShapeKind.MESH:
            message.meshes.append(_write_mesh(shape))
            message.mesh_poses.append(write_pose(pose))
        elif shape.kind is ShapeKind.PLANE:
            message.planes.append(get_message("shape_msgs/msg/Plane")(coef=list(shape.dimensions)))
            message.plane_poses.append(write_pose(pose))
        else:
            message.primitives.append(
                _SolidPrimitive(type=shape.kind.value, dimensions=list(shape.dimensions))
            )
            message.primitive_poses.append(write_pose(pose))
    message.subframe_names = list(one.subframes)
    message.subframe_poses = [write_pose(pose) for pose in one.subframes.values()]
    return message


def write_attached(one: AttachedBody) -> Any:
    """Return an attached object as an AttachedCollisionObject."""
    message: Any = get_message("moveit_msgs/msg/AttachedCollisionObject")(
        link_name=one.link, touch_links=sorted(one.touch_links), weight=one.weight
    )
    message.object = write_object(one.object, one.link)
    if one.detach_posture is not None:
        message.detach_posture = one.detach_posture
    return message


def _object_pose(message: Any, name: str) -> np.ndarray:
    return read_pose(message, f"The collision object '{name}'")


def _read_primitive(message: Any) -> CollisionShape:
    try:
        kind = ShapeKind(int(message.type))
    except ValueError:
        raise UsageError(
            f"Shapes of type {message.type} are not supported: box 1, sphere 2, cylinder 3, cone 4"
        ) from None
    return CollisionShape.primitive(kind, tuple(float(value) for value in message.dimensions))


def _read_mesh(message: Any) -> CollisionShape:
    vertices = np.array([(point.x, point.y, point.z) for point in message.vertices], np.float64)
    triangles = np.array([each.vertex_indices for each in message.triangles], np.intp)
    return CollisionShape.mesh(vertices.reshape(-1, 3), triangles.reshape(-1, 3))


def _read_plane(message: Any) -> CollisionShape:
    a, b, c, d = (float(value) for value in message.coef)
    return CollisionShape.plane(a, b, c, d)


def _write_mesh(shape: CollisionShape) -> Any:
    assert shape.vertices is not None
    assert shape.triangles is not None
    point, triangle = (
        get_message("geometry_msgs/msg/Point"),
        get_message("shape_msgs/msg/MeshTriangle"),
    )
    mesh: Any = get_message("shape_msgs/msg/Mesh")()
    mesh.vertices = [point(x=x, y=y, z=z) for x, y, z in shape.vertices.tolist()]
    mesh.triangles = [triangle(vertex_indices=each) for each in shape.triangles.tolist()]
    return mesh


def with_simulation_flags(one: CollisionBody, known: CollisionBody | None) -> CollisionBody:
    """Return an object that is free and simulated as another one of its name was."""
    if known is None:
        return one
    return replace(one, is_free=known.is_free, is_simulated=known.is_simulated)


# --- allowed collisions -------------------------------------------------------------------------


def read_allowed(message: Any) -> AllowedCollisions:
    """Return an AllowedCollisionMatrix.

    Raises:
        UsageError: Its rows do not fit its names.
    """
    names = list(message.entry_names)
    rows = [list(entry.enabled) for entry in message.entry_values]
    if len(rows) != len(names) or any(len(row) != len(names) for row in rows):
        raise UsageError(
            f"The allowed collision matrix has {len(names)} names, and {len(rows)} rows of "
            f"{', '.join(sorted({str(len(row)) for row in rows})) or 'no'} values"
        )
    if len(message.default_entry_names) != len(message.default_entry_values):
        raise UsageError(
            f"The allowed collision matrix has {len(message.default_entry_names)} default names, "
            f"and {len(message.default_entry_values)} values of them"
        )
    allowed = AllowedCollisions()
    for place, first in enumerate(names):
        for other, second in enumerate(names[: place + 1]):
            if place != other:
                allowed.set(first, second, is_allowed=bool(rows[place][other]))
    for name, value in zip(message.default_entry_names, message.default_entry_values, strict=True):
        allowed.set_default(name, is_allowed=bool(value))
    return allowed


def write_allowed(allowed: AllowedCollisions) -> Any:
    """Return allowed collisions as an AllowedCollisionMatrix."""
    message: Any = get_message("moveit_msgs/msg/AllowedCollisionMatrix")()
    entry: Any = get_message("moveit_msgs/msg/AllowedCollisionEntry")
    names = allowed.names
    places = {name: place for place, name in enumerate(names)}
    rows = [[False] * len(names) for _ in names]
    for (first, second), value in allowed.entries.items():
        rows[places[first]][places[second]] = rows[places[second]][places[first]] = value
    message.entry_names = names
    message.entry_values = [entry(enabled=row) for row in rows]
    message.default_entry_names = list(allowed.defaults)
    message.default_entry_values = list(allowed.defaults.values())
    return message


# --- states and trajectories --------------------------------------------------------------------


def read_joint_state(message: Any) -> dict[str, float]:
    """Return the positions of a JointState by joint.

    Raises:
        UsageError: There are fewer or more positions than names, or one is not finite.
    """
    names, positions = list(message.name), list(message.position)
    if len(names) != len(positions):
        raise UsageError(f"The joint state has {len(names)} names and {len(positions)} positions")
    for name, position in zip(names, positions, strict=True):
        if not math.isfinite(position):
            raise UsageError(f"The position of joint '{name}' is not a finite number")
    return {name: float(at) for name, at in zip(names, positions, strict=True)}


def write_robot_state(
    positions: Mapping[str, float], frame: str, attached: Iterable[AttachedBody] = ()
) -> Any:
    """Return positions by joint, rad or m, as a RobotState."""
    message: Any = get_message("moveit_msgs/msg/RobotState")()
    message.joint_state.header.frame_id = frame
    message.joint_state.name = list(positions)
    message.joint_state.position = list(positions.values())
    message.multi_dof_joint_state.header.frame_id = frame
    message.attached_collision_objects = [write_attached(one) for one in attached]
    return message


def write_trajectory(plan: MotionPlan, frame: str) -> Any:
    """Return a plan as a RobotTrajectory."""
    return get_message("moveit_msgs/msg/RobotTrajectory")(
        joint_trajectory=write_joint_trajectory(plan, frame)
    )


def error_code(code: int, message: str = "") -> Any:
    """Return MoveItErrorCodes with a code and a message."""
    made: Any = get_message("moveit_msgs/msg/MoveItErrorCodes")(val=int(code))
    if message:
        made.message, made.source = message, "move_group"
    return made


def in_order(values: Mapping[str, float], names: Sequence[str]) -> list[float]:
    """Return values by name in an order."""
    return [values[name] for name in names]
