"""Grippers: which positions of their joints are open and which closed, by their shapes."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.groups import JointGroup
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array

_HINGE, _MESH = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtGeom.mjGEOM_MESH
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
    joint's range at which tips are farther apart is the open one; a single finger is compared with
    the link that it moves on.

    Args:
        model: Model of the robot, whose state is not changed.
        gripper: Group of the gripper.

    Raises:
        UsageError: No joint of the group moves by itself.
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
            tips = _tips(model, gripper)
            spreads = []
            for position in (lower, upper):
                model.set_positions({**middle, name: position})
                spreads.append(_spread(model, tips))
            is_rising = spreads[1] >= spreads[0]
            found.append(GripperRange(name, *((lower, upper) if is_rising else (upper, lower))))
    finally:
        model.set_positions(before)
    return found


def _tips(model: KinematicModel, gripper: JointGroup) -> list[tuple[int, Array]]:
    """Return the tip of each finger, (3,), in the frame of its body, with MuJoCo's number of it."""
    description = model.description
    moved = {description.joints[name].child: name for name in gripper.joints}
    parents = {description.joints[name].parent for name in gripper.joints}
    # The last links of fingers with several.
    fingers = [link for link in moved if link not in parents]
    tips = [_tip(model, link, moved[link]) for link in fingers]
    if len(fingers) == 1:
        name = moved[fingers[0]]
        tips.append(_tip(model, description.joints[name].parent, name))
    return tips


def _tip(model: KinematicModel, link: str, joint: str) -> tuple[int, Array]:
    """Return the body of a link and its point that is farthest from a joint's axis."""
    m, data = model.mj_model, model.mj_data
    body, number = model.body(link), m.joint(joint).id
    points = _points(m, body)
    world = points @ data.xmat[body].reshape(3, 3).T + data.xpos[body]
    from_axis = world - data.xanchor[number]
    axis = data.xaxis[number]
    if m.jnt_type[number] == _HINGE:
        from_axis = from_axis - np.outer(from_axis @ axis, axis)
        return body, points[int(np.argmax(np.linalg.norm(from_axis, axis=1)))]
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


def _spread(model: KinematicModel, tips: list[tuple[int, Array]]) -> float:
    """Return the mean distance of tips from their centre, m."""
    data = model.mj_data
    world = np.array([data.xmat[b].reshape(3, 3) @ point + data.xpos[b] for b, point in tips])
    return float(np.linalg.norm(world - world.mean(axis=0), axis=1).mean())
