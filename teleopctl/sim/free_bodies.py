"""Poses of links, and poses and velocities of free bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from teleopctl.mujoco_model import FreeBody

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class LinkPose:
    """Pose of a link's frame in the world.

    Attributes:
        position: Position of the frame's origin, (3,), in metres.
        quaternion: Rotation of the frame, (4,), w x y z.
        rotation: Rotation of the frame as a matrix, (3, 3).
    """

    position: Array
    quaternion: Array
    rotation: Array


class FreeBodies:
    """Access to the poses and velocities of free bodies in MuJoCo's data.

    Args:
        model: The ``mujoco.MjModel``.
        data: Its ``mujoco.MjData``.
        bodies: The freely moving bodies.

    Attributes:
        bodies: The freely moving bodies.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, bodies: Sequence[FreeBody]
    ) -> None:
        self.bodies = tuple(bodies)
        self._d = data
        joints = [model.joint(body.joint) for body in bodies]
        self._qpos = [int(joint.qposadr[0]) for joint in joints]
        self._dof = [int(joint.dofadr[0]) for joint in joints]
        self._row = {body.link: row for row, body in enumerate(bodies)}

    def index(self, link: str) -> int | None:
        """Return a link's number among the free bodies; None if the link is none of them."""
        return self._row.get(link)

    def pose(self, index: int) -> Array:
        """Return a free body's position (m) and quaternion w x y z in the world, (7,)."""
        start = self._qpos[index]
        return np.array(self._d.qpos[start : start + 7])

    def twist(self, index: int) -> Array:
        """Return a free body's linear (m/s) and angular (rad/s) velocity in the world, (6,)."""
        start = self._dof[index]
        twist = np.array(self._d.qvel[start : start + 6])
        # MuJoCo has the linear part in the world's frame, the angular one in the body's.
        mujoco.mju_rotVecQuat(twist[3:], twist[3:].copy(), self.pose(index)[3:])
        return twist

    def put(self, index: int, pose: Array, twist: Array | None = None) -> None:
        """Set a free body's pose and velocity in the world; velocity zero without ``twist``.

        Args:
            index: Index of the body, see `index`.
            pose: Pose as `pose` returns it; the quaternion need not have unit length.
            twist: Velocity as `twist` returns it; zero by default.
        """
        start, dof = self._qpos[index], self._dof[index]
        quaternion = np.array(pose[3:])
        mujoco.mju_normalize4(quaternion)
        self._d.qpos[start : start + 7] = [*pose[:3], *quaternion]
        self._d.qvel[dof : dof + 6] = 0.0
        if twist is not None:
            inverse, angular = np.zeros(4), np.zeros(3)
            mujoco.mju_negQuat(inverse, quaternion)
            mujoco.mju_rotVecQuat(angular, np.array(twist[3:]), inverse)
            self._d.qvel[dof : dof + 6] = [*twist[:3], *angular]
