"""Conversion between Pose and Twist messages and arrays in the world's frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidMessageError, NotFoundError
from teleopctl.sim.free_bodies import LinkPose
from teleopctl.sim.request_numbers import invalid_number_reason

if TYPE_CHECKING:
    from teleopctl.sim.simulation import Simulation

Array = npt.NDArray[np.float64]

# Largest difference of a quaternion's length from 1.
_LENGTH_ERROR = 1e-2


def frame_of(simulation: Simulation, name: str) -> LinkPose | None:
    """Return the world pose of the link that a ``frame_id`` names; None for the world itself.

    Raises:
        NotFoundError: There is no link of that name.
    """
    if name in ("", "world", simulation.model.world_frame):
        return None
    if not simulation.has_link(name):
        raise NotFoundError(f"There is no link '{name}' to use as a frame")
    return simulation.link_pose(name)


# Any, here and below: messages, whose classes are made at run time.
def pose_in_world(message: Any, frame: LinkPose | None) -> Array:
    """Return a Pose message, relative to ``frame``, as world position (m) and w x y z, (7,).

    Raises:
        InvalidMessageError: A number is invalid, or the orientation is not a rotation.
    """
    p, q = message.position, message.orientation
    place, turn = np.array([p.x, p.y, p.z]), np.array([q.w, q.x, q.y, q.z])
    if reason := invalid_number_reason([*place, *turn]):
        raise InvalidMessageError(f"A number of the pose {reason}")
    length = float(np.linalg.norm(turn))
    if abs(length - 1.0) > _LENGTH_ERROR:
        raise InvalidMessageError(
            f"The orientation is not a unit quaternion: its norm is {length:g}"
        )
    turn /= length
    if frame is None:
        return np.concatenate([place, turn])
    rotation = np.zeros(4)
    mujoco.mju_mulQuat(rotation, frame.quaternion, turn)
    return np.concatenate([frame.position + frame.rotation @ place, rotation])


def twist_in_world(message: Any, frame: LinkPose | None) -> Array:
    """Return a Twist message along ``frame``'s axes as linear, angular world velocity, (6,).

    Raises:
        InvalidMessageError: A number is invalid.
    """
    v, w = message.linear, message.angular
    twist = np.array([v.x, v.y, v.z, w.x, w.y, w.z])
    if reason := invalid_number_reason(twist):
        raise InvalidMessageError(f"A number of the velocity {reason}")
    if frame is not None:
        twist = np.concatenate([frame.rotation @ twist[:3], frame.rotation @ twist[3:]])
    return twist


def fill_pose(message: Any, pose: Array) -> None:
    """Set a Pose message from position and quaternion w x y z, (7,)."""
    p, q = message.position, message.orientation
    p.x, p.y, p.z, q.w, q.x, q.y, q.z = map(float, pose)


def fill_twist(message: Any, twist: Array) -> None:
    """Set a Twist or Accel message from linear and angular parts, (6,)."""
    v, w = message.linear, message.angular
    v.x, v.y, v.z, w.x, w.y, w.z = map(float, twist)
