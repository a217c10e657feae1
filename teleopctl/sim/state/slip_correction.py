"""Physics steps in which sliding wheels keep contact with the ground.

MuJoCo's contacts are convex: a force at the limit of friction pushes the two apart, the more the
faster they slide, so that a sliding wheel hops a hundred times a second. Friction then acts in
short blows, which turn light wheels rather than move the robot: a base that turns by sliding its
wheels turns half to three quarters as fast as with dry friction. So the acceleration at which two
contacts are to part is lowered by just what sliding adds to it; what rolls or sticks is as before.

In MuJoCo's terms: at the border of the cone `a_n - aref_n + R f_n = mu |a_t - aref_t|`, where dry
friction has 0. In a steady slide `a_t` is 0, so `mu |aref_t|` is taken from `aref_n`.
Source: De Saxcé and Feng 1998, here as a change of the reference instead of an iteration.

Casters that do not turn slide too. Where they hop, weight goes from the driven wheels to them, and
the wheels spin: a base of 1.1 kg on two such casters came a third as far as its wheels turned.

That is done in Python, for a quarter of what a step of a base on four wheels takes: only robots
have it that cannot turn, or drive, without sliding, and only while they slide or may begin to. On
two driven wheels and casters that turn nothing has to slide, and the two points by which a cylinder
touches would tell too much of how a wide wheel does.
"""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.sim.state.friction_directions import FrictionDirections
from teleopctl.sim.state.physics import Array, nothing_asleep

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel

_ELLIPTIC = int(mujoco.mjtCone.mjCONE_ELLIPTIC)
_MANY_WHEELS = 3

# What slides is looked for in one step of so many while nothing does and the drives keep their
# speeds. Not while those change, nor until wheels have taken them up, to 1 % within 50 ms: a base
# loses 6 mrad of a turn where the first blows of its wheels are missed.
_LOOK_EVERY, _TAKEN_UP_S = 16, 0.1

# Where sliding adds less than this (m/s²) to the acceleration at which two contacts are to part, a
# twentieth of a weight's, they stay together: mu times 5 mm/s at the softness of our contacts.
_PARTS = 0.5

# So many sets of what touches are kept: of four wheels each lies on one edge, on both or on none.
_MOST_KNOWN = 1024


def drives_by_sliding(model: RobotModel) -> bool:
    """Return whether a robot has a free base whose wheels or casters slide when it turns.

    That is one of three driven wheels or more, or one that drags casters along the ground. For a
    robot of an MJCF file the physics is as the file has it.
    """
    wheels = [one for one in model.joints if one.driven_by_velocity]
    return (
        model.base is not None
        and model.start is None
        and model.mj_model.opt.cone == _ELLIPTIC
        and (len(wheels) >= _MANY_WHEELS or model.base.drags)
    )


class PhysicsStepper:
    """Stepper of MuJoCo's physics with corrected contacts of sliding wheels.

    Args:
        model: The ``mujoco.MjModel``.
        slides: Whether what slides is to stay on the ground.
        directions: Which friction differs by direction.

    Attributes:
        slides: The same.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, model: Any, *, slides: bool, directions: FrictionDirections) -> None:
        self._m = model
        self.slides = slides
        self._directions = directions
        # Steps to come in which each is looked at for what slides, and then in which none is.
        self._seen = self._unseen = 0
        # Friction directions may give the same shapes another friction.
        self._contacts = _Contacts(kept=not (model.nflex or directions))
        self._taking_up = round(_TAKEN_UP_S / model.opt.timestep)

    def begin_period(self, *, changing: bool) -> None:
        """Set whether drives change their speeds in the control period that begins."""
        if changing:
            self._seen, self._unseen = self._taking_up, 0

    def step(self, data: Any, count: int) -> None:
        """Advance MuJoCo's data by physics steps, with corrected contacts."""
        if self._directions:
            for _ in range(count):
                mujoco.mj_step1(self._m, data)
                self._directions.turn(data)
                if self.slides:
                    self._contacts.correct_slip(data)
                mujoco.mj_step2(self._m, data)
            return
        if not self.slides:
            mujoco.mj_step(self._m, data, count)
            return
        while count > 0:
            if block := min(count, self._unseen):
                mujoco.mj_step(self._m, data, block)
                self._unseen -= block
                count -= block
                continue
            mujoco.mj_step1(self._m, data)
            most = self._contacts.correct_slip(data)
            if self._seen:
                self._seen -= 1
            elif most < _PARTS:
                self._unseen = _LOOK_EVERY - 1
            mujoco.mj_step2(self._m, data)
            count -= 1

    def save(self) -> Array:
        """Return the stepper's internal state, for `restore`."""
        return np.array([self._seen, self._unseen], float)

    def restore(self, saved: Array) -> None:
        """Set the stepper's internal state to what `save` returned."""
        self._seen, self._unseen = map(int, saved)

    def forward(self, data: Any) -> None:
        """Compute forces, accelerations and sensor values without advancing time."""
        with nothing_asleep(self._m):
            mujoco.mj_forward(self._m, data)
            if self._directions:
                self._directions.turn(data)
            if (self.slides and self._contacts.correct_slip(data) > 0.0) or self._directions:
                mujoco.mj_fwdConstraint(self._m, data)
                mujoco.mj_sensorAcc(self._m, data)


class _Contacts:
    """What touches: where its rows are among the constraints, and its friction.

    That stays the same while the same shapes touch in the same order, so it is kept: to read it
    takes as long as all the rest.

    Args:
        kept: Whether shapes tell the friction: what is soft has none.
    """

    def __init__(self, *, kept: bool) -> None:
        self._kept = kept
        # Of each contact with friction: the rows of its normal and of two directions along the
        # ground, and the friction in these.
        self._known: dict[bytes, list[tuple[int, int, int, float, float]]] = {}

    def correct_slip(self, data: Any) -> float:
        """Subtract from each contact's normal acceleration what sliding adds; return the most.

        Returns:
            The most of it (m/s²).
        """
        if not data.ncon:
            return 0.0
        contact = data.contact
        key = contact.geom.tobytes() + contact.efc_address.tobytes()
        rows = self._known.get(key) if self._kept else None
        if rows is None:
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            rows = self._known[key] = _rows(contact)
        # A view: numpy takes several times as long to read or write one number.
        reference, most = data.efc_aref.data, 0.0
        for normal, first, second, along_first, along_second in rows:
            slip = hypot(along_first * reference[first], along_second * reference[second])
            reference[normal] -= slip
            if slip > most:
                most = slip
        return most


def _rows(contact: Any) -> list[tuple[int, int, int, float, float]]:
    listed = contact.efc_address.tolist(), contact.dim.tolist(), contact.friction.tolist()
    return [
        (row, row + 1, row + 2, friction[0], friction[1])
        for row, dim, friction in zip(*listed, strict=True)
        if row >= 0 and dim > 1
    ]
