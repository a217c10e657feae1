"""Distances between the bodies of a robot, and to its surroundings, by MuJoCo's collision check."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array

Indices = npt.NDArray[np.intp]

# Cached data of a pair of bodies.
_UNKNOWN, _COUNTS, _ALLOWED = 0, 1, 2
_NO_DISTANCES, _NO_NUMBERS = np.zeros(0), np.zeros(0, dtype=np.intp)
_NO_PAIRS = np.zeros((0, 2), dtype=np.intp)


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
        objects: Numbers of the geoms of each object by name: geoms of the world, or those of a body
            that the robot carries.
        may_touch: Further condition under which two bodies or objects, by name, may touch.
        padding_m: Distance, m, by which each geom of the robot counts as larger against
            surroundings, (ngeom,); None for no padding.

    Attributes:
        allowed: Pairs of body names, in alphabetical order, that may touch.
    """

    def __init__(
        self,
        model: KinematicModel,
        allowed: Iterable[tuple[str, str]] = (),
        *,
        objects: Mapping[str, Iterable[int]] | None = None,
        may_touch: Callable[[str, str], bool] | None = None,
        padding_m: Array | None = None,
    ) -> None:
        self._model = model
        self._mj_model, self._mj_data = model.mj_model, model.mj_data
        self._names = [self._mj_model.body(n).name for n in range(self._mj_model.nbody)]
        # Index of each geom's owner: that of its body, or one after all bodies.
        self._owners = np.array(self._mj_model.geom_bodyid)
        robot = set(model.links.values())
        for name, geoms in (objects or {}).items():
            numbers = list(geoms)
            body = int(self._owners[numbers[0]]) if numbers else 0
            if body:
                self._names[body] = name
                robot.add(body)
            else:
                self._owners[numbers] = len(self._names)
                self._names.append(name)
        self._robot = frozenset(robot)
        self._may_touch = may_touch
        self._padding_m = padding_m
        self.allowed: set[tuple[str, str]] = set()
        # Whether a body may touch another one or an object, as far as it has come up. Of two that
        # touch at least one is a body that moves, and has the smaller number.
        self._decided = np.full((self._mj_model.nbody, len(self._names)), _UNKNOWN, np.int8)
        self.allow((*model.touching, *allowed))

    def allow(self, pairs: Iterable[tuple[str, str]]) -> None:
        """Allow further pairs of bodies to touch; unknown names are ignored."""
        self.allowed.update((a, b) if a < b else (b, a) for a, b in pairs)
        self._decided[:] = _UNKNOWN

    def allow_within(self, links: Iterable[str]) -> None:
        """Allow all pairs of some links to touch, such as the fingers of a gripper."""
        names = list(links)
        self.allow((first, second) for first in names for second in names if first < second)

    def near(self, within_m: float) -> list[Approach]:
        """Return all pairs of bodies nearer than a distance, each once, the nearest first.

        Args:
            within_m: The distance, m; 0 for those that touch or overlap.
        """
        found: dict[tuple[int, int], Approach] = {}
        distances, owners, which = self._contacts(within_m)
        contact = self._mj_data.contact
        order = np.argsort(distances, kind="stable")
        for place in order.tolist():
            first, second = owners[place].tolist()
            key = (first, second) if first < second else (second, first)
            if key in found:
                continue
            one = int(which[place])
            bodies = self._mj_model.geom_bodyid[contact.geom[one]].tolist()
            found[key] = Approach(
                float(distances[place]),
                (self._names[first], self._names[second]),
                (bodies[0], bodies[1]),
                first in self._robot and second in self._robot,
                np.array(contact.pos[one]),
                np.array(contact.frame[one, :3]),
            )
        return list(found.values())

    def distances(self, within_m: float) -> tuple[Array, Indices]:
        """Return distances and bodies of all contacts nearer than a distance, in any order.

        A pair of bodies may have several contacts. Costs half of what `near` does.

        Args:
            within_m: The distance, m.

        Returns:
            Distances, (k,), m, negative for bodies that overlap; MuJoCo's numbers of the bodies,
            (k, 2).
        """
        distances, _, which = self._contacts(within_m)
        return distances, self._mj_model.geom_bodyid[self._mj_data.contact.geom[which]]

    def collisions(self) -> list[Approach]:
        """Return the pairs of bodies that touch or overlap, the deepest first."""
        return self.near(0.0)

    def _contacts(self, within_m: float) -> tuple[Array, Indices, Indices]:
        """Return distances, (k,), owners, (k, 2), and numbers, (k,), of the contacts that count."""
        model, padding = self._mj_model, self._padding_m
        # The margins of two geoms are summed, as are those of two bodies, by which MuJoCo leaves
        # out bodies with several geoms as a whole.
        margin = 0.5 * within_m
        model.geom_margin[:] = margin if padding is None else margin + padding
        model.body_margin[:] = margin if padding is None else margin + float(padding.max())
        mujoco.mj_collision(model, self._mj_data)
        if not self._mj_data.ncon:
            return _NO_DISTANCES, _NO_PAIRS, _NO_NUMBERS
        contact = self._mj_data.contact
        geoms, distances = contact.geom, contact.dist
        owners = self._owners[geoms]
        if padding is not None:
            distances = distances - self._padding(padding, geoms, owners)
        less, more = owners.min(axis=1), owners.max(axis=1)
        decided = self._decided[less, more]
        if (decided == _UNKNOWN).any():
            for first, second in {*zip(less.tolist(), more.tolist(), strict=True)}:
                self._decide(first, second)
            decided = self._decided[less, more]
        counts = decided == _COUNTS
        if padding is not None:
            counts &= distances <= within_m
        which = np.flatnonzero(counts)
        return distances[which], owners[which], which

    def _decide(self, first: int, second: int) -> None:
        """Return whether two bodies or objects may touch."""
        names = sorted((self._names[first], self._names[second]))
        may_touch = (names[0], names[1]) in self.allowed or (
            self._may_touch is not None and self._may_touch(names[0], names[1])
        )
        self._decided[first, second] = _ALLOWED if may_touch else _COUNTS

    def _padding(self, padding: Array, geoms: Indices, owners: Indices) -> Array:
        """Return the padding between the geoms of each pair, (c,), m; 0 for two links."""
        is_robot = np.isin(owners, list(self._robot))
        return np.where(is_robot.all(axis=1), 0.0, padding[geoms].sum(axis=1))
