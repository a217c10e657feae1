"""Closed and open positions of a gripper's joints, computed from its shapes."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.groups import JointGroup
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array

_HINGE, _MESH = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtGeom.mjGEOM_MESH
# Points of a palm that are at least this part as far from the axis as a finger's tip face it.
_FACING = 0.5
# Range (rad or m) of a joint without a limit.
_DEFAULT_RANGE = 1.0


class GripperRange(NamedTuple):
    """Positions of a gripper's independent joint: closed and open, rad or m.

    Attributes:
        joint: Name of the joint.
        closed: Position at which the fingers are nearest to each other.
        open: Position at which they are farthest apart.
    """

    joint: str
    closed: float
    open: float

    def position(self, opening: float) -> float:
        """Return the position of an opening, from 0 (closed) to 1 (open)."""
        return self.closed + opening * (self.open - self.closed)


def gripper_ranges(model: KinematicModel, gripper: JointGroup) -> list[GripperRange]:
    """Return the closed and the open position of each independent joint of a gripper.

    A finger's tip is the point of it that is farthest from the axis of its joint. The side of a
    joint's range at which tips are farther apart is the open one. A single finger closes towards
    the link that it moves on: on what is at least half as far from the axis as its tip.

    Args:
        model: Model of the robot, whose state is not changed.
        gripper: Group of the gripper.

    Raises:
        UsageError: The group has no independent joint.
    """
    joints = model.joints
    names = [name for name in gripper.joints if joints[name].mimic is None]
    if not names:
        raise UsageError(f"The group '{gripper.name}' has no joint that moves by itself")
    before = model.positions()
    ranges = {}
    for name in names:
        lower, upper = joints[name].limits.lower, joints[name].limits.upper
        lower = lower if np.isfinite(lower) else -_DEFAULT_RANGE
        ranges[name] = (lower, upper if np.isfinite(upper) else max(lower, 0.0) + _DEFAULT_RANGE)
    middle = {name: 0.5 * (lower + upper) for name, (lower, upper) in ranges.items()}
    found = []
    try:
        for name, (lower, upper) in ranges.items():
            model.set_positions(middle)
            fingers = _fingers(model, gripper)
            tips = [_tip(model, link, joint) for link, joint in fingers.items()]
            palm = None
            if len(fingers) == 1:
                (joint,) = fingers.values()
                palm = _palm(model, joint, tips[0])
            spreads = []
            for position in (lower, upper):
                model.set_positions({**middle, name: position})
                spreads.append(_spread(model, tips) if palm is None else _gap(model, tips[0], palm))
            is_rising = spreads[1] >= spreads[0]
            found.append(GripperRange(name, *((lower, upper) if is_rising else (upper, lower))))
    finally:
        model.set_positions(before)
    return found


# A body of MuJoCo by its number, with a point, (3,), or points, (k, 3), in its frame.
_OnBody = tuple[int, Array]


def _fingers(model: KinematicModel, gripper: JointGroup) -> dict[str, str]:
    """Return the last link of each finger, with the joint that moves it."""
    joints = model.description.joints
    parents = {joints[name].parent for name in gripper.joints}
    return {link: name for name in gripper.joints if (link := joints[name].child) not in parents}


def _palm(model: KinematicModel, joint: str, tip: _OnBody) -> _OnBody:
    """Return points of the link that a single finger moves on, which it may close on."""
    body = model.body(model.description.joints[joint].parent)
    points = _points(model.mj_model, body)
    reach = _radii(model, *tip, joint)[0]
    facing = points[_radii(model, body, points, joint) >= _FACING * reach]
    return body, facing if len(facing) else points


def _radii(model: KinematicModel, body: int, points: Array, joint: str) -> Array:
    """Return the distances of points of a body from the axis of a joint, (k,), m."""
    m, data = model.mj_model, model.mj_data
    number = m.joint(joint).id
    world = np.atleast_2d(points) @ data.xmat[body].reshape(3, 3).T + data.xpos[body]
    from_axis, axis = world - data.xanchor[number], data.xaxis[number]
    if m.jnt_type[number] == _HINGE:
        from_axis = from_axis - np.outer(from_axis @ axis, axis)
    return np.asarray(np.linalg.norm(from_axis, axis=1))


def _tip(model: KinematicModel, link: str, joint: str) -> _OnBody:
    """Return the body of a link and its point that is farthest from a joint's axis."""
    m = model.mj_model
    body = model.body(link)
    points = _points(m, body)
    if m.jnt_type[m.joint(joint).id] == _HINGE:
        return body, points[int(np.argmax(_radii(model, body, points, joint)))]
    # A finger that slides moves as a whole.
    return body, points.mean(axis=0)


def _points(m: Any, body: int) -> Array:
    """Return points of a body's shapes in its frame, (k, 3): vertices, or corners of boxes."""
    found = [np.zeros((1, 3))]
    first, count = int(m.body_geomadr[body]), int(m.body_geomnum[body])
    for geom in range(first, first + count):
        mesh = int(m.geom_dataid[geom])
        if m.geom_type[geom] == _MESH and mesh >= 0:
            start = int(m.mesh_vertadr[mesh])
            local = m.mesh_vert[start : start + int(m.mesh_vertnum[mesh])]
        else:
            # Half the edges of the box around the shape, about its centre.
            half, center = m.geom_aabb[geom, 3:], m.geom_aabb[geom, :3]
            local = center + half * np.array(np.meshgrid(*[(-1, 1)] * 3)).T.reshape(-1, 3)
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, m.geom_quat[geom])
        found.append(local @ rotation.reshape(3, 3).T + m.geom_pos[geom])
    points = np.vstack(found)
    return points[1:] if len(points) > 1 else points


def _spread(model: KinematicModel, tips: list[_OnBody]) -> float:
    """Return the mean distance of tips from their centre, m."""
    world = np.array([_world(model, *tip) for tip in tips])
    return float(np.linalg.norm(world - world.mean(axis=0), axis=1).mean())


def _gap(model: KinematicModel, tip: _OnBody, palm: _OnBody) -> float:
    """Return the distance of a tip from the nearest of the palm's points, m."""
    return float(np.linalg.norm(_world(model, *palm) - _world(model, *tip), axis=1).min())


def _world(model: KinematicModel, body: int, points: Array) -> Array:
    data = model.mj_data
    return np.asarray(points @ data.xmat[body].reshape(3, 3).T + data.xpos[body])
