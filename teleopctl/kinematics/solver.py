"""Inverse kinematics: joint positions at which a group's tool has a pose.

Newton steps by a quadratic program, started from several positions. Each step solves

    min |J dq - e|² + mu |dq|²   with   lower <= q + dq <= upper,   |dq| <= 0.5

for the error e of the pose (a twist in the world frame), so that limits bend the path instead of
ending it; the damping mu falls with the square of the error (Sugihara 2011). Obstacles nearer than
5 cm add one row each: n (J_2 - J_1) dq >= d_min - d.
"""

from __future__ import annotations

import enum
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import daqp
import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.poses import Array, rotation_vector

if TYPE_CHECKING:
    from teleopctl.kinematics.clearance import Approach, ClearanceChecker

# Starts beside the given ones, and steps from each.
_RANDOM_STARTS = 40
# Further starts where the pose is reached, but only in collision: an arm of six joints has up to
# eight ways to a pose, and one that is free may be found from few starts (a UR5 among ten near
# obstacles: 992 of 1,000 poses after 40 starts).
_FURTHER_STARTS = 240
_MOST_STEPS = 60
# A start is given up when its best error has not fallen to this part within some steps.
_PROGRESS, _PATIENCE = 0.9, 8
# Largest step of a joint, rad or m.
_LONGEST_STEP = 0.5
# Damping as part of the squared error, and its least value.
_DAMPING, _LEAST_DAMPING = 0.01, 1e-10
# Weight (m/rad) of the rotation in a position task: a soft task, whose cost in position is below
# the tolerance.
_SOFT_WEIGHT = 3e-3
# Rotations are as important as the displacement of a point at this distance (m).
_LEVER_M = 0.3
# Distance (m) below which a position is sought without the soft task, and steps for it.
_SHORT_OF_M, _LAST_STEPS = 0.05, 12
# Starts among which the best rotation is chosen, and those for the axis of a tool: one of 500
# reachable poses of five joints was missed with 24 starts, 25 with six.
_SOFT_STARTS, _AXIS_STARTS = 6, 24
# Distance (m) from which bodies are kept apart, and that is left between them.
_NEAR_M, _LEAST_M = 0.05, 0.001
# Pairs of bodies that are named when a pose is not reached; the deepest overlaps come first.
_MOST_NAMED = 3
# Dimensions of positions.
_SPACE = 3
# How near (rad or m) a joint is to its limit to be named as what binds.
_AT_LIMIT = 1e-6


class PoseTask(enum.Enum):
    """Part of a pose that a group reaches; the rest is met as far as the joints allow."""

    POSE = "pose"
    """Position and rotation."""
    AXIS = "axis"
    """Position, and the direction of the tool's z axis as far as five joints allow."""
    POSITION = "position"
    """Position."""


def served_task(kinematics: GroupKinematics) -> PoseTask:
    """Return a group's own task, else what its degrees of freedom serve: pose with 6, axis with 5.

    Raises:
        UsageError: The group's own task is unknown.
    """
    if own := kinematics.group.task:
        try:
            return PoseTask(own)
        except ValueError:
            known = ", ".join(each.value for each in PoseTask)
            raise UsageError(
                f"The group '{kinematics.group.name}' has the unknown task '{own}'",
                hint=f"Tasks are: {known}",
            ) from None
    whole, _ = kinematics.dimensions
    return PoseTask.POSE if whole >= 6 else PoseTask.AXIS if whole == 5 else PoseTask.POSITION


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Largest errors of a pose that counts as reached."""

    position_m: float = 1e-4
    rotation_rad: float = 1e-3


@dataclass(frozen=True, slots=True)
class IkSolution:
    """Result of inverse kinematics: a solution, or the nearest that was found.

    Attributes:
        positions: Positions of the group's independent joints, (n,), rad or m.
        is_reached: Whether the served part of the pose is reached without a collision.
        position_error_m: Distance between the tool's origin and the target.
        rotation_error_rad: Angle between the tool and the target.
        binding: What keeps the tool from the target, one phrase each; empty if it is reached.
        collisions: Pairs of bodies that touch at the positions.
        starts: Number of positions that the search began from.

    Example:
        >>> from teleopctl import Arm
        >>> arm = Arm("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> found = arm.ik([0.0, 0.0, 3.0])
        >>> found.is_reached, found.binding
        (False, ('the arm is too short',))
    """

    positions: Array
    is_reached: bool
    position_error_m: float
    rotation_error_rad: float
    binding: tuple[str, ...] = ()
    collisions: tuple[tuple[str, str], ...] = ()
    starts: int = 1


class IkSolver:
    """Inverse kinematics of a group.

    Args:
        kinematics: Kinematics of the group.
        task: What of a pose is served; None for what the group's joints allow.
        tolerance: Errors at which a pose counts as reached.
        clearance: Checker of collisions; None to allow all.
    """

    def __init__(
        self,
        kinematics: GroupKinematics,
        *,
        task: PoseTask | None = None,
        tolerance: Tolerance | None = None,
        clearance: ClearanceChecker | None = None,
    ) -> None:
        self.kinematics = kinematics
        self.task = served_task(kinematics) if task is None else task
        self.tolerance = tolerance or Tolerance()
        self.clearance = clearance
        count = len(kinematics.names)
        self._eye = np.eye(count)
        self._no_rows = np.zeros((0, count))
        self._simple = np.zeros(count, dtype=np.int32)
        self._continuous = np.array([limit.angle_wraparound for limit in kinematics.limits])
        finite = np.isfinite(kinematics.lower) & np.isfinite(kinematics.upper)
        middle = 0.5 * (
            np.where(finite, kinematics.lower, 0.0) + np.where(finite, kinematics.upper, 0.0)
        )
        self._middle = kinematics.clamp(middle)

    def solve(
        self,
        T_root_target: Array,
        start: Array,
        *,
        more_starts: Sequence[Array] = (),
        most_starts: int | None = None,
        timeout_s: float | None = None,
    ) -> IkSolution:
        """Search positions at which the tool has a pose.

        The result depends on the arguments only: random starts are the same each time, unless the
        time is over before all have been tried.

        Args:
            T_root_target: Pose of the tool in the root link's frame, (4, 4).
            start: Positions from which the search begins, (n,); clamped into the limits.
            more_starts: Positions that are tried next, before random ones.
            most_starts: Number of starts in all; 1 for a solution near the start, None for no
                limit.
            timeout_s: Time after which no further start is tried; None for no limit.

        Returns:
            The first solution; without one, the nearest positions that were found.

        Raises:
            UsageError: The pose has values that are no numbers, or is no rotation.
        """
        check_pose(T_root_target)
        target = self.kinematics.model.to_world(T_root_target)
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        best: _Candidate | None = None
        count = reached = 0
        most_reached = _AXIS_STARTS if self.task is PoseTask.AXIS else _SOFT_STARTS
        in_collision: Array | None = None
        usual = 2 + len(more_starts) + _RANDOM_STARTS
        for positions in self._starts(start, more_starts):
            if count == usual and (in_collision is None or self._is_blocked(in_collision)):
                break
            count += 1
            found = self._descend(target, positions, avoid=False)
            if self.clearance is not None and found.is_reached:
                in_collision = found.positions
                found = self._without_collision(target, found)
            if best is None or found.is_better_than(best):
                best = found
            if best.is_reached:
                reached += 1
                if best.is_complete or reached >= most_reached:
                    break
            if count == most_starts:
                break
            if deadline is not None and time.monotonic() >= deadline:
                break
        assert best is not None
        return self._solution(best, target, start, count)

    def _is_blocked(self, positions: Array) -> bool:
        """Return whether bodies fixed to the tool collide with fixed ones at a full pose.

        Then it does so at all positions with that pose.
        """
        if self.task is not PoseTask.POSE:
            return False
        assert self.clearance is not None
        self.kinematics.set(positions)
        model = self.kinematics.model
        welds = model.mj_model.body_weldid
        tool = int(welds[model.body(self.kinematics.group.tip)])
        return any(
            {int(welds[number]) for number in one.numbers} == {tool, 0}
            for one in self.clearance.collisions()
        )

    def _starts(self, start: Array, more: Sequence[Array]) -> Iterator[Array]:
        yield self.kinematics.clamp(np.asarray(start, np.float64))
        for positions in (*more, self._middle):
            yield self.kinematics.clamp(np.asarray(positions, np.float64))
        generator = np.random.default_rng(0)
        for _ in range(_RANDOM_STARTS + _FURTHER_STARTS):
            yield self.kinematics.random(generator)

    def _weight(self) -> float:
        """Return the weight of rotations, m/rad."""
        return _LEVER_M if self.task is PoseTask.POSE else _SOFT_WEIGHT

    def _error(self, target: Array) -> tuple[Array, float, float]:
        """Return the weighted error, (6,), the distance (m) and the angle (rad) to a target."""
        position, rotation = self.kinematics.world_pose()
        error = np.empty(6)
        error[:3] = target[:3, 3] - position
        turn = rotation_vector(target[:3, :3] @ rotation.T)
        error[3:] = turn
        distance = math.sqrt(float(error[:3] @ error[:3]))
        angle = math.sqrt(float(turn @ turn))
        error[3:] *= self._weight()
        return error, distance, angle

    def _descend(self, target: Array, start: Array, *, avoid: bool) -> _Candidate:
        kinematics, tolerance = self.kinematics, self.tolerance
        weight = self._weight()
        serves_rotation = self.task is PoseTask.POSE
        positions = start
        best: _Candidate | None = None
        mark, since = math.inf, 0
        for _ in range(_MOST_STEPS):
            kinematics.set(positions)
            error, distance, angle = self._error(target)
            square = float(error @ error)
            near = self._near() if avoid else []
            is_clear = not near or near[0].distance_m > 0.0
            reached = distance <= tolerance.position_m and (
                not serves_rotation or angle <= tolerance.rotation_rad
            )
            complete = reached and angle <= tolerance.rotation_rad
            cost = square if is_clear else square + 1.0
            found = _Candidate(
                positions, cost, distance, angle, reached and is_clear, complete and is_clear
            )
            if best is None or found.is_better_than(best):
                best = found
            if complete and is_clear:
                break
            if cost < _PROGRESS * mark:
                mark, since = cost, 0
            else:
                since += 1
                if since >= _PATIENCE:
                    break
            jacobian = kinematics.world_jacobian()
            jacobian[3:] *= weight
            step = self._step(jacobian, error, square, positions, near)
            if step is None:
                break
            positions = positions + step
            if float(np.abs(step).max()) < 1e-9:
                break
        assert best is not None
        if not serves_rotation and not best.is_reached and best.distance_m <= _SHORT_OF_M:
            return self._without_rotation_task(target, best, avoid=avoid)
        return best

    def _without_rotation_task(
        self, target: Array, near_miss: _Candidate, *, avoid: bool
    ) -> _Candidate:
        """Return the position without the soft rotation task, or the candidate as it is.

        Where the arm hardly moves the tool, as with a stretched elbow, even the small weight of a
        rotation task costs more than the tolerance.
        """
        positions = near_miss.positions
        for _ in range(_LAST_STEPS):
            self.kinematics.set(positions)
            error, distance, angle = self._error(target)
            near = self._near() if avoid else []
            is_clear = not near or near[0].distance_m > 0.0
            if distance <= self.tolerance.position_m and is_clear:
                return _Candidate(positions, float(error @ error), distance, angle, True)
            error[3:] = 0.0
            jacobian = self.kinematics.world_jacobian()
            jacobian[3:] = 0.0
            step = self._step(jacobian, error, float(error @ error), positions, near)
            if step is None:
                break
            positions = positions + step
        return near_miss

    def _step(
        self, jacobian: Array, error: Array, square: float, positions: Array, near: list[Approach]
    ) -> Array | None:
        """Return the step of the joints, (n,); None if there is none within the constraints."""
        hessian = jacobian.T @ jacobian + (_DAMPING * square + _LEAST_DAMPING) * self._eye
        upper = np.minimum(self.kinematics.upper - positions, _LONGEST_STEP)
        lower = np.maximum(self.kinematics.lower - positions, -_LONGEST_STEP)
        gradient = -jacobian.T @ error
        if not near:
            step, _, flag, _ = daqp.solve(
                hessian, gradient, self._no_rows, upper, lower, self._simple
            )
            return step if flag > 0 else None
        rows = np.array([one.separation(self.kinematics) for one in near])
        least = np.array([_LEAST_M - one.distance_m for one in near])
        # Soft: bodies that overlap already can only be moved apart as fast as a step goes.
        sense = np.concatenate((self._simple, np.full(len(near), 8, dtype=np.int32)))
        step, _, flag, _ = daqp.solve(
            hessian,
            gradient,
            rows,
            np.concatenate((upper, np.full(len(near), 1e30))),
            np.concatenate((lower, least)),
            sense,
        )
        return step if flag > 0 else None

    def _near(self) -> list[Approach]:
        assert self.clearance is not None
        return self.clearance.near(_NEAR_M)

    def _without_collision(self, target: Array, found: _Candidate) -> _Candidate:
        """Return a candidate near another one without collisions, or that one as not reached."""
        assert self.clearance is not None
        self.kinematics.set(found.positions)
        if not self.clearance.collisions():
            return found
        moved = self._descend(target, found.positions, avoid=True)
        if moved.is_reached:
            self.kinematics.set(moved.positions)
            if not self.clearance.collisions():
                return moved
        return _Candidate(found.positions, found.cost + 1.0, found.distance_m, found.angle_rad)

    def _solution(self, best: _Candidate, target: Array, start: Array, count: int) -> IkSolution:
        positions = best.positions
        if self._continuous.any():
            # The turn that is nearest to the start.
            turns = np.round((start - positions) / (2.0 * math.pi)) * self._continuous
            positions = positions + 2.0 * math.pi * turns
        self.kinematics.set(positions)
        collisions: tuple[tuple[str, str], ...] = ()
        if self.clearance is not None and not best.is_reached:
            collisions = tuple(one.bodies for one in self.clearance.collisions())
        binding = () if best.is_reached else tuple(self._binding(best, target, collisions))
        return IkSolution(
            positions,
            best.is_reached,
            best.distance_m,
            best.angle_rad,
            binding,
            collisions,
            count,
        )

    def _binding(
        self, best: _Candidate, target: Array, collisions: tuple[tuple[str, str], ...]
    ) -> Iterator[str]:
        """Yield the reasons why the tool cannot reach the target, at the nearest positions."""
        for first, second in collisions[:_MOST_NAMED]:
            yield f"'{first}' and '{second}' would collide"
        if len(collisions) > _MOST_NAMED:
            yield f"{len(collisions) - _MOST_NAMED} more pairs of bodies would collide"
        if best.distance_m <= self.tolerance.position_m and collisions:
            return
        kinematics = self.kinematics
        error, *_ = self._error(target)
        jacobian = kinematics.world_jacobian()
        jacobian[3:] *= self._weight()
        gradient = jacobian.T @ error
        size = float(np.abs(gradient).max(initial=0.0))
        is_bound = False
        for place, name in enumerate(kinematics.names):
            at = float(best.positions[place])
            for limit, direction, word in (
                (kinematics.lower[place], -1.0, "lower"),
                (kinematics.upper[place], 1.0, "upper"),
            ):
                pushes = direction * float(gradient[place]) > 1e-3 * size > 0.0
                if abs(at - float(limit)) <= _AT_LIMIT and pushes:
                    is_bound = True
                    yield f"joint '{name}' is at its {word} limit {float(limit):.4g}"
        if not is_bound and not collisions:
            if best.distance_m <= self.tolerance.position_m:
                yield "the arm cannot turn the tool so"
            elif kinematics.dimensions[1] < _SPACE:
                yield "the joints do not move the tool in that direction"
            else:
                yield "the arm is too short"


@dataclass(frozen=True, slots=True)
class _Candidate:
    """Positions with their errors, during a search."""

    positions: Array
    cost: float
    distance_m: float
    angle_rad: float
    is_reached: bool = False
    is_complete: bool = False

    def is_better_than(self, other: _Candidate) -> bool:
        """Whether this is reached and the other is not, or else costs less."""
        if self.is_reached != other.is_reached:
            return self.is_reached
        return self.cost < other.cost


def check_pose(pose: Array) -> None:
    """Check that a matrix, (4, 4), is a pose.

    Raises:
        UsageError: It has values that are not finite, or its rotation is none.
    """
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise UsageError("The pose has values that are no finite numbers")
    rotation = pose[:3, :3]
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-4):
        raise UsageError("The pose's rotation is no rotation")
