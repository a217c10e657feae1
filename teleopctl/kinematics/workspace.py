"""Workspace of a group: positions of its tool, at random joint positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.poses import Array

if TYPE_CHECKING:
    from teleopctl.kinematics.clearance import ClearanceChecker


@dataclass(frozen=True, slots=True)
class Workspace:
    """Positions that a tool reaches.

    Attributes:
        points: Positions of the tool in the root link's frame, (k, 3), m.
        manipulability: Yoshikawa's measure at each of them, (k,): the product of the singular
            values of the linear Jacobian in the directions that the joints serve, which is the
            volume of the velocities that joints of 1 rad/s or 1 m/s give the tool.
        samples: Number of random joint positions.
        colliding: Number of those that were left out as links touch.
        origin: Position of the group's first joint, (3,), m.
    """

    points: Array
    manipulability: Array
    samples: int
    colliding: int
    origin: Array

    @property
    def lower(self) -> Array:
        """Smallest coordinates that were reached, (3,), m."""
        return np.asarray(self.points.min(axis=0))

    @property
    def upper(self) -> Array:
        """Largest coordinates that were reached, (3,), m."""
        return np.asarray(self.points.max(axis=0))

    @property
    def reach_m(self) -> float:
        """Largest distance of the tool from the group's first joint, m."""
        return float(np.linalg.norm(self.points - self.origin, axis=1).max())


def sample_workspace(
    kinematics: GroupKinematics,
    *,
    clearance: ClearanceChecker | None = None,
    samples: int = 10_000,
) -> Workspace:
    """Return the positions of a group's tool at random positions of its joints.

    The same arguments give the same result; the model is at its former state again afterwards.

    Args:
        kinematics: Kinematics of the group.
        clearance: Checker of collisions, whose states are left out; None to keep all.
        samples: Number of random joint positions.

    Raises:
        UsageError: The number is not positive, or links touch at all of the positions.
    """
    if samples < 1:
        raise UsageError(f"The number of samples must be at least 1, got {samples}")
    before, generator = kinematics.present(), np.random.default_rng(0)
    points, manipulability = [], []
    model, (_, rank) = kinematics.model, kinematics.dimensions
    try:
        for _ in range(samples):
            kinematics.set(kinematics.random(generator))
            if clearance is not None and clearance.collisions():
                continue
            position, _ = kinematics.world_pose()
            points.append(model.to_root(position))
            values = np.linalg.svd(kinematics.world_jacobian()[:3], compute_uv=False)
            manipulability.append(float(np.prod(values[:rank])))
    finally:
        kinematics.set(before)
    if not points:
        raise UsageError(f"Links touch at all of {samples} random joint positions")
    first = model.joint_origin(kinematics.names[0])
    return Workspace(
        np.array(points), np.array(manipulability), samples, samples - len(points), first
    )
