"""Check of straight motions of the joints against collisions, by conservative advancement.

A state at which two bodies are d apart also clears its surroundings: with the joints dq further,
no point of one body has moved more than sum_j |dq_j| r_j relative to the other one, where r_j is
the farthest that the bodies reach from the axis of a joint j between them. As long as that sum is
below d, they do not touch. Source: Schwarzer, Saha, Latombe 2005 (adaptive dynamic collision
checking).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.kinematics.clearance import Approach, ClearanceChecker
from teleopctl.kinematics.error_codes import MoveItErrorCode, PlanningError
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.poses import Array

StateCondition = Callable[[Array], bool]
"""Further condition on positions of the independent joints, (n,): whether they are allowed."""

STEP_RAD = 0.002
"""Steps between two checked states are never shorter, rad or m of the joint that moves most."""
LEAST_M = 0.001
"""Distance between bodies, m, from which a state counts as free: the steps above then touch none
within a metre of the axes."""

# Bodies are looked for within a distance (m) of each other: at first, at least and at most. Farther
# ones make the steps longer and each check slower; so it follows the number of contacts.
_WITHIN_M, _NEAREST_M, _FARTHEST_M = 0.1, 0.02, 0.3
_FEW, _MANY = 5, 12
# Step (rad or m) at which a condition without a distance is checked.
_CONDITION_STEP = 0.02
# Travel (m) that is assumed of a prismatic joint without limits.
_UNLIMITED_M = 10.0


class EdgeChecker:
    """Check of states and of straight motions between them, in the space of a group's joints.

    Args:
        kinematics: Kinematics of the group; `set` moves its model.
        clearance: Checker of collisions; None to check none.
        condition: Further condition on the states; None for none.
        least_m: Distance from which a state is free, m.
        is_canceled: Called at each state, returns whether to end the search; None for never.

    Attributes:
        least_m: Distance from which a state is free, m.
        states: Number of states that have been checked.
    """

    def __init__(
        self,
        kinematics: GroupKinematics,
        clearance: ClearanceChecker | None = None,
        condition: StateCondition | None = None,
        *,
        least_m: float = LEAST_M,
        is_canceled: Callable[[], bool] | None = None,
    ) -> None:
        self.kinematics = kinematics
        self.clearance = clearance
        self.condition = condition
        self.least_m = least_m
        self.states = 0
        self._is_canceled = is_canceled
        self._within_m = _WITHIN_M
        self._rows, self._reach = _pair_reach(kinematics)
        # Contacts that the group cannot change are ignored: those of an object on the ground.
        self._counts = self._reach.max(axis=2) > 0.0

    def is_free(self, positions: Array) -> bool:
        """Return whether a state touches nothing and meets the condition.

        Raises:
            PlanningError: The search is canceled; so do the checks of motions.
        """
        self.count()
        if self.condition is not None and not self.condition(positions):
            return False
        if self.clearance is None:
            return True
        self.kinematics.set(positions)
        distances, bodies = self.clearance.distances(self.least_m)
        if not len(distances):
            return True
        rows = self._rows[bodies]
        touches = (distances <= self.least_m) & self._counts[rows[:, 0], rows[:, 1]]
        return not bool(touches.any())

    def count(self) -> None:
        """Count a state that is checked; end the search here if it is canceled.

        Raises:
            PlanningError: Planning is canceled.
        """
        self.states += 1
        if self._is_canceled is not None and self._is_canceled():
            raise PlanningError("The search was canceled", MoveItErrorCode.PREEMPTED)

    def loosen(self, *states: Array) -> None:
        """Lower `least_m` to half of the distance of bodies that nearly touch at some states."""
        for positions in states:
            found = self.touching(positions)
            if found and found[0][0] > 0.0:
                self.least_m = min(self.least_m, 0.5 * found[0][0])

    def is_edge_free(self, start: Array, end: Array) -> bool:
        """Return whether a straight motion between two states that are free is free.

        The middle is checked first: that is where most motions touch something.
        """
        motion = _Motion(self, start, end)
        # Parts of the motion, as pairs of fractions, that are not cleared yet.
        parts = [(0.0, 1.0)]
        while parts:
            low, high = parts.pop()
            middle = 0.5 * (low + high)
            cleared = motion.cleared(middle)
            if cleared <= 0.0:
                return False
            before, after = middle - cleared, middle + cleared
            if after < high:
                parts.append((after, high))
            if before > low:
                parts.append((low, before))
        return True

    def free_part(self, start: Array, end: Array) -> float:
        """Return the part of a straight motion, 0 to 1, that is free from its start, a free state.

        It ends at the last state that was checked and is free.
        """
        motion = _Motion(self, start, end)
        last = at = 0.0
        while True:
            cleared = motion.cleared(at)
            if cleared <= 0.0:
                return last
            if at >= 1.0:
                return 1.0
            last, at = at, min(1.0, at + max(cleared, 2.0 * motion.least))

    def touch_on_curve(self, points: Array) -> int | None:
        """Return the number of a point of a curve that is not free; None if all of it is free.

        Parts of the curve are halved until the clearance in their middle covers them.

        Args:
            points: Points of the curve, (k, n), near enough to each other for straight motions
                between them.
        """
        ends = [0, len(points) - 1]
        for place in ends:
            if not self.is_free(points[place]):
                return place
        steps = np.abs(np.diff(points, axis=0))
        travelled = np.concatenate((np.zeros((1, points.shape[1])), np.cumsum(steps, axis=0)))
        parts = [(0, len(points) - 1)]
        while parts:
            low, high = parts.pop()
            if high - low < 2:
                if high > low and not self.is_edge_free(points[low], points[high]):
                    return high
                continue
            middle = (low + high) // 2
            most = np.maximum(
                travelled[high] - travelled[middle], travelled[middle] - travelled[low]
            )
            cleared = _Motion(self, points[middle], points[middle] + most).cleared(0.0, 1.0)
            if cleared <= 0.0:
                return middle
            if cleared < 1.0:
                parts += [(middle, high), (low, middle)]
        return None

    def touching(self, positions: Array) -> list[tuple[float, tuple[str, str]]]:
        """Return distance (m) and names of the bodies that keep a state from being free."""
        if self.clearance is None:
            return []
        self.kinematics.set(positions)
        return [
            (one.distance_m, one.bodies)
            for one in self.near(self.least_m)
            if one.distance_m <= self.least_m
        ]

    def within_motion(self, change: Array, least_m: float) -> list[Approach]:
        """Return the pairs of bodies that a motion from the present state may bring together.

        Args:
            change: Change of the joints, (n,), rad or m.
            least_m: Distance, m, up to which pairs are returned in any case.
        """
        assert self.clearance is not None
        displacements, rows = self._reach @ np.abs(change), self._rows
        most = float(displacements.max(initial=0.0))
        return [
            one
            for one in self.clearance.near(min(max(least_m, most), _FARTHEST_M))
            if one.distance_m
            <= max(least_m, float(displacements[rows[one.numbers[0]], rows[one.numbers[1]]]))
        ]

    def near(self, within_m: float) -> list[Approach]:
        """Return the pairs of bodies near each other that the group moves, the nearest first.

        Args:
            within_m: Largest distance, m.
        """
        assert self.clearance is not None
        rows = self._rows
        return [
            one
            for one in self.clearance.near(within_m)
            if self._counts[rows[one.numbers[0]], rows[one.numbers[1]]]
        ]

    def _nearby(self, enough_m: float) -> tuple[Array, npt.NDArray[np.intp], float]:
        """Return distances and bodies of contacts, and the distance (m) up to which they are all.

        Args:
            enough_m: Distance that is enough, m.
        """
        assert self.clearance is not None
        within = max(min(self._within_m, enough_m), self.least_m)
        distances, bodies = self.clearance.distances(within)
        if len(distances) > _MANY:
            self._within_m = max(_NEAREST_M, 0.7 * self._within_m)
        elif len(distances) < _FEW:
            self._within_m = min(_FARTHEST_M, 1.1 * self._within_m)
        return distances, bodies, within


class _Motion:
    """Straight motion of the joints, with the largest displacements of all pairs of bodies."""

    def __init__(self, edges: EdgeChecker, start: Array, end: Array) -> None:
        self.edges = edges
        self.start, self.change = start, end - start
        size = np.abs(self.change)
        self.length = float(size.max(initial=0.0))
        # A state clears at least this much to either side.
        self.least = 0.5 * STEP_RAD / self.length if self.length > 0.0 else math.inf
        # Displacement (m) of each pair of moved bodies from one end to the other.
        self.displacements = edges._reach @ size  # noqa: SLF001 - part of the checker
        self.most = float(self.displacements.max(initial=0.0))

    def cleared(self, fraction: float, wanted: float = 0.5) -> float:
        """Return the part of the motion to either side of a state that is free; 0 if it is not.

        Args:
            fraction: Place of the state, 0 to 1.
            wanted: Part that is enough.
        """
        edges = self.edges
        positions = self.start + fraction * self.change
        edges.count()
        most = math.inf
        if edges.condition is not None:
            if not edges.condition(positions):
                return 0.0
            most = _CONDITION_STEP / self.length if self.length > 0.0 else math.inf
        if edges.clearance is None:
            return most
        edges.kinematics.set(positions)
        distances, bodies, within = edges._nearby(1.001 * wanted * self.most)  # noqa: SLF001
        if self.most > 0.0:
            most = min(most, within / self.most)
        if len(distances):
            rows = edges._rows[bodies]  # noqa: SLF001
            first, second = rows[:, 0], rows[:, 1]
            counts = edges._counts[first, second]  # noqa: SLF001
            if (counts & (distances <= edges.least_m)).any():
                return 0.0
            displacements = np.maximum(self.displacements[first, second], 1e-12)
            most = min(most, float(np.where(counts, distances / displacements, np.inf).min()))
        return max(most, self.least)


def _pair_reach(kinematics: GroupKinematics) -> tuple[Any, Array]:
    """Return which bodies the group moves, and how far pairs of them are moved at most.

    Returns:
        Row of each body of the model in the second result, 0 for those that do not move; and the
        largest displacement of each pair of rows relative to each other, at 1 rad or 1 m of each
        independent joint, (k, k, n), m.
    """
    model = kinematics.model.mj_model
    columns = dict(kinematics.columns())
    upstream: dict[int, dict[int, float]] = {}
    for body in range(1, model.nbody):
        if found := _reaches(model, body, columns):
            upstream[body] = found
    rows = np.zeros(model.nbody, dtype=np.intp)
    count = len(kinematics.names)
    reach = np.zeros((len(upstream) + 1, len(upstream) + 1, count))
    for row, (body, joints) in enumerate(upstream.items(), 1):
        rows[body] = row
        for joint, distance in joints.items():
            column, factor = columns[joint]
            reach[row, 0, column] += factor * distance
            reach[0, row, column] += factor * distance
    for row, (_, joints) in enumerate(upstream.items(), 1):
        for other, (_, others) in enumerate(upstream.items(), 1):
            for joint, distance in [*joints.items(), *others.items()]:
                # A joint that moves both moves neither relative to the other.
                if (joint in joints) != (joint in others):
                    column, factor = columns[joint]
                    reach[row, other, column] += factor * distance
    return rows, reach


def _reaches(model: Any, body: int, columns: dict[int, tuple[int, float]]) -> dict[int, float]:
    """Return the largest distance of a body's surface from the axis of each joint that moves it.

    Args:
        model: MuJoCo's model.
        body: Number of the body.
        columns: The group's joints by MuJoCo's number.

    Returns:
        Largest displacement of a point of the body at 1 rad or 1 m of a joint, m, by the joint's
        number.
    """
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    collides = [
        geom
        for geom in range(first, first + count)
        if model.geom_contype[geom] or model.geom_conaffinity[geom]
    ]
    if not collides:
        return {}
    found: dict[int, float] = {}
    # Spheres about the body's geoms in the frame of the body at hand.
    centres, radii = np.array(model.geom_pos[collides]), np.array(model.geom_rbound[collides])
    at = body
    while at > 0:
        joints = _joints_of(model, at)
        # With several joints in one body, each is moved by the others.
        slack = sum(_travel(model, joint) for joint in joints) if joints[1:] else 0.0
        for joint in joints:
            if joint in columns:
                found[joint] = 1.0
            if joint in columns and not _is_slide(model, joint):
                across = centres - model.jnt_pos[joint]
                if not slack:
                    axis = model.jnt_axis[joint]
                    across = across - np.outer(across @ axis, axis)
                found[joint] = float((np.linalg.norm(across, axis=1) + radii).max()) + slack
        radii = radii + sum(_travel(model, joint) for joint in joints if _is_slide(model, joint))
        if not all(_is_slide(model, joint) for joint in joints):
            # The body turns in its parent: only the distance from the anchor stays as it is.
            anchor = np.array(model.jnt_pos[joints[0]])
            radii = np.array([float((np.linalg.norm(centres - anchor, axis=1) + radii).max())])
            radii = radii + slack
            centres = anchor[None, :]
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, np.array(model.body_quat[at]))
        centres = centres @ rotation.reshape(3, 3).T + model.body_pos[at]
        at = int(model.body_parentid[at])
    return found


def _is_slide(model: Any, joint: int) -> bool:
    return bool(model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE)


def _travel(model: Any, joint: int) -> float:
    """Return the largest displacement (m) by a joint of the axis of another joint of its body."""
    if not _is_slide(model, joint):
        return 2.0 * float(np.linalg.norm(model.jnt_pos[joint]))
    if not model.jnt_limited[joint]:
        return _UNLIMITED_M
    # From MuJoCo's reference position, at which the body is at its place in the parent.
    rest = float(model.qpos0[model.jnt_qposadr[joint]])
    return float(np.abs(model.jnt_range[joint] - rest).max())


def _joints_of(model: Any, body: int) -> list[int]:
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    return list(range(first, first + count))
