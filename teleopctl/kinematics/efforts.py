"""Joint efforts of a group during a motion, with the payload."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.poses import Array

if TYPE_CHECKING:
    from teleopctl.kinematics.motion.plan import MotionPlan


def joint_efforts(
    kinematics: GroupKinematics, positions: Array, velocities: Array, accelerations: Array
) -> Array:
    """Return the efforts of the independent joints for states of a motion, (k, n), N m or N.

    The inverse dynamics of rigid bodies, M(q) ddq + c(q, dq) + g(q), by the recursive Newton-Euler
    algorithm of MuJoCo, without friction and springs. A mimic joint counts at the joint that it
    follows. The model is at the last state afterwards, its other joints at rest.

    Args:
        kinematics: Kinematics of the group; its model has the inertias.
        positions: Positions, (k, n), rad or m.
        velocities: Velocities, (k, n).
        accelerations: Accelerations, (k, n).
    """
    m, data, spread = kinematics.model.mj_model, kinematics.model.mj_data, kinematics.spread()
    found = np.zeros_like(positions)
    forces = np.zeros(m.nv)
    rows = zip(positions, velocities, accelerations, strict=True)
    for row, (position, velocity, acceleration) in enumerate(rows):
        kinematics.set(position)
        data.qvel[:], data.qacc[:] = spread @ velocity, spread @ acceleration
        mujoco.mj_comVel(m, data)
        mujoco.mj_rne(m, data, 1, forces)
        found[row] = forces @ spread
    data.qvel[:] = data.qacc[:] = 0.0
    return found


def overload_note(kinematics: GroupKinematics, plan: MotionPlan) -> str:
    """Return which joint a plan loads most beyond its effort limit, as a sentence; empty for none.

    Args:
        kinematics: Kinematics of the plan's group.
        plan: The plan.
    """
    efforts = joint_efforts(kinematics, plan.positions, plan.velocities, plan.accelerations)
    limits = np.array([limit.effort for limit in kinematics.limits])
    parts = np.abs(efforts) / limits
    row, place = np.unravel_index(int(parts.argmax()), parts.shape)
    if parts[row, place] <= 1.0:
        return ""
    name = kinematics.names[place]
    unit = "N" if kinematics.model.joints[name].joint.type == "prismatic" else "N m"
    return (
        f"Joint '{name}' needs {abs(efforts[row, place]):.3g} {unit} at {plan.times[row]:.2f} s, "
        f"more than its limit of {limits[place]:.3g} {unit}"
    )
