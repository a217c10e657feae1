"""Distances between the bodies of a robot, and to its surroundings, by MuJoCo's collision check."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array

_NO_DISTANCES = np.zeros(0)
_NO_BODIES = np.zeros((0, 2), dtype=np.intp)


class Approach(NamedTuple):
    """Nearest points of two bodies.

    Attributes:
        distance_m: Distance between the bodies; negative if they overlap.
        bodies: Names of the two bodies.
        numbers: MuJoCo's numbers of the two bodies.
        is_self: Whether both are links of the robot.
        point: Point between the two nearest points, (3,), in MuJoCo's world frame, m.
        normal: Unit vector from the first body to the second, (3,), in the world frame.
    """

    distance_m: float
    bodies: tuple[str, str]
    numbers: tuple[int, int]
    is_self: bool
    point: Array
    normal: Array

    def separation(self, kinematics: GroupKinematics) -> Array:
        """Return the change of the distance at 1 rad/s or 1 m/s of each joint, (n,)."""
        first, second = self.numbers
        moved = kinematics.point_jacobian(self.point, second)
        moved = moved - kinematics.point_jacobian(self.point, first)
        return np.asarray(self.normal @ moved)


class ClearanceChecker:
    """Check of a model's clearance at its present state.

    Neighbouring links, and links that overlap at rest, may touch: they are no pairs of the model.
    So may pairs that touch at nearly all joint positions: their shapes are wrong, mostly because a
    mesh collides as its convex hull.

    Args:
        model: The model.
        allowed: Further pairs of links that may touch, for example those of an SRDF.

    Attributes:
        allowed: Pairs of body names, in alphabetical order, that may touch.
    """

    def __init__(self, model: KinematicModel, allowed: Iterable[tuple[str, str]] = ()) -> None:
        self._model = model
        self._mj_model, self._mj_data = model.mj_model, model.mj_data
        self._names = [self._mj_model.body(n).name for n in range(self._mj_model.nbody)]
        self._robot = frozenset(model.links.values())
        self.allowed: set[tuple[str, str]] = set()
        self._allowed_numbers: set[tuple[int, int]] = set()
        self._is_allowed = np.zeros((len(self._names), len(self._names)), dtype=bool)
        self.allow((*model.touching, *allowed))

    def allow(self, pairs: Iterable[tuple[str, str]]) -> None:
        """Allow further pairs of bodies to touch; unknown names are ignored."""
        numbers = {name: number for number, name in enumerate(self._names)}
        for first, second in pairs:
            self.allowed.add((first, second) if first < second else (second, first))
            if first in numbers and second in numbers:
                a, b = numbers[first], numbers[second]
                self._allowed_numbers.add((min(a, b), max(a, b)))
                self._is_allowed[a, b] = self._is_allowed[b, a] = True

    def allow_within(self, links: Iterable[str]) -> None:
        """Allow all pairs of some links to touch, such as the fingers of a gripper."""
        names = list(links)
        self.allow((first, second) for first in names for second in names if first < second)

    def near(self, within_m: float) -> list[Approach]:
        """Return all pairs of bodies nearer than a distance, each once, the nearest first.

        Args:
            within_m: The distance, m; 0 for those that touch or overlap.
        """
        # The margins of two geoms are summed.
        self._mj_model.geom_margin[:] = 0.5 * within_m
        mujoco.mj_collision(self._mj_model, self._mj_data)
        data = self._mj_data
        if not data.ncon:
            return []
        contact = data.contact
        bodies = self._mj_model.geom_bodyid[contact.geom]
        order = np.argsort(contact.dist, kind="stable")
        found: dict[tuple[int, int], Approach] = {}
        for place in order.tolist():
            first, second = int(bodies[place, 0]), int(bodies[place, 1])
            key = (first, second) if first < second else (second, first)
            if key in found or key in self._allowed_numbers:
                continue
            found[key] = Approach(
                float(contact.dist[place]),
                (self._names[first], self._names[second]),
                (first, second),
                first in self._robot and second in self._robot,
                np.array(contact.pos[place]),
                np.array(contact.frame[place, :3]),
            )
        return list(found.values())

    def distances(self, within_m: float) -> tuple[Array, npt.NDArray[np.intp]]:
        """Return distances and bodies of all contacts nearer than a distance, in any order.

        A pair of bodies may have several contacts. Costs half of what `near` does.

        Args:
            within_m: The distance, m.

        Returns:
            Distances, (k,), m, negative for bodies that overlap; MuJoCo's numbers of the bodies,
            (k, 2).
        """
        model, data = self._mj_model, self._mj_data
        model.geom_margin[:] = 0.5 * within_m
        mujoco.mj_collision(model, data)
        if not data.ncon:
            return _NO_DISTANCES, _NO_BODIES
        contact = data.contact
        distances, bodies = contact.dist, model.geom_bodyid[contact.geom]
        if self._allowed_numbers:
            counts = ~self._is_allowed[bodies[:, 0], bodies[:, 1]]
            return distances[counts], bodies[counts]
        return distances, bodies

    def collisions(self) -> list[Approach]:
        """Return the pairs of bodies that touch or overlap, the deepest first."""
        return [one for one in self.near(0.0) if one.distance_m <= 0.0]
