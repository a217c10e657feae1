"""Tuning of drives: natural frequencies, and the inertia that each drive moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import DRIVE_RAD_S
from teleopctl.sim.state.physics import Array

if TYPE_CHECKING:
    from teleopctl.mujoco_model import JointSpec


# The fastest natural frequency (rad/s) of a joint on its drive, for commands at 170 Hz or more: a
# jump within the effort limit settles to 1 % in 25 ms. Four times as fast is not stable with mimic
# joints.
_FASTEST_RAD_S = 250.0
# Largest phase (rad) of this frequency per control period: set-points move in straight lines from
# one to the next, and a faster drive makes the corners between them harder.
_IN_A_PERIOD = 1.5
# Largest phase (rad) of this frequency per physics step.
_IN_A_STEP = 0.25


def drive_rates(takes_position: npt.NDArray[np.bool_], period_s: float, step_s: float) -> Array:
    """Return the natural frequency (rad/s) to which each joint's drive is tuned, (n,).

    Args:
        takes_position: Whether each joint takes position commands, (n,). Others, such as wheels,
            keep the frequency with which they were built.
        period_s: Control period in seconds.
        step_s: Physics step in seconds.
    """
    fastest = min(_FASTEST_RAD_S, _IN_A_PERIOD / period_s, _IN_A_STEP / step_s)
    return np.where(takes_position, max(DRIVE_RAD_S, fastest), DRIVE_RAD_S)


class MovedInertia:
    """Inertia that each drive moves while all other joints stand still.

    The inertia is the joint's diagonal element of the mass matrix, plus those of its mimic joints.

    Args:
        model: The ``mujoco.MjModel``.
        joints: The robot's movable joints.
        driven: Names of the n joints with drives.
        tuned: Inertia that each drive was tuned to when the model was built, in the model's own
            pose, (n,).
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(
        self, model: Any, joints: Sequence[JointSpec], driven: Sequence[str], tuned: Array
    ) -> None:
        self._m = model
        # Separate data: the estimate does not change the simulation.
        self._d = mujoco.MjData(model)
        row = {name: number for number, name in enumerate(driven)}
        self._dofs = np.array([model.joint(name).dofadr[0] for name in driven], dtype=int)
        self._diagonal = model.M_rowadr + model.M_rownnz - 1
        followers = [
            (row[joint.mimic.joint], int(model.joint(joint.name).dofadr[0]), joint.mimic.multiplier)
            for joint in joints
            if joint.mimic is not None and joint.mimic.joint in row
        ]
        self._followers = followers
        self._tuned, self._least = tuned, np.array(model.dof_armature[self._dofs])
        self._own = self._now()

    def at(self, data: Any) -> Array:
        """Return the inertia that each drive moves in the data's pose, kg m² or kg, (n,)."""
        self._d.qpos[:] = data.qpos
        # Other inertia that drives were tuned to, such as the robot that stands on a leg, stays.
        inertia: Array = np.maximum(self._tuned - self._own + self._now(), self._least)
        return inertia

    def _now(self) -> Array:
        mujoco.mj_kinematics(self._m, self._d)
        mujoco.mj_comPos(self._m, self._d)
        mujoco.mj_makeM(self._m, self._d)
        masses = self._d.M[self._diagonal]
        moved: Array = masses[self._dofs]
        for leader, dof, multiplier in self._followers:
            moved[leader] += multiplier**2 * masses[dof]
        return moved
