"""Joint velocities for a twist, slowed down along directions near a singularity.

The Jacobian J = U S V^T of the served task, with lengths in units of the arm's reach, maps each
direction v_i of the joints to a direction u_i of the tool, s_i times as fast. Where the condition
s_1/s_i of a direction exceeds a threshold and grows, the whole command slows down by its part along
u_i, so that the tool keeps its path; from halfway to a second threshold on, that part itself fades,
down to nothing. Other directions, and the way back, keep their speed. At the singularity itself s_i
is 0 and no joint velocity moves the tool along u_i at once, but motion along v_i does so by its
curvature c = u_i^T (dJ/dv_i) v_i: a stretched arm retracts by bending its elbow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.poses import Array
from teleopctl.kinematics.servo.status import FOLDED, STRETCHED, Reason, StatusCode
from teleopctl.kinematics.solver import PoseTask

# Step (rad or m) for derivatives of the Jacobian.
_STEP = 1e-4
# Part of a joint's range at each end in which the null motion of a redundant arm leaves the limit.
_NEAR_END = 0.15
# Least curvature, m/rad² or 1/rad, that counts as a way out of a singularity.
_LEAST_CURVATURE = 1e-3
# Least part of a lost direction that leads away from the first joint, or towards it, at an end of
# the arm's reach.
_LEAST_OUTWARD = 0.5
# Speed (rad/s or m/s) along a direction of the joints from which they move that way already.
_MOVING = 1e-3


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Conditions s_1/s_i from which a direction is slowed down, and at which it is given up.

    Source: the parameters ``lower_singularity_threshold`` and ``hard_stop_singularity_threshold``
    of MoveIt Servo.
    """

    lower: float = 17.0
    hard_stop: float = 30.0


class TwistMap:
    """Map from twists of a group's tool to joint velocities.

    Args:
        kinematics: Kinematics of the group.
        task: What the group serves of a twist: all of it, or its linear part first and of the
            angular part what is left.
        thresholds: Conditions at which directions are slowed down.

    Attributes:
        has_rest: Whether joints are left for an angular part that is not served as a whole.
    """

    def __init__(self, kinematics: GroupKinematics, task: PoseTask, thresholds: Thresholds) -> None:
        self._kinematics = kinematics
        self.thresholds = thresholds
        reach = kinematics.reach_m
        self._units = np.array([reach, reach, reach, 1.0, 1.0, 1.0])
        self._present = np.zeros(len(kinematics.names))
        self._rows = 6 if task is PoseTask.POSE else 3
        whole, linear = kinematics.dimensions
        self._rank = min(whole if task is PoseTask.POSE else linear, self._rows)
        self._rest = max(whole - linear, 0) if task is not PoseTask.POSE else 0
        self.has_rest = self._rest > 0
        span = kinematics.upper - kinematics.lower
        self._span = np.where(np.isfinite(span), span, np.inf)

    def velocities(
        self, positions: Array, twist: Array, present: Array
    ) -> tuple[Array, list[Reason]]:
        """Return joint velocities, (n,), for a twist, and the reasons for any reduction.

        Args:
            positions: Positions of the joints, (n,), at which the model is set.
            twist: Linear (m/s) and angular (rad/s) velocity of the tool in the world frame, (6,).
            present: Present velocities of the joints, (n,).
        """
        self._present = present
        jacobian, twist = self._jacobian(), twist / self._units
        served, reasons = self._served(positions, jacobian[: self._rows], twist[: self._rows])
        if self._rows == 3:
            served, more = self._add_rest(served, jacobian, twist)
            reasons += more
        return served, reasons

    def _jacobian(self) -> Array:
        """Return the Jacobian of the tool, (6, n), with lengths in units of the arm's reach."""
        return np.asarray(self._kinematics.world_jacobian() / self._units[:, None])

    def _served(
        self, positions: Array, jacobian: Array, twist: Array
    ) -> tuple[Array, list[Reason]]:
        left, values, right = np.linalg.svd(jacobian, full_matrices=False)
        largest = float(values[0]) or 1.0
        least = largest / self.thresholds.hard_stop
        along = left.T @ twist
        count = min(self._rank, len(values))
        gains = along[:count] / np.maximum(values[:count], least)
        wanted = right[:count].T @ gains
        reasons: list[Reason] = []
        if float(values[count - 1]) * self.thresholds.lower < largest:
            wanted = self._slowed(positions, jacobian, (left, values, right), gains, along, reasons)
        if len(self._kinematics.names) > count:
            wanted = wanted + self._away_from_limits(positions, right[:count], wanted)
        return wanted, reasons

    def _slowed(
        self,
        positions: Array,
        jacobian: Array,
        parts: tuple[Array, Array, Array],
        gains: Array,
        along: Array,
        reasons: list[Reason],
    ) -> Array:
        """Return joint velocities that are reduced in near-singular directions."""
        left, values, right = parts
        lower, hard = self.thresholds.lower, self.thresholds.hard_stop
        largest = float(values[0]) or 1.0
        gains = gains.copy()
        wanted = right[: len(gains)].T @ gains
        size = float(np.abs(wanted).max())
        change = self._change(positions, jacobian, wanted / size) if size > 0.0 else None
        command = float(np.abs(along).max())
        size_of_command = float(np.linalg.norm(along)) or 1.0
        middle, whole = 0.5 * (lower + hard), 1.0
        for place in range(len(gains)):
            condition = largest / max(float(values[place]), 1e-12)
            if condition <= lower or abs(float(along[place])) <= 1e-3 * command:
                continue
            u, v = left[:, place], right[place]
            is_leaving = change is not None and float(u @ change @ v) > 0.0
            if condition < 4.0 * hard and is_leaving:
                if condition >= hard:
                    reasons.append(
                        Reason(
                            StatusCode.DECELERATE_FOR_LEAVING_SINGULARITY,
                            f"{_direction(u)} slowly, out of a singularity",
                        )
                    )
                continue
            if condition >= hard:
                way_out = self._way_out(positions, jacobian, u, v, float(along[place]))
                if way_out:
                    gains[place] = way_out * abs(float(along[place])) * hard / largest
                    code = StatusCode.DECELERATE_FOR_LEAVING_SINGULARITY
                    text = f"{_direction(u)} slowly, out of a singularity"
                else:
                    gains[place] = 0.0
                    code = StatusCode.HALT_FOR_SINGULARITY
                    end = self._end_of_reach(positions, jacobian, u, v, float(along[place]))
                    text = f"no motion {_direction(u)}: the arm is at a singularity{end}"
                reasons.append(Reason(code, text))
                continue
            share = abs(float(along[place])) / size_of_command
            whole = min(whole, 1.0 - share * min(1.0, (condition - lower) / (middle - lower)))
            gains[place] *= min(1.0, (hard - condition) / (hard - middle))
            code = StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY
            end = self._end_of_reach(positions, jacobian, u, v, float(along[place]))
            reasons.append(Reason(code, f"slower {_direction(u)}: a singularity is near{end}"))
        return np.asarray(right[: len(gains)].T @ (whole * gains))

    def _change(self, positions: Array, jacobian: Array, direction: Array) -> Array:
        """Return the derivative of the task's Jacobian along a direction of the joints."""
        self._kinematics.set(positions + _STEP * direction)
        moved = self._jacobian()[: self._rows]
        self._kinematics.set(positions)
        return np.asarray((moved - jacobian) / _STEP)

    def _end_of_reach(
        self, positions: Array, jacobian: Array, u: Array, v: Array, speed: float
    ) -> str:
        """Return in words at which end of its reach the arm is; empty if it is at none.

        At the end of the reach the tool goes back along u whichever way the joints move along v.
        """
        curvature = float(u @ self._change(positions, jacobian, v) @ v)
        if math.copysign(curvature, curvature * speed) > -_LEAST_CURVATURE:
            return ""
        kinematics = self._kinematics
        away = kinematics.pose()[:3, 3] - kinematics.model.joint_origin(kinematics.names[0])
        outward = kinematics.model.twist_to_world(np.concatenate((away, np.zeros(3))))[:3]
        part = math.copysign(1.0, speed) * float(u[:3] @ outward)
        part /= float(np.linalg.norm(outward)) or 1.0
        if abs(part) < _LEAST_OUTWARD:
            return ""
        return f" ({STRETCHED if part > 0.0 else FOLDED})"

    def _way_out(
        self, positions: Array, jacobian: Array, u: Array, v: Array, speed: float
    ) -> float:
        """Return the sign of motion along v that moves the tool along u by curvature, or 0."""
        curvature = float(u @ self._change(positions, jacobian, v) @ v)
        if curvature * speed <= 0.0 or abs(curvature) < _LEAST_CURVATURE:
            return 0.0
        # Both ways lead out of it: the present one, else that with more room to the limits.
        moving = float(v @ self._present)
        if abs(moving) > _MOVING:
            return 1.0 if moving > 0.0 else -1.0
        if float(v[int(np.argmax(np.abs(v)))]) < 0.0:
            # A decomposition gives either of v and -v.
            return -self._roomier(positions, -v)
        return self._roomier(positions, v)

    def _roomier(self, positions: Array, v: Array) -> float:
        """Return 1 if the joints have more room to their limits along v than against it, or -1."""
        kinematics = self._kinematics
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = np.where(v > 0.0, kinematics.upper - positions, kinematics.lower - positions)
            behind = np.where(v > 0.0, kinematics.lower - positions, kinematics.upper - positions)
            moves = np.abs(v) > 1e-6
            room_ahead = float(np.min(np.abs(ahead / v)[moves], initial=np.inf))
            room_behind = float(np.min(np.abs(behind / v)[moves], initial=np.inf))
        return 1.0 if room_ahead >= room_behind else -1.0

    def _away_from_limits(self, positions: Array, right: Array, wanted: Array) -> Array:
        """Return null-space motion of joints away from their limits."""
        speed = float(np.abs(wanted).max(initial=0.0))
        if speed == 0.0:
            return wanted
        kinematics = self._kinematics
        below = (kinematics.lower - positions) / self._span + _NEAR_END
        above = (positions - kinematics.upper) / self._span + _NEAR_END
        push = np.where(below > 0.0, below, 0.0) - np.where(above > 0.0, above, 0.0)
        push = np.nan_to_num(push, nan=0.0, posinf=0.0, neginf=0.0) * (speed / _NEAR_END)
        if not push.any():
            return np.asarray(push)
        return np.asarray(push - right.T @ (right @ push))

    def _add_rest(self, served: Array, jacobian: Array, twist: Array) -> tuple[Array, list[Reason]]:
        """Add the angular velocity that is possible without moving the tool's origin."""
        angular = twist[3:]
        speed = float(np.abs(angular).max())
        if speed == 0.0:
            return served, []
        if not self._rest:
            text = f"{len(self._kinematics.names)} joints cannot turn the tool in place"
            return served, [Reason(StatusCode.NO_WARNING, text)]
        linear = jacobian[:3]
        null = np.eye(linear.shape[1]) - np.linalg.pinv(linear, rcond=1.0 / 30.0) @ linear
        free = jacobian[3:] @ null
        turn = np.linalg.pinv(free, rcond=1.0 / 30.0) @ (angular - jacobian[3:] @ served)
        return np.asarray(served + null @ turn), []


def _direction(u: Array) -> str:
    """Return a direction of the tool, (3,) or (6,), in words."""
    names = ("along x", "along y", "along z", "about x", "about y", "about z")
    place = int(np.argmax(np.abs(u)))
    if abs(float(u[place])) > 0.9:
        return names[place]
    inner = ", ".join(f"{float(value):.2f}" for value in u[:3])
    if float(np.abs(u[:3]).max()) >= float(np.abs(u[3:]).max(initial=0.0)):
        return f"along ({inner})"
    return f"about ({', '.join(f'{float(value):.2f}' for value in u[3:])})"
