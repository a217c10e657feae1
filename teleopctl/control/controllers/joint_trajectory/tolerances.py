"""Allowed errors of joints that follow a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StateTolerance:
    """Allowed error of one joint; 0 is "not checked".

    Attributes:
        position: rad or m.
        velocity: rad/s or m/s.
    """

    position: float = 0.0
    velocity: float = 0.0


@dataclass(frozen=True)
class Tolerances:
    """The tolerances that a trajectory is judged by.

    Attributes:
        path: Per joint, while the trajectory runs.
        goal: Per joint, once it has ended.
        goal_time: Seconds that the goal may be late; 0 waits for ever.
    """

    path: tuple[StateTolerance, ...]
    goal: tuple[StateTolerance, ...]
    goal_time: float = 0.0


def violation(
    tolerances: Sequence[StateTolerance],
    names: Sequence[str],
    positions: Sequence[float],
    velocities: Sequence[float],
) -> str | None:
    """The first error that exceeds its tolerance, in words, or None.

    Args:
        tolerances: Per joint.
        names: The joints.
        positions: Position errors, rad or m.
        velocities: Velocity errors, or empty where velocity is not measured.
    """
    for index, tolerance in enumerate(tolerances):
        if 0.0 < tolerance.position < abs(positions[index]):
            return (
                f"joint {names[index]}: Position Error: {positions[index]:f}, "
                f"Position Tolerance: {tolerance.position:f}"
            )
        if velocities and 0.0 < tolerance.velocity < abs(velocities[index]):
            return (
                f"joint {names[index]}: Velocity Error: {velocities[index]:f}, "
                f"Velocity Tolerance: {tolerance.velocity:f}"
            )
    return None
