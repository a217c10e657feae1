"""Restitution of contacts, and torsional and rolling friction.

MuJoCo takes the parameters of a contact from one of its two shapes, or the larger of two values.
Gazebo multiplies coefficients of restitution and takes the smaller one of spinning friction, so two
shapes of which one has such a parameter become a contact pair with parameters of its own.

MuJoCo's contacts are springs and dampers in units of acceleration, whatever the masses: the
acceleration along the normal becomes -b v - k r. With b = (1 + e) / h, the first step of h seconds
in which two shapes overlap turns their approach speed v into -e v, which is restitution; then the
force ends, since contacts do not pull. Shapes at rest stay at rest.
"""

from __future__ import annotations

import math
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from teleopctl.robot import Surface

# Prefix of the names of pairs added here, and first value of user data that holds a surface.
_PAIR = "surface/"
_OURS = 0x5EED
# Default spinning and rolling friction of a contact, see MuJoCo's ``friction``.
_SPIN, _ROLL = 0.005, 0.0001
# Moment of a circular patch of radius a, under the pressure of a ball: 3 pi / 16 a mu N.
_OF_PATCH = 3.0 * math.pi / 16.0
# Limit of spinning and rolling friction, in metres: above it nothing turns anyway.
_ROUGHEST = 1000.0
# Overlapping shapes that bounce are pushed apart with this time constant, in seconds, that of
# MuJoCo's other contacts. Their constraint is nearly hard.
_APART_S = 0.02
_HARD = [0.9999, 0.9999, 0.001, 0.5, 2.0]
# Surface of a shape without parameters: it does not bounce, and its patch has no radius.
_USUAL = (0.0, 1.0, 0.0, 0.0)
# Each pair costs 0.1 us per step, near or far.
_MOST_PAIRS = 20_000


class _Touching(NamedTuple):
    """Collision shape with its topmost body, surface and friction."""

    geom: Any
    top: str
    surface: tuple[float, ...]
    friction: float


class _Contact(NamedTuple):
    """Contact parameters of two shapes other than sliding friction; lengths in metres."""

    restitution: float
    spinning: float
    rolling: float


# Any stands for MuJoCo's elements, here and below: their classes have no types.
def store_surface(geom: Any, surface: Surface) -> None:
    """Store a shape's restitution and friction in its user data, for `add_contact_pairs`."""
    geom.userdata = [_OURS, *surface.values]


def add_contact_pairs(spec: mujoco.MjSpec) -> list[str]:
    """Add contact pairs for shapes that bounce, or resist spinning or rolling; return warnings.

    The pair has restitution and friction as Gazebo combines those of the two shapes.

    Shapes of one robot, or of one object, get no pair with one another; nor do links that overlap
    at the start, or shapes of MJCF files that set contacts of their own.

    Args:
        spec: The ``mujoco.MjSpec``, otherwise complete; pairs that this function added before stay.

    Returns:
        A warning if the shapes need too many pairs; else none.
    """
    usual = mujoco.MjSpec().default.geom
    touching = [
        _Touching(geom, _top(geom), _surface(geom), float(geom.friction[0]))
        for geom in spec.geoms
        if (geom.contype or geom.conaffinity) and _has_usual_contacts(geom, usual)
    ]
    special = [number for number, one in enumerate(touching) if one.surface != _USUAL]
    if not special:
        return []
    excluded = {frozenset((pair.bodyname1, pair.bodyname2)) for pair in spec.excludes}
    there = {pair.name for pair in spec.pairs}
    names = _free_names(spec)
    done: set[int] = set()
    for first in special:
        done.add(first)
        one = touching[first]
        for second, other in enumerate(touching):
            if second in done or one.top == other.top:
                continue
            contact = _contact(one, other)
            if contact is None or not _may_touch(one.geom, other.geom):
                continue
            if frozenset((one.geom.parent.name, other.geom.parent.name)) in excluded:
                continue
            if len(there) >= _MOST_PAIRS:
                return [
                    f"More than {_MOST_PAIRS} pairs of shapes bounce, spin or roll in their own "
                    "way: the rest touches as usual"
                ]
            for geom in (one.geom, other.geom):
                geom.name = geom.name or next(names)
            name = f"{_PAIR}{one.geom.name} and {other.geom.name}"
            if name not in there:
                there.add(name)
                _add_pair(spec, name, one, other, contact)
    return []


def set_timestep(model: mujoco.MjModel, timestep_s: float) -> None:
    """Set a model's physics step in seconds, keeping the restitution of contacts.

    Args:
        model: The ``mujoco.MjModel``.
        timestep_s: The step in seconds.
    """
    before, model.opt.timestep = model.opt.timestep, timestep_s
    for number in range(model.npair):
        if model.pair(number).name.startswith(_PAIR) and model.pair_solref[number, 1] < 0.0:
            model.pair_solref[number, 1] *= before / timestep_s


def _surface(geom: Any) -> tuple[float, ...]:
    """Return a shape's restitution, spinning friction, patch radius and rolling friction."""
    values = list(geom.userdata)
    return tuple(values[1:5]) if values[:1] == [_OURS] else _USUAL


def _top(geom: Any) -> str:
    """Return the topmost body of a shape; ``world`` for a shape that is fixed to the world."""
    body, moves = geom.parent, False
    while body.name != "world":
        top = str(body.name)
        moves = moves or len(list(body.joints)) > 0
        body = body.parent
    return top if moves else "world"


def _may_touch(one: Any, other: Any) -> bool:
    return bool(one.contype & other.conaffinity or other.contype & one.conaffinity)


def _has_usual_contacts(geom: Any, usual: Any) -> bool:
    return (
        geom.condim == usual.condim
        and geom.margin == usual.margin
        and geom.gap == usual.gap
        and np.array_equal(geom.solref, usual.solref)
        and np.array_equal(geom.solimp, usual.solimp)
    )


def _free_names(spec: mujoco.MjSpec) -> Iterator[str]:
    """Yield unused names for unnamed shapes, with the prefix of the added pairs."""
    taken = {geom.name for geom in spec.geoms}
    return (name for number in count() if (name := f"{_PAIR}shape{number}") not in taken)


def _contact(one: _Touching, other: _Touching) -> _Contact | None:
    """Return the contact of two shapes as in Gazebo's engines; None for MuJoCo's usual contact.

    ODE has friction against spinning, Bullet against rolling, and restitution is as in DART.
    """
    (bounce, spin, patch, roll), (bounce2, spin2, patch2, roll2) = one.surface, other.surface
    found = _Contact(
        bounce * bounce2,
        min(_OF_PATCH * max(patch, patch2) * min(spin, spin2), _ROUGHEST),
        min(roll * other.friction + roll2 * one.friction, _ROUGHEST),
    )
    return found if any(found) else None


def _add_pair(
    spec: mujoco.MjSpec, name: str, one: _Touching, other: _Touching, contact: _Contact
) -> None:
    friction = min(one.friction, other.friction)
    pair = spec.add_pair(
        name=name,
        geomname1=one.geom.name,
        geomname2=other.geom.name,
        condim=6 if contact.rolling else 4 if contact.spinning else 3,
        friction=[
            *(friction, friction),
            contact.spinning or _SPIN,
            *(contact.rolling or _ROLL,) * 2,
        ],
        # Sliding friction does not depend on restitution.
        solreffriction=list(one.geom.solref),
        solref=list(one.geom.solref),
        solimp=list(one.geom.solimp),
    )
    if contact.restitution:
        pair.solref = [-1.0 / _APART_S**2, -(1.0 + contact.restitution) / spec.option.timestep]
        pair.solimp = _HARD
