"""Physics steps in which what slides stays on the ground.

MuJoCo's contacts are convex: a force at the limit of friction pushes the two apart, the more the
faster they slide, so that a sliding wheel hops a hundred times a second. Friction then acts in
short blows, which turn light wheels rather than move the robot: a base that turns by sliding its
wheels turns half to three quarters as fast as with dry friction. So the acceleration at which two
contacts are to part is lowered by just what sliding adds to it; what rolls or sticks is as before.

In MuJoCo's terms: at the border of the cone `a_n - aref_n + R f_n = mu |a_t - aref_t|`, where dry
friction has 0. In a steady slide `a_t` is 0, so `mu |aref_t|` is taken from `aref_n`.
Source: De Saxcé and Feng 1998, here as a change of the reference instead of an iteration.

That is done in Python for each step, a quarter of what a step of a base on four wheels takes: only
robots have it that cannot turn without sliding. On two driven wheels nothing has to slide, and the
two points by which a cylinder touches would tell too much of how a wide wheel does.
"""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING, Any

import mujoco

from teleopctl.sim.state.physics import nothing_asleep

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel

_ELLIPTIC = int(mujoco.mjtCone.mjCONE_ELLIPTIC)
_MANY_WHEELS = 3


def turns_by_sliding(model: RobotModel) -> bool:
    """Whether a robot goes on so many wheels that some slide: it moves freely, and drives three.

    Physics of an MJCF file is as the file has it.
    """
    wheels = [one for one in model.joints if one.has_drive and "velocity" in one.command_interfaces]
    return (
        model.base is not None
        and model.start is None
        and model.mj_model.opt.cone == _ELLIPTIC
        and len(wheels) >= _MANY_WHEELS
    )


class Physics:
    """Steps of MuJoCo's.

    Args:
        model: The ``mujoco.MjModel``.
        slides: Whether what slides is to stay on the ground.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, model: Any, *, slides: bool) -> None:
        self._m = model
        self._slides = slides

    def step(self, data: Any, count: int) -> None:
        """Advance by physics steps."""
        if not self._slides:
            mujoco.mj_step(self._m, data, count)
            return
        for _ in range(count):
            mujoco.mj_step1(self._m, data)
            _keep_down(data)
            mujoco.mj_step2(self._m, data)

    def forward(self, data: Any) -> None:
        """Work out forces and accelerations, and what sensors measure, of all that touches."""
        with nothing_asleep(self._m):
            mujoco.mj_forward(self._m, data)
            if self._slides and data.ncon:
                _keep_down(data)
                mujoco.mj_fwdConstraint(self._m, data)
                mujoco.mj_sensorAcc(self._m, data)


def _keep_down(data: Any) -> None:
    """Take from the reference of each contact's normal what sliding adds to it."""
    if not data.ncon:
        return
    contact, reference = data.contact, data.efc_aref
    # Lists: numpy takes three times as long for the few contacts of wheels.
    before = reference.tolist()
    for row, dim, friction in zip(
        contact.efc_address.tolist(), contact.dim.tolist(), contact.friction.tolist(), strict=True
    ):
        if row >= 0 and dim > 1:
            slip = hypot(friction[0] * before[row + 1], friction[1] * before[row + 2])
            reference[row] = before[row] - slip
