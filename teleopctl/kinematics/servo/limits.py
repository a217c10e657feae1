"""Speeds from which joints can still stop: before a position limit, before an obstacle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from teleopctl.kinematics.poses import Array


def stoppable_speed(distance: Array, deceleration: Array, period_s: float) -> Array:
    """Return the largest speeds, (n,), with which joints stop within distances.

    A joint that moves for one more period at the speed v and then decelerates by a needs
    v T + v²/(2 a); so v = a (sqrt(T² + 2 d/a) - T).

    Args:
        distance: Distances that are left, (n,), rad or m; without any, the speed is 0.
        deceleration: Decelerations, (n,), rad/s² or m/s²; infinite ones stop within a period.
        period_s: Period of the commands, s.
    """
    left = np.maximum(distance, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(period_s * period_s + 2.0 * left / deceleration)
        speed = deceleration * (root - period_s)
    return np.where(np.isfinite(deceleration), speed, left / period_s)


def stopping_time_s(velocities: Array, decelerations: Array) -> float:
    """Return the time, s, in which joints stop together: that of the slowest one."""
    return float(np.max(np.abs(velocities) / decelerations, initial=0.0))


def stoppable_part(distance: Array, speed: Array, stop_s: float, period_s: float) -> Array:
    """Return the parts of speeds, 0 to 1, with which motions still stop within distances.

    At the part k of the speed v, v k T is covered in the next period T. Then all joints stop
    together, in the time k t, which covers (v k)(k t)/2.

    Args:
        distance: Distances that are left, (n,), m or rad; without any, the part is 0.
        speed: Speeds towards their ends, (n,), m/s or rad/s; not negative.
        stop_s: Time t in which the joints stop from the full speed, s.
        period_s: Period T of the commands, s.
    """
    left = np.maximum(distance, 0.0)
    half, linear = 0.5 * speed * stop_s, speed * period_s
    # The root of half k² + linear k - left, in the form that loses no digits.
    with np.errstate(divide="ignore", invalid="ignore"):
        part = 2.0 * left / (linear + np.sqrt(linear * linear + 4.0 * half * left))
    return np.where(
        (speed > 0.0) & (left > 0.0), np.minimum(part, 1.0), np.where(speed > 0.0, 0.0, 1.0)
    )


def common_step(velocities: Array, wanted: Array, accelerations: Array, period_s: float) -> Array:
    """Return velocities, (n,), nearest to the desired ones, that accelerations allow in a period.

    All joints take the same part of the way, so that the direction of the tool changes smoothly.
    """
    change = wanted - velocities
    most = accelerations * period_s
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = np.where(np.abs(change) > most, most / np.abs(change), 1.0)
    return np.asarray(velocities + float(np.min(parts, initial=1.0)) * change)


def named_joints(names: Sequence[str], which: Array) -> str:
    """Return the names of marked joints, quoted."""
    return ", ".join(f"'{name}'" for name, marked in zip(names, which, strict=True) if marked)
