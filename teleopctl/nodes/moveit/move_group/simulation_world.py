"""The simulator's world as objects of the planning scene: ``world_from_simulation``."""

from __future__ import annotations

from typing import Any

import numpy as np

from teleopctl.commander import read_pose
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import CollisionBody, CollisionShape, PlanningError, ShapeKind
from teleopctl.node import qos_profile_latched
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.parameters import setting
from teleopctl.sim import WORLD_MARKERS_TOPIC

SIMULATED_DB = "mujoco_sim"
"""``type.db`` of the objects: clients that draw the simulator's world need not draw them again."""

# Polling period of the poses of moving bodies, s, and the least change that counts, m.
_PERIOD_S, _MOVED_M = 0.5, 5e-4
# The floor of the simulation, and its frame where the robot does not stand on it by itself.
_FLOOR, _WORLD = "floor", "world"
# Depth, m, from which a link that moves is taken to be below the floor on purpose, and distance up
# to which it stands or rolls on it.
_BELOW_M, _ON_M = 0.01, 0.002

# Any, here and below: message classes are generated at run time from definitions.
_Marker: Any = get_message("visualization_msgs/msg/Marker")


class SimulationWorld:
    """Subscriber of the shapes of the simulator's world.

    Fixed bodies are obstacles, and so is the floor at z = 0 of the world, unless links that move
    are below it; links that stand on it may touch it. Bodies that move freely are obstacles for the
    arm, and may be touched by the gripper, so that it can grasp them; they follow their frames.

    Args:
        context: Robot, state and scene.
    """

    def __init__(self, context: MoveGroupContext) -> None:
        self._context, node = context, context.node
        self._log = node.get_logger()
        self._frames: dict[str, tuple[str, np.ndarray]] = {}
        self._gripper = _gripper_links(context)
        node.create_subscription(
            get_message("visualization_msgs/msg/MarkerArray"),
            WORLD_MARKERS_TOPIC,
            self._on_markers,
            qos_profile_latched,
        )
        self._timer = node.create_timer(_PERIOD_S, self._follow)
        self._has_floor = bool(setting(node, "floor", default=True))

    def _on_markers(self, message: Any) -> None:
        """Replace the objects of the simulator by those of a message of all its shapes."""
        context = self._context
        groups: dict[tuple[str, str], list[Any]] = {}
        for marker in message.markers:
            if marker.action == _Marker.ADD:
                groups.setdefault((marker.ns, marker.header.frame_id), []).append(marker)
        names = []
        free = []
        with context.lock:
            for name in [
                n for n, one in context.scene.objects.items() if one.is_simulated and n != _FLOOR
            ]:
                context.scene.remove(name)
            self._frames.clear()
            for (name, frame), markers in groups.items():
                try:
                    one = self._object(name, frame, markers)
                except TeleopctlError as error:
                    self._log.warning(f"'{name}' of the simulation is no obstacle: {error.message}")
                    continue
                if name in context.scene.attached:
                    continue
                context.scene.add(one)
                names.append(name)
                if one.is_free:
                    free.append(name)
                    for link in self._gripper:
                        context.scene.allowed.set(name, link, is_allowed=True)
        context.scene_changed()
        self._log.info(f"Obstacles of the simulation: {', '.join(names) or 'none'}")
        if free and self._gripper:
            self._log.info(
                f"The gripper ({', '.join(self._gripper)}) may touch what moves freely: "
                f"{', '.join(free)}"
            )

    def _add_floor(self) -> None:
        """Add the floor, once the state of the joints is known."""
        context = self._context
        if _FLOOR in context.scene.objects or not context.measured():
            return
        self._has_floor = False
        try:
            at = context.frame(_WORLD)
        except PlanningError:
            # The robot stands at the origin.
            at = np.eye(4)
        plane = CollisionShape.plane(0.0, 0.0, 1.0, 0.0)
        floor = CollisionBody(_FLOOR, at, (plane,), (np.eye(4),), is_simulated=True)
        with context.lock:
            context.update_state()
            before = context.scene.copy()
            context.scene.add(floor)
            on: list[str] = []
            below: list[str] = []
            for one in context.scene.compile().clearance.near(_ON_M):
                if _FLOOR in one.bodies:
                    (link,) = {*one.bodies} - {_FLOOR}
                    if link in context.scene.model.links:
                        (below if one.distance_m < -_BELOW_M else on).append(link)
            if below:
                context.scene.restore(before)
            for link in () if below else on:
                context.scene.allowed.set(_FLOOR, link, is_allowed=True)
        if below:
            self._log.info(
                f"The floor of the simulation is no obstacle: {', '.join(below)} is below it"
            )
            return
        context.scene_changed()
        self._log.info(
            "The floor of the simulation is an obstacle (parameter floor: false for none)"
            + (f"; {', '.join(on)} may touch it" if on else "")
        )

    def _object(self, name: str, frame: str, markers: list[Any]) -> CollisionBody:
        at = self._context.frame(frame)
        # Shapes that move are in the frame of their body, which has its name.
        is_free = frame == name
        shapes, poses = [], []
        for marker in markers:
            shapes.append(_shape(marker))
            poses.append(read_pose(marker.pose, f"'{name}' of the simulation"))
        if is_free:
            self._frames[name] = (frame, at)
        return CollisionBody(
            name,
            at,
            tuple(shapes),
            tuple(poses),
            type=("", SIMULATED_DB),
            is_free=is_free,
            is_simulated=True,
        )

    def _follow(self) -> None:
        """Move the bodies that move freely to where their frames are."""
        context = self._context
        if self._has_floor:
            self._add_floor()
        is_moved = False
        for name, (frame, before) in list(self._frames.items()):
            if name not in context.scene.objects:
                continue
            try:
                now = context.transform(frame)
            except PlanningError:
                continue
            if float(np.abs(now - before).max()) < _MOVED_M:
                continue
            with context.lock:
                if name in context.scene.objects:
                    context.scene.move(name, now)
                    is_moved = True
            self._frames[name] = (frame, now)
        if is_moved:
            context.scene_changed()


def _gripper_links(context: MoveGroupContext) -> list[str]:
    groups, joints = context.groups, context.scene.model.description.joints
    links: dict[str, None] = {}
    for effector in groups.end_effectors.values():
        links[effector.parent_link] = None
        group = groups.groups.get(effector.group)
        for name in group.joints if group is not None else ():
            links[joints[name].child] = None
    return list(links)


def _shape(marker: Any) -> CollisionShape:
    x, y, z = marker.scale.x, marker.scale.y, marker.scale.z
    if marker.type == _Marker.CUBE:
        return CollisionShape.primitive(ShapeKind.BOX, (x, y, z))
    if marker.type == _Marker.SPHERE:
        return CollisionShape.primitive(ShapeKind.SPHERE, (0.5 * max(x, y, z),))
    if marker.type == _Marker.CYLINDER:
        return CollisionShape.primitive(ShapeKind.CYLINDER, (z, 0.5 * max(x, y)))
    if marker.type == _Marker.TRIANGLE_LIST:
        points = np.array([(p.x, p.y, p.z) for p in marker.points], np.float64).reshape(-1, 3)
        return CollisionShape.mesh(points, np.arange(len(points), dtype=np.intp).reshape(-1, 3))
    raise UsageError(f"Markers of type {marker.type} are no shapes")
