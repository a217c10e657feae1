"""Which parts of a robot may touch each other.

Two kinds of pairs never do: neighbours, whose shapes overlap around the joint's axis by
construction, and links that already overlap in the robot's initial pose, such as the meshed roots
of two fingers, where contact would push against the drives for ever.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np


def exclude_adjacent(spec: Any) -> None:
    """Exclude contacts between each link and the nearest one before it that has a shape.

    MuJoCo itself lets the links on either side of a joint pass through each other, with all that
    is fixed to them, but not where one side stands still in the world.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
    """
    for body in spec.bodies:
        if body.name == "world" or not _touches(body):
            continue
        parent = body.parent
        while parent.name != "world" and not _touches(parent):
            parent = parent.parent
        if _touches(parent):
            spec.add_exclude(bodyname1=parent.name, bodyname2=body.name)


def _touches(body: Any) -> bool:
    return any(geom.contype for geom in body.geoms)


def overlapping_pairs(model: Any, positions: np.ndarray, ground: str) -> list[tuple[str, str]]:
    """The pairs of links whose shapes overlap in a pose.

    Args:
        model: The compiled ``mujoco.MjModel``.
        positions: The pose, as MuJoCo's ``qpos``.
        ground: The name of the ground's body, which is not looked at.

    Returns:
        Pairs of link names in a stable order.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = positions
    # Where the links are and what touches, but no forces: those need memory by the square of the
    # contacts, and before this list is made, every link of a large robot may touch the next.
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    pairs = set()
    for contact in data.contact:
        if contact.dist >= 0.0:
            continue
        bodies = (model.geom_bodyid[contact.geom1], model.geom_bodyid[contact.geom2])
        first, second = sorted(model.body(body).name for body in bodies)
        if ground not in (first, second):
            pairs.add((first, second))
    return sorted(pairs)
