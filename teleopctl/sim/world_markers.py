"""Markers of the world's shapes, for RViz and the web page.

Markers are published once and move by ``/tf``: those of static shapes are locked to the frame at
the world's origin, those of moving shapes to the frame of their body.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import RobotModel, free_root
from teleopctl.node import qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.node import Node, Publisher

WORLD_MARKERS_TOPIC = "/mujoco_sim/world_markers"

# Any stands for messages, whose classes are made at run time, and for MuJoCo's types.
_Marker = get_message("visualization_msgs/msg/Marker")
_MarkerArray = get_message("visualization_msgs/msg/MarkerArray")
_Point = get_message("geometry_msgs/msg/Point")

Array = npt.NDArray[np.float64]
_Kind = mujoco.mjtGeom
# MuJoCo does not draw shapes from this group on: they are for contacts only.
_FIRST_HIDDEN_GROUP = 3
# MuJoCo's default colour of a shape; with it, the material's colour counts.
_UNSET_RGBA = np.array([0.5, 0.5, 0.5, 1.0], np.float32)


class WorldMarkers:
    """Publisher of the world's shapes as a latched MarkerArray.

    Args:
        node: Node of the publisher.
        model: Model of the robot and its world.
    """

    def __init__(self, node: Node, model: RobotModel) -> None:
        self._node = node
        self._publisher: Publisher[Any] | None = None
        self._readers = 0
        markers = world_markers(model)
        if markers:
            self._publish(markers)

    def replace_model(self, model: RobotModel) -> None:
        """Delete the published markers, and publish those of another model."""
        self._publish([_Marker(action=_Marker.DELETEALL), *world_markers(model)])

    def _publish(self, markers: list[Any]) -> None:
        if self._publisher is None:
            self._publisher = self._node.create_publisher(
                _MarkerArray, WORLD_MARKERS_TOPIC, qos_profile_latched
            )
        self._message = _MarkerArray(markers=markers)
        self._publisher.publish(self._message)

    def on_graph_change(self) -> None:
        """Publish the markers again if there are new subscribers; called when the graph changed."""
        if self._publisher is None:
            return
        before, self._readers = self._readers, self._publisher.get_subscription_count()
        if self._readers > before:
            self._publisher.publish(self._message)


def world_markers(model: RobotModel) -> list[Any]:
    """Return RViz markers of the drawn shapes of a model's world, without planes and heightmaps.

    Args:
        model: Model of the robot and its world.
    """
    m = model.mj_model
    data = mujoco.MjData(m)
    mujoco.mj_kinematics(m, data)
    markers: list[Any] = []
    for geom in model.world_geoms:
        if m.geom_group[geom] >= _FIRST_HIDDEN_GROUP:
            continue
        body = int(m.geom_bodyid[geom])
        carrier = free_root(m, body)
        # Pose of the shape in the frame that carries it.
        turn = data.xmat[carrier].reshape(3, 3)
        place = turn.T @ (data.geom_xpos[geom] - data.xpos[carrier])
        rotation = turn.T @ data.geom_xmat[geom].reshape(3, 3)
        for marker in _shapes(m, geom, place, rotation):
            marker.header.frame_id = m.body(carrier).name if carrier else model.world_frame
            marker.frame_locked = True
            marker.ns, marker.id = m.body(body).name, len(markers)
            markers.append(marker)
    return markers


def _shapes(m: Any, geom: int, place: Array, rotation: Array) -> Iterator[Any]:
    """Yield markers that together draw a shape; none for planes and heightmaps, the ground."""
    a, b, c = (float(size) for size in m.geom_size[geom])
    color = _color(m, geom)
    match m.geom_type[geom]:
        case _Kind.mjGEOM_BOX:
            yield _marker(_Marker.CUBE, place, rotation, (2 * a, 2 * b, 2 * c), color)
        case _Kind.mjGEOM_SPHERE:
            yield _marker(_Marker.SPHERE, place, rotation, (2 * a, 2 * a, 2 * a), color)
        case _Kind.mjGEOM_ELLIPSOID:
            yield _marker(_Marker.SPHERE, place, rotation, (2 * a, 2 * b, 2 * c), color)
        case _Kind.mjGEOM_CYLINDER:
            yield _marker(_Marker.CYLINDER, place, rotation, (2 * a, 2 * a, 2 * b), color)
        case _Kind.mjGEOM_CAPSULE:
            yield _marker(_Marker.CYLINDER, place, rotation, (2 * a, 2 * a, 2 * b), color)
            for end in (b, -b):
                tip = place + rotation @ np.array([0.0, 0.0, end])
                yield _marker(_Marker.SPHERE, tip, rotation, (2 * a, 2 * a, 2 * a), color)
        case _Kind.mjGEOM_MESH:
            marker = _marker(_Marker.TRIANGLE_LIST, place, rotation, (1.0, 1.0, 1.0), color)
            marker.points = _triangles(m, int(m.geom_dataid[geom]))
            yield marker


def _marker(
    kind: int, place: Array, rotation: Array, scale: tuple[float, ...], color: list[float]
) -> Any:
    marker = _Marker(type=kind)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, rotation.ravel())
    position, turn = marker.pose.position, marker.pose.orientation
    position.x, position.y, position.z = place.tolist()
    turn.w, turn.x, turn.y, turn.z = quaternion.tolist()
    marker.scale.x, marker.scale.y, marker.scale.z = scale
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = color
    return marker


def _color(m: Any, geom: int) -> list[float]:
    rgba, material = m.geom_rgba[geom], int(m.geom_matid[geom])
    if material >= 0 and np.array_equal(rgba, _UNSET_RGBA):
        rgba = m.mat_rgba[material]
    return [float(part) for part in rgba]


def _triangles(m: Any, mesh: int) -> list[Any]:
    first, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
    vertices = m.mesh_vert[first : first + count]
    first, count = int(m.mesh_faceadr[mesh]), int(m.mesh_facenum[mesh])
    corners = vertices[m.mesh_face[first : first + count].ravel()].tolist()
    return [_Point(x=x, y=y, z=z) for x, y, z in corners]
