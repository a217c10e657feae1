"""Pairs of links that collide at random joint positions, and how often.

Source: MoveIt's setup assistant sorts pairs of links in the same way, by random positions, with
the same words: ``Adjacent``, ``Default``, ``Always`` and ``Never``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from teleopctl.kinematics.poses import Array
from teleopctl.robot import Joints, RobotDescription

ALWAYS_SHARE = 0.95
"""Share of random positions from which a pair touches always, as in MoveIt's setup assistant."""
ADJACENT, DEFAULT, ALWAYS, NEVER = "Adjacent", "Default", "Always", "Never"
"""Reasons why a pair of links may touch, as MoveIt's setup assistant writes them."""

# Range (rad or m) that is sampled of a joint without limits.
_HALF_TURN = np.pi
_PLANE = mujoco.mjtGeom.mjGEOM_PLANE


def touching_shares(
    # Any, here and below: MuJoCo's classes have no types.
    mj_model: Any,
    joints: Joints,
    links: Mapping[str, int],
    start: Array,
    samples: int,
) -> dict[tuple[str, str], float]:
    """Return the pairs of links that touch, with the share of random joint positions at which.

    The same arguments give the same result. Pairs that the model excludes do not touch.

    Args:
        mj_model: The ``mujoco.MjModel``.
        joints: The robot's joints.
        links: MuJoCo's number of the body of each link.
        start: Positions of what is not sampled, as MuJoCo's ``qpos``.
        samples: Number of random positions.

    Returns:
        Shares, above 0 and at most 1, by pair of links in alphabetical order.
    """
    names = {body: link for link, body in links.items()}
    data = mujoco.MjData(mj_model)
    mj_model.geom_margin[:] = 0.0
    found: Counter[tuple[int, int]] = Counter()
    for positions in _random_positions(mj_model, joints, start, samples):
        data.qpos[:] = positions
        found.update(_touching(mj_model, data))
    return {
        _pair(names[first], names[second]): count / samples
        for (first, second), count in sorted(found.items())
        if first in names and second in names
    }


# Any: MuJoCo's model has no types.
def allowed_by_sampling(
    description: RobotDescription,
    mj_model: Any,
    joints: Joints,
    links: Mapping[str, int],
    start: Array,
    samples: int = 10_000,
) -> dict[tuple[str, str], str]:
    """Return the pairs of links that need no check, each with its reason.

    Links on either side of a joint are ``Adjacent``, pairs that touch at the start are
    ``Default``, those that touch at nearly all random positions ``Always``, and those that touch
    at none of them ``Never``.

    Args:
        description: The robot.
        mj_model: Its ``mujoco.MjModel``.
        joints: Its joints.
        links: MuJoCo's number of the body of each link.
        start: The positions at rest, as MuJoCo's ``qpos``.
        samples: Number of random positions.
    """
    solid = {
        link: body
        for link, body in links.items()
        if any(
            mj_model.geom_contype[geom] or mj_model.geom_conaffinity[geom]
            for geom in _geoms(mj_model, body)
        )
    }
    kept = np.array(mj_model.exclude_signature), int(mj_model.opt.disableflags)
    # Without the model's own exclusions, which are made for simulation.
    mj_model.exclude_signature[:] = -1
    mj_model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    try:
        data = mujoco.MjData(mj_model)
        data.qpos[:] = start
        bodies = {body: link for link, body in solid.items()}
        at_start = {
            _pair(bodies[first], bodies[second])
            for first, second in _touching(mj_model, data)
            if first in bodies and second in bodies
        }
        shares = touching_shares(mj_model, joints, solid, start, samples)
        fixed = set(_fixed_touching(mj_model, data, solid))
    finally:
        mj_model.exclude_signature[:], mj_model.opt.disableflags = kept
    adjacent = set(_adjacent(description, set(solid)))
    allowed = {}
    names = sorted(solid)
    for number, first in enumerate(names):
        for second in names[number + 1 :]:
            pair = (first, second)
            share = 1.0 if pair in fixed else shares.get(pair, 0.0)
            if pair in adjacent:
                allowed[pair] = ADJACENT
            elif share >= ALWAYS_SHARE:
                allowed[pair] = ALWAYS
            elif pair in at_start:
                allowed[pair] = DEFAULT
            elif share == 0.0:
                allowed[pair] = NEVER
    return allowed


def _random_positions(mj_model: Any, joints: Joints, start: Array, samples: int) -> Iterator[Array]:
    """Yield random ``qpos`` within the limits, with mimic joints at their positions."""
    addresses = {}
    for name in joints:
        number = mujoco.mj_name2id(mj_model, mujoco.mjtObj.mjOBJ_JOINT, name)
        if number >= 0:
            addresses[name] = int(mj_model.jnt_qposadr[number])
    free = [name for name in addresses if joints[name].mimic is None]
    limits = [joints[name].limits for name in free]
    lower = np.array([one.lower if np.isfinite(one.lower) else -_HALF_TURN for one in limits])
    upper = np.array([one.upper if np.isfinite(one.upper) else _HALF_TURN for one in limits])
    # A joint with one limit, which may lie beyond half a turn.
    lower, upper = np.minimum(lower, upper), np.maximum(lower, upper)
    values = np.tile(start, (samples, 1))
    generator = np.random.default_rng(0)
    values[:, [addresses[name] for name in free]] = generator.uniform(
        lower, upper, (samples, len(free))
    )
    for name, leader, multiplier, offset in joints.followers(set(free)):
        if name in addresses:
            led = values[:, addresses[leader]] if leader in addresses else 0.0
            values[:, addresses[name]] = multiplier * led + offset
    yield from values


def _touching(mj_model: Any, data: Any) -> set[tuple[int, int]]:
    """Return the pairs of bodies that touch or overlap, the lower number first."""
    mujoco.mj_kinematics(mj_model, data)
    mujoco.mj_comPos(mj_model, data)
    mujoco.mj_collision(mj_model, data)
    contact = data.contact
    bodies = np.sort(mj_model.geom_bodyid[contact.geom[contact.dist <= 0.0]], axis=1)
    return {(first, second) for first, second in bodies.tolist()}


def _fixed_touching(
    mj_model: Any, data: Any, solid: Mapping[str, int]
) -> Iterator[tuple[str, str]]:
    """Yield pairs of links that no joint moves against each other and that overlap.

    MuJoCo looks for no contacts between them.
    """
    names = sorted(solid)
    for number, first in enumerate(names):
        for second in names[number + 1 :]:
            one, other = solid[first], solid[second]
            if mj_model.body_weldid[one] != mj_model.body_weldid[other]:
                continue
            if any(
                mujoco.mj_geomDistance(mj_model, data, a, b, 0.01, None) <= 0.0
                for a in _geoms(mj_model, one)
                for b in _geoms(mj_model, other)
                if _PLANE not in (mj_model.geom_type[a], mj_model.geom_type[b])
            ):
                yield first, second


def _adjacent(description: RobotDescription, solid: set[str]) -> Iterator[tuple[str, str]]:
    """Yield each link with shapes and the nearest one above it, past links without shapes."""
    above = {joint.child: joint.parent for joint in description.joints.values()}
    for link in solid:
        parent = above.get(link)
        while parent is not None and parent not in solid:
            parent = above.get(parent)
        if parent is not None:
            yield _pair(link, parent)


def _geoms(mj_model: Any, body: int) -> range:
    first = int(mj_model.body_geomadr[body])
    return range(first, first + int(mj_model.body_geomnum[body]))


def _pair(first: str, second: str) -> tuple[str, str]:
    return (first, second) if first < second else (second, first)
