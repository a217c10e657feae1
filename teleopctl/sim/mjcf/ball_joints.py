"""Ball joints as ROS knows joints: turns about x, then y, then z, three joints of the URDF.

With a, b, c the angles of the turns, the rotation is R = Rx(a) Ry(b) Rz(c), and the angular
velocity in the turned frame is w = (a' cb cc + b' sc, -a' cb sc + b' cc, a' sb + c'), where s and
c before an angle's name are its sine and cosine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import asin, atan2, cos, sin
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from teleopctl.mujoco_model import JointSpec

Array = npt.NDArray[np.float64]

# The least cosine of the middle turn: where it is a right angle, the others' speeds are not known.
_NEARLY_UPRIGHT = 1e-6


class BallJoints:
    """Ball joints of a simulation, as three rotation joints each.

    Args:
        joints: The robot's movable joints; three after one another are a ball joint.
    """

    def __init__(self, joints: Sequence[JointSpec]) -> None:
        self._rows = {joint.ball: row - 2 for row, joint in enumerate(joints) if joint.ball}
        self._names = tuple(joint.name for joint in joints)

    def __len__(self) -> int:
        return len(self._rows)

    # Any stands for MuJoCo's types, which have no static ones.
    def read(self, data: Any, positions: Array, velocities: Array) -> None:
        """Write the rotation angles and velocities of the ball joints into arrays."""
        rotation = np.zeros(9)
        for ball, row in self._rows.items():
            joint = data.joint(ball)
            mujoco.mju_quat2Mat(rotation, joint.qpos)
            a = atan2(-rotation[5], rotation[8])
            b = asin(min(max(rotation[2], -1.0), 1.0))
            c = atan2(-rotation[1], rotation[0])
            x, y, z = joint.qvel
            first = (cos(c) * x - sin(c) * y) / max(cos(b), _NEARLY_UPRIGHT)
            positions[row : row + 3] = a, b, c
            velocities[row : row + 3] = first, sin(c) * x + cos(c) * y, z - sin(b) * first

    def put(self, data: Any, given: Mapping[str, float]) -> None:
        """Set ball joints from rotation angles; missing angles are 0."""
        for ball, row in self._rows.items():
            turns = self._names[row : row + 3]
            if any(turn in given for turn in turns):
                angles = np.array([given.get(turn, 0.0) for turn in turns])
                mujoco.mju_euler2Quat(data.joint(ball).qpos, angles, "xyz")
