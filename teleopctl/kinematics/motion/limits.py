"""Limits of a motion: velocities, accelerations and jerks of the joints of a group."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.poses import Array
from teleopctl.robot import STOPPING_TIME_S, stop_decelerations

# Velocity of a joint without a limit, rad/s or m/s, as MoveIt's time parameterizations assume.
_DEFAULT_VELOCITY = 1.0
# Time, s, in which a joint without a jerk limit builds up its acceleration.
_JERK_TIME_S = 0.1


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Largest velocities, accelerations and jerks of n joints, in both directions.

    Attributes:
        velocities: Velocities, (n,), rad/s or m/s.
        accelerations: Accelerations and decelerations, (n,), rad/s² or m/s².
        jerks: Jerks, (n,), rad/s³ or m/s³; infinite where jerk does not matter.
        assumed: Assumptions where the description has no limit, one sentence each.
    """

    velocities: Array
    accelerations: Array
    jerks: Array
    assumed: tuple[str, ...] = field(default=(), compare=False)

    @classmethod
    def of(
        cls,
        kinematics: GroupKinematics,
        accelerations: Mapping[str, float] | None = None,
        jerks: Mapping[str, float] | None = None,
    ) -> MotionLimits:
        """Return the limits of a group's independent joints.

        A joint without a velocity limit moves at 1 rad/s or 1 m/s. One without an acceleration
        limit reaches its velocity in 0.2 s (as `stop_decelerations` assumes), and one without a
        jerk limit its acceleration in 0.1 s. The velocities of mimic joints limit their leaders.

        Args:
            kinematics: Kinematics of the group.
            accelerations: Accelerations by joint, such as those of ``joint_limits.yaml``, which
                precede those of the description.
            jerks: Jerks by joint, likewise.
        """
        names = kinematics.names
        own = dict(zip(names, kinematics.limits, strict=True))
        joints, assumed = kinematics.model.joints, []
        velocities = np.array([limit.velocity for limit in own.values()])
        for name, leader, multiplier, _ in joints.followers(set(names)):
            if leader and multiplier:
                most = joints[name].limits.velocity / abs(multiplier)
                place = names.index(leader)
                velocities[place] = min(velocities[place], most)
        free = ~np.isfinite(velocities)
        if free.any():
            velocities[free] = _DEFAULT_VELOCITY
            which = ", ".join(
                f"'{name}'" for name, is_free in zip(names, free, strict=True) if is_free
            )
            assumed.append(
                f"No velocity limit of {which}: {_DEFAULT_VELOCITY:g} rad/s or m/s is used"
            )
        found, _ = stop_decelerations(own, accelerations or {})
        values = np.array([found[name] for name in names])
        values = np.where(np.isfinite(values), values, velocities / STOPPING_TIME_S)
        jerk = np.array([(jerks or {}).get(name, limit.jerk) for name, limit in own.items()])
        jerk = np.where(np.isfinite(jerk), jerk, values / _JERK_TIME_S)
        return cls(velocities, values, jerk, tuple(assumed))

    def scaled(self, velocity: float, acceleration: float) -> MotionLimits:
        """Return the limits scaled by MoveIt's factors, above 0 to 1; jerk as acceleration.

        Raises:
            UsageError: A factor is not above 0 and at most 1.
        """
        for name, factor in (("velocity", velocity), ("acceleration", acceleration)):
            if not 0.0 < factor <= 1.0:
                raise UsageError(
                    f"The {name} scaling factor is {factor:g}, and must be above 0 and at most 1"
                )
        return MotionLimits(
            velocity * self.velocities,
            acceleration * self.accelerations,
            acceleration * self.jerks,
            self.assumed,
        )
