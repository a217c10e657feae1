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


def clear_scale(
    distance_m: float, speed_m_s: float, stop_s: float, period_s: float, threshold_m: float
) -> float:
    """Return the part of a speed, 0 to 1, with which two bodies still stop before they touch.

    At the part k of the speed v, the bodies approach by k v T in the next period and then, while
    the joints stop together in the time k t, by (k v)(k t)/2. Nearer than a threshold, k falls in
    proportion to the distance as well.

    Args:
        distance_m: Distance between the bodies that may be used, m.
        speed_m_s: Speed of approach of the full command, m/s, above 0.
        stop_s: Time t in which the joints stop from the full command, s.
        period_s: Period T of the commands, s.
        threshold_m: Distance from which the speed falls, m.
    """
    if distance_m <= 0.0:
        return 0.0
    near = min(1.0, distance_m / threshold_m) if threshold_m > 0.0 else 1.0
    half, linear = 0.5 * speed_m_s * stop_s, speed_m_s * period_s
    if half <= 0.0:
        return min(near, distance_m / linear)
    scale = (-linear + float(np.sqrt(linear * linear + 4.0 * half * distance_m))) / (2.0 * half)
    return min(1.0, near, scale)


def common_step(velocities: Array, wanted: Array, accelerations: Array, period_s: float) -> Array:
    """Return velocities, (n,), nearer to the wanted ones, that the accelerations allow in a period.

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
