"""Means of locomotion of a robot, by which its root link is free or fixed to the world.

A URDF does not state whether a robot is bolted down. Gazebo lets every root link fall that has no
parent named ``world``, so that arms topple with their authors' own files; MuJoCo's importer and
RViz fix every root link, so that no robot drives. Here the shapes of the robot in its start pose
decide: a robot that stands on wheels or legs, flies, swims or crawls is free, and so is one without
joints, such as a box. All others, such as an arm, a gripper or a door, are fixed to the world.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import motion_plugins

if TYPE_CHECKING:
    from collections.abc import Mapping

    from teleopctl.robot import RobotDescription

Array = npt.NDArray[np.float64]

# Parts of the file names (without punctuation) of Gazebo plug-ins that lift, push or drive a whole
# robot.
_DRIVING_PLUGINS = (
    *("multicopter", "thruster", "liftdrag", "hydrodynamics", "buoyancy", "velocitycontrol"),
    *("diffdrive", "planarmove", "ackermann", "mecanum", "skidsteer", "trackedvehicle"),
)

# A joint with a larger range than this (rad) counts as endless; arm joints have up to two turns.
_ENDLESS_RAD = 4.0 * math.pi + 1e-6
# Cosine with the vertical up to which an axis can be a wheel's, and from which it can be a rotor's.
_LYING, _UPRIGHT = 0.5, 0.7
# A wheel reaches the ground if its lowest point is at most this fraction of its radius above the
# robot's lowest point.
_WHEEL_GAP = 0.5
# The smallest extent of a wheel from its axis is at least this fraction of its largest one. A
# square, which stands for a wheel in some descriptions, has 0.71.
_ROUND = 0.65
# Feet are on one level, and the root link is above it, within this fraction of the robot's height.
_LEVEL = 0.06
# At most this number of joints between root link and hips, and hips are above the ground by more
# than this fraction of the robot's height: the fingers of an arm that hangs down are not legs.
_WAIST_JOINTS, _SHORTEST_LEG = 3, 0.1
# A crawling robot has at least this number of joints, and this fraction of its links on the ground.
_CRAWLING_JOINTS, _CRAWLING_LINKS = 4, 0.7

_Kind = mujoco.mjtGeom
_UNUSED = 5
# A tetrahedron.
_CORNERS = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
_SIDES = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]


def is_free_by_design(description: RobotDescription) -> bool:
    """Return whether a robot has no joints at all, or plug-ins that move it as a whole.

    Raises:
        InvalidDescriptionError: A ``<gazebo>`` tag is not well formed.
    """
    if all(joint.type == "fixed" for joint in description.joints.values()):
        return True
    files = [
        "".join(filter(str.isalnum, plugin.filename.lower()))
        for plugin in description.gazebo.plugins
    ]
    named = any(part in file for file in files for part in _DRIVING_PLUGINS)
    return named or motion_plugins(description).drive_the_base


def locomotion_of(shapes: RobotShapes, description: RobotDescription) -> str:
    """Return a robot's locomotion: ``wheels``, ``legs``, ``rotors`` …; empty if it must be fixed.

    Args:
        shapes: Shapes of the robot in its starting pose.
        description: The robot.
    """
    if _has_wheels(shapes, description):
        return "wheels"
    if _has_legs(shapes):
        return "legs"
    if _has_rotors(shapes, description):
        return "rotors"
    return "joints along the ground" if _is_crawler(shapes) else ""


class RobotShapes:
    """Shapes of a robot in its starting pose, in the root link's frame.

    Args:
        spec: The ``mujoco.MjSpec`` of the robot alone, its root link fixed and its meshes resolved;
            it is not changed.
        start: Starting positions of the joints by name, in rad or m.

    Attributes:
        model: The compiled ``mujoco.MjModel``.
        data: Its ``mujoco.MjData``, with the joints at their starting positions.
        bodies: Indices of the robot's links.
        lowest: Height of the lowest point of each body, (nbody,) in m.
        ground: Height of the robot's lowest point, in m.
        height: Height of the robot's highest point above ``ground``, in m.

    Raises:
        InvalidDescriptionError: MuJoCo rejects the description.
    """

    def __init__(self, spec: mujoco.MjSpec, start: Mapping[str, float]) -> None:
        try:
            self.model = m = _bare(spec).compile()
        except ValueError as error:
            message = " ".join(str(error).split())
            raise InvalidDescriptionError(
                f"The robot description cannot be simulated: {message}"
            ) from error
        self.data = data = mujoco.MjData(m)
        for name, position in start.items():
            data.joint(name).qpos[0] = position
        mujoco.mj_kinematics(m, data)
        self.bodies = range(1, m.nbody)
        self.lowest = np.full(m.nbody, math.inf)
        for body in self.bodies:
            self.lowest[body] = min(points[:, 2].min() for points in self.points(body))
        self.ground = float(self.lowest.min())
        top = max(points[:, 2].max() for body in self.bodies for points in self.points(body))
        self.height = float(top) - self.ground

    def points(self, body: int) -> Iterator[Array]:
        """Yield corner points per collision (or visual) shape of a body; its origin without any."""
        m, data = self.model, self.data
        first, count = int(m.body_geomadr[body]), int(m.body_geomnum[body])
        for geom in range(first, first + count):
            if m.geom_group[geom] == _UNUSED:
                continue
            frame = data.geom_xmat[geom].reshape(3, 3)
            yield data.geom_xpos[geom] + _corners(m, geom) @ frame.T
        if not count:
            yield data.xpos[body].reshape(1, 3)

    def below(self, body: int) -> list[int]:
        """Return a body and all its descendants in the kinematic tree."""
        found = [body]
        for later in range(body + 1, self.model.nbody):
            if self.model.body_parentid[later] in found:
                found.append(later)
        return found

    def chain(self, body: int) -> list[int]:
        """Return the moving bodies from the root link to a body, one per rigid group."""
        groups = list[int]()
        while group := int(self.model.body_weldid[body]):
            groups.insert(0, group)
            body = int(self.model.body_parentid[group])
        return groups

    @property
    def lowest_that_moves(self) -> float:
        """Height of the lowest point of the moving links, in metres; infinite without any."""
        moving = (body for body in self.bodies if self.model.body_weldid[body])
        return min((float(self.lowest[body]) for body in moving), default=math.inf)

    def root_group(self) -> list[int]:
        """Return the bodies of the root link and of the links that are fixed to it."""
        return [body for body in self.bodies if self.model.body_weldid[body] == 0]


def _bare(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """Return a copy that compiles fast: shapes in their places, without hulls, masses and paint."""
    spec = spec.copy()
    used = set()
    for body in spec.bodies[1:]:
        # Masses are repaired later; these placeholders are valid for MuJoCo.
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        body.fullinertia = np.full(6, np.nan)
        touching = any(geom.contype for geom in body.geoms)
        for geom in body.geoms:
            if touching and not geom.contype:
                # Not deleted: MjSpec takes 10 ms to delete a shape.
                geom.type, geom.meshname, geom.size = _Kind.mjGEOM_SPHERE, "", np.ones(3)
                geom.group = _UNUSED
            else:
                used.add(geom.meshname)
            geom.contype = geom.conaffinity = 0
    for mesh in spec.meshes:
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        if mesh.name not in used:
            mesh.file, mesh.uservert, mesh.userface = "", _CORNERS, _SIDES
            mesh.usernormal, mesh.usertexcoord = [], []
            mesh.userfacenormal, mesh.userfacetexcoord = [], []
    return spec


def _corners(m: mujoco.MjModel, geom: int) -> Array:
    """Return points that span a shape, in its own frame, (n, 3) in m."""
    a, b, c = m.geom_size[geom]
    match m.geom_type[geom]:
        case _Kind.mjGEOM_BOX:
            return np.array([[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)])
        case _Kind.mjGEOM_SPHERE:
            ball: Array = a * _SPHERE
            return ball
        case _Kind.mjGEOM_CYLINDER:
            return np.vstack([_CIRCLE * a + [0.0, 0.0, z] for z in (-b, b)])
        case _Kind.mjGEOM_CAPSULE:
            return np.vstack([_SPHERE * a + [0.0, 0.0, z] for z in (-b, b)])
        case _Kind.mjGEOM_MESH:
            mesh = int(m.geom_dataid[geom])
            first, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
            return np.array(m.mesh_vert[first : first + count], float)
        case _:
            return np.zeros((1, 3))


_TURNS = np.linspace(0.0, 2.0 * math.pi, 24, endpoint=False)
_CIRCLE = np.column_stack([np.cos(_TURNS), np.sin(_TURNS), np.zeros_like(_TURNS)])
_SPHERE = np.vstack([np.roll(_CIRCLE, turn, axis=1) for turn in range(3)])


def _endless(shapes: RobotShapes, description: RobotDescription) -> Iterator[int]:
    """Yield the joints that can turn endlessly."""
    m = shapes.model
    for joint in range(m.njnt):
        if m.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE:
            continue
        lower, upper = m.jnt_range[joint]
        kind = description.joints[m.joint(joint).name].type
        if kind == "continuous" or (m.jnt_limited[joint] and upper - lower > _ENDLESS_RAD):
            yield joint


def _has_wheels(shapes: RobotShapes, description: RobotDescription) -> bool:
    """Whether a round link on an endless joint with a horizontal axis reaches the ground."""
    for joint in _endless(shapes, description):
        anchor, axis = shapes.data.xanchor[joint], shapes.data.xaxis[joint]
        bodies = shapes.below(int(shapes.model.jnt_bodyid[joint]))
        lowest = float(shapes.lowest[bodies].min())
        radius = float(anchor[2]) - lowest
        if abs(axis[2]) > _LYING or lowest - shapes.ground > _WHEEL_GAP * radius:
            continue
        points = np.vstack([points for body in bodies for points in shapes.points(body)])
        if _is_round(points - anchor, axis):
            return True
    return False


def _is_round(points: Array, axis: Array) -> bool:
    """Whether points about the origin, (n, 3), reach about equally far all around an axis."""
    first = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    first /= np.linalg.norm(first)
    directions = _CIRCLE @ np.vstack([first, np.cross(axis, first), axis])
    reach = (points @ directions.T).max(axis=0)
    return bool(reach.min() > _ROUND * reach.max())


def _has_legs(shapes: RobotShapes) -> bool:
    """Whether chains of joints that branch at the hips end on the ground, below the root link."""
    m, level = shapes.model, shapes.ground + _LEVEL * shapes.height
    if shapes.lowest[shapes.root_group()].min() <= level:
        return False
    feet = {int(m.body_weldid[b]) for b in shapes.bodies if shapes.lowest[b] <= level}
    chains = [shapes.chain(foot) for foot in feet]
    # A foot with other feet among its descendants is a part of their legs.
    legs = [chain for chain in chains if sum(chain[-1] in other for other in chains) == 1]
    if len(legs) < 2:
        return False
    shared = [one for one, *others in zip(*legs, strict=False) if {*others} == {one}]
    hip = min(float(shapes.data.xpos[leg[len(shared)]][2]) for leg in legs)
    return len(shared) <= _WAIST_JOINTS and hip - shapes.ground > _SHORTEST_LEG * shapes.height


def _has_rotors(shapes: RobotShapes, description: RobotDescription) -> bool:
    """Whether all joints are propellers': several, endless, upright, without child links."""
    m = shapes.model
    endless = {*_endless(shapes, description)}
    upright = np.abs(shapes.data.xaxis[:, 2]) > _UPRIGHT
    leaves = all(
        int(m.jnt_bodyid[joint]) not in m.body_weldid[m.body_parentid] for joint in endless
    )
    return len(endless) > 1 and len(endless) == m.njnt and bool(upright.all()) and leaves


def _is_crawler(shapes: RobotShapes) -> bool:
    """Whether nearly all links of a long chain lie on the ground."""
    m = shapes.model
    groups: dict[int, float] = {}
    for body in shapes.bodies:
        group = int(m.body_weldid[body])
        groups[group] = min(groups.get(group, math.inf), float(shapes.lowest[body]))
    on_ground = [low for low in groups.values() if low <= shapes.ground + _LEVEL * shapes.height]
    return m.njnt >= _CRAWLING_JOINTS and len(on_ground) >= _CRAWLING_LINKS * len(groups)
