"""Physics steps in which sliding wheels keep contact with the ground.

MuJoCo's contacts are convex: a force at the limit of friction pushes two shapes apart, the more the
faster they slide, so that a sliding wheel hops a hundred times a second. Friction then acts in
short blows, which turn light wheels rather than move the robot: a base that turns by sliding its
wheels turns half to three quarters as fast as with dry friction. So the reference acceleration with
which a contact separates is lowered by what sliding adds to it; rolling and sticking contacts do
not change.

In MuJoCo's terms: at the border of the cone `a_n - aref_n + R f_n = mu |a_t - aref_t|`, where dry
friction has 0. In a steady slide `a_t` is 0, so `mu |aref_t|` is taken from `aref_n`.
Source: De Saxcé and Feng 1998, here as a change of the reference instead of an iteration.

Fixed casters slide too. When they hop, they take weight off the driven wheels, which then spin: a
base of 1.1 kg on two such casters moved a third of the distance that its wheels turned.

The correction runs in Python and takes a quarter of the time of a step of a base on four wheels. So
it is only for robots that cannot turn, or drive, without sliding, and only while they slide or may
begin to. With two driven wheels and turning casters nothing has to slide, and the two contact
points of a cylinder would exaggerate the slip of a wide wheel.
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

# One step in _LOOK_EVERY is checked for sliding while nothing slides and the drives keep their
# speeds. Every step is checked while speeds change, and for _TAKEN_UP_S until the wheels have
# reached them, to 1 % within 50 ms: a base loses 6 mrad of a turn if the first blows are missed.
_LOOK_EVERY, _TAKEN_UP_S = 16, 0.1

# Contacts stay closed if sliding adds less than this (m/s²), a twentieth of gravity, to the
# acceleration with which they separate: mu times 5 mm/s at the softness of the contacts here.
_PARTS = 0.5

# Most cached sets of contacts: each of four wheels touches with one edge, both or none.
_MOST_KNOWN = 1024


def drives_by_sliding(model: RobotModel) -> bool:
    """Return whether a robot has a free base whose wheels or casters slide when it turns.

    Such a base has three or more driven wheels, or drags casters along the ground. The physics of a
    robot from an MJCF file is never corrected.
    """
    wheels = [one for one in model.joints if one.driven_by_velocity]
    return (
        model.base is not None
        and model.start is None
        and model.mj_model.opt.cone == _ELLIPTIC
        and (len(wheels) >= _MANY_WHEELS or model.base.drags)
    )


class PhysicsStepper:
    """Stepper of MuJoCo's physics that corrects contacts of sliding wheels and directed friction.

    Args:
        model: The ``mujoco.MjModel``.
        slides: Whether to correct the contacts of sliding wheels.
        directions: Direction-dependent friction of the robot's shapes.

    Attributes:
        slides: Whether the contacts of sliding wheels are corrected.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, model: Any, *, slides: bool, directions: FrictionDirections) -> None:
        self._m = model
        self.slides = slides
        self._directions = directions
        # Number of next steps that are checked for sliding, and of later ones that are not.
        self._seen = self._unseen = 0
        # Not cached with friction directions, which may change the friction of the same shapes.
        self._contacts = _Contacts(kept=not (model.nflex or directions))
        self._taking_up = round(_TAKEN_UP_S / model.opt.timestep)

    def begin_period(self, *, changing: bool) -> None:
        """Begin a control period; if drives change speeds, check every step for sliding wheels."""
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
    """Correction of sliding contacts, with their constraint rows and friction cached.

    Rows and friction stay the same while the same shapes touch in the same order. To read them
    takes as long as the rest of the correction.

    Args:
        kept: Whether the touching shapes define the friction, so that it can be cached; contacts of
            flexes have no shapes.
    """

    def __init__(self, *, kept: bool) -> None:
        self._kept = kept
        # For each contact with friction: the rows of its normal and of two directions along the
        # surface, and the friction in these directions.
        self._known: dict[bytes, list[tuple[int, int, int, float, float]]] = {}

    def correct_slip(self, data: Any) -> float:
        """Subtract sliding's part from contacts' normal acceleration; return the largest (m/s²)."""
        if not data.ncon:
            return 0.0
        contact = data.contact
        key = contact.geom.tobytes() + contact.efc_address.tobytes()
        rows = self._known.get(key) if self._kept else None
        if rows is None:
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            rows = self._known[key] = _rows(contact)
        # A memory view: numpy takes several times as long to read or write one number.
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
