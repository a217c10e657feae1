"""The servo's step: one command and one period to joint positions that are safe to send."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.clearance import Approach, ClearanceChecker
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.poses import Array, rotation_vector
from teleopctl.kinematics.servo.limits import (
    common_step,
    stoppable_part,
    stoppable_speed,
    stopping_time_s,
)
from teleopctl.kinematics.servo.singularity import Thresholds, TwistMap
from teleopctl.kinematics.servo.status import Reason, ServoStep, StatusCode
from teleopctl.kinematics.solver import PoseTask, served_task

# Distance (m) at which the speed towards another body is 0, and that which no motion falls below.
_TOUCH_M, _KEPT_M = 0.002, 0.001
# A command whose speed is reduced to less than this part has been halted.
_HALTED = 0.02
# Joints slower than this (rad/s or m/s) are still.
_STILL = 1e-6
# Time, s, from rest to the largest speed while a pose is approached.
_RAMP_S = 0.2


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """Settings of servo, with the names and defaults of MoveIt Servo's parameters.

    Attributes:
        joint_limit_margins: Distance to the position limits that is kept, rad or m, for all joints
            or for each.
        self_collision_proximity_threshold: Distance between links, m, from which motion slows.
        scene_collision_proximity_threshold: Distance to obstacles, m, from which motion slows.
        thresholds: Conditions of the Jacobian at which directions are slowed and given up.
        halt_all_joints_in_joint_mode: Whether one joint at its limit halts all.
        halt_all_joints_in_cartesian_mode: Whether one joint at its limit halts the tool; else the
            other joints keep moving, and the tool leaves its direction.
        linear: Largest linear speed while a pose is tracked, m/s.
        rotational: Largest angular speed while a pose is tracked, rad/s.
        linear_tolerance: Distance at which a tracked pose counts as reached, m.
        angular_tolerance: Angle at which a tracked pose counts as reached, rad.
    """

    joint_limit_margins: tuple[float, ...] = (0.1,)
    self_collision_proximity_threshold: float = 0.01
    scene_collision_proximity_threshold: float = 0.02
    thresholds: Thresholds = field(default_factory=Thresholds)
    halt_all_joints_in_joint_mode: bool = True
    halt_all_joints_in_cartesian_mode: bool = True
    linear: float = 0.4
    rotational: float = 0.8
    linear_tolerance: float = 0.001
    angular_tolerance: float = 0.01


class ServoCore:
    """Joint commands that follow a stream of twists, poses or joint velocities.

    The state is the last command. Each step keeps the joints' limits of position, velocity and
    acceleration, slows down before limits, obstacles and singularities so that all joints can still
    stop, and says what made it slower. While nothing does, the tool moves as commanded.

    Args:
        kinematics: Kinematics of the group.
        accelerations: Largest accelerations of its joints, (n,), rad/s² or m/s².
        clearance: Checker of collisions; None to check none.
        settings: Settings.
        task: What of a twist is served; None for what the joints allow.

    Attributes:
        positions: Last commanded positions, (n,), rad or m.
        velocities: Last commanded velocities, (n,), rad/s or m/s.

    Raises:
        UsageError: There is another number of margins than of joints.
    """

    def __init__(
        self,
        kinematics: GroupKinematics,
        accelerations: Array,
        *,
        clearance: ClearanceChecker | None = None,
        settings: ServoSettings | None = None,
        task: PoseTask | None = None,
    ) -> None:
        self.kinematics = kinematics
        self.set_clearance(clearance)
        self.task = served_task(kinematics) if task is None else task
        self._accelerations = np.asarray(accelerations, np.float64)
        self._speeds = np.array([limit.velocity for limit in kinematics.limits])
        self.positions = kinematics.present()
        self.velocities = np.zeros(len(kinematics.names))
        # Each near pair of bodies, the nearest first, and its separation, (n,).
        self._near: list[tuple[Approach, Array]] = []
        self.set_settings(settings or ServoSettings())

    def set_settings(self, settings: ServoSettings) -> None:
        """Change the settings between two steps.

        Raises:
            UsageError: There is another number of margins than of joints.
        """
        count = len(self.kinematics.names)
        margins = settings.joint_limit_margins
        if len(margins) not in (1, count):
            raise UsageError(
                f"joint_limit_margins has {len(margins)} values for {count} joints: give one, or "
                "one for each"
            )
        self.settings = settings
        lower, upper = self.kinematics.lower, self.kinematics.upper
        # A margin is at most half of what a joint has.
        most = 0.5 * np.where(np.isfinite(upper - lower), upper - lower, math.inf)
        margin = np.minimum(np.broadcast_to(np.array(margins), (count,)), most)
        self._lower, self._upper = lower + margin, upper - margin
        self._map = TwistMap(self.kinematics, self.task, settings.thresholds)

    def set_clearance(self, clearance: ClearanceChecker | None) -> None:
        """Set the checker of collisions; None to check none."""
        self.clearance = clearance
        self._edges = None if clearance is None else EdgeChecker(self.kinematics, clearance)

    def reset(self, positions: Array) -> None:
        """Set the state to measured positions, (n,), at rest."""
        self.positions = np.array(positions, np.float64)
        self.velocities = np.zeros(len(self.positions))

    @property
    def is_still(self) -> bool:
        """Whether the last command was to stand still."""
        return bool(np.abs(self.velocities).max(initial=0.0) <= _STILL)

    def twist_step(self, twist: Array, period_s: float) -> ServoStep:
        """Return the step for a twist of the tool.

        Args:
            twist: Linear (m/s) and angular (rad/s) velocity of the tool in the axes of the root
                link, (6,).
            period_s: Time until the next step, s.
        """
        self.kinematics.set(self.positions)
        return self._cartesian_step(self.kinematics.model.twist_to_world(twist), period_s)

    def pose_step(self, T_root_target: Array, period_s: float) -> ServoStep:
        """Return the step towards a pose of the tool in the root link's frame, (4, 4).

        The tool approaches on a straight line, with the speeds of the settings, and stops there.
        """
        self.kinematics.set(self.positions)
        target = self.kinematics.model.to_world(T_root_target)
        position, rotation = self.kinematics.world_pose()
        way = target[:3, 3] - position
        turn = rotation_vector(target[:3, :3] @ rotation.T)
        settings = self.settings
        twist = np.concatenate(
            (
                _approach(way, settings.linear, settings.linear_tolerance, period_s),
                _approach(turn, settings.rotational, settings.angular_tolerance, period_s),
            )
        )
        if self.task is not PoseTask.POSE and not self._map.has_rest:
            twist[3:] = 0.0
        return self._cartesian_step(twist, period_s)

    def joint_step(self, velocities: Array, period_s: float) -> ServoStep:
        """Return the step for velocities of the joints, (n,), rad/s or m/s."""
        self.kinematics.set(self.positions)
        wanted = np.asarray(velocities, np.float64)
        return self._step(wanted, [], period_s, self.settings.halt_all_joints_in_joint_mode)

    def target_step(
        self, targets: Mapping[str, float], speeds: Array, period_s: float
    ) -> ServoStep:
        """Return the step of some joints towards positions, where they stop.

        Args:
            targets: Positions by joint, rad or m.
            speeds: Largest speeds of all joints, (n,).
            period_s: Time until the next step, s.
        """
        self.kinematics.set(self.positions)
        wanted = np.zeros(len(self.positions))
        for place, name in enumerate(self.kinematics.names):
            if name not in targets:
                continue
            left = float(np.clip(targets[name], self._lower[place], self._upper[place]))
            left -= float(self.positions[place])
            stoppable = stoppable_speed(
                np.array([abs(left)]), self._accelerations[place : place + 1], period_s
            )
            wanted[place] = math.copysign(min(float(stoppable[0]), float(speeds[place])), left)
        return self._step(wanted, [], period_s, halts_all=False)

    def halt_step(self, period_s: float) -> ServoStep:
        """Return the step that decelerates all joints together, within their limits."""
        self._near = []
        return self._finish(np.zeros(len(self.positions)), [], period_s, scale=1.0)

    # --- parts of a step ------------------------------------------------------------------------

    def _cartesian_step(self, twist: Array, period_s: float) -> ServoStep:
        wanted, reasons = self._map.velocities(self.positions, twist, self.velocities)
        halts_all = self.settings.halt_all_joints_in_cartesian_mode
        return self._step(wanted, reasons, period_s, halts_all)

    def _step(
        self, wanted: Array, reasons: list[Reason], period_s: float, halts_all: bool
    ) -> ServoStep:
        speed = np.abs(wanted)
        size = float(speed.max(initial=0.0))
        self._near = []
        if size == 0.0:
            return self._finish(wanted, reasons, period_s, scale=1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = float(np.min(np.where(speed > 0.0, self._speeds / speed, math.inf)))
        scale = min(1.0, scale)
        scale, wanted = self._before_limits(scale, wanted, reasons, period_s, halts_all)
        if self.clearance is not None and scale > 0.0:
            scale = self._before_obstacles(scale, wanted, reasons, period_s)
        return self._finish(scale * wanted, reasons, period_s, scale)

    def _before_limits(
        self,
        scale: float,
        wanted: Array,
        reasons: list[Reason],
        period_s: float,
        halts_all: bool,
    ) -> tuple[float, Array]:
        """Return the fraction of the speed at which all joints still stop before their limits."""
        rising = wanted > 0.0
        distance = np.where(rising, self._upper - self.positions, self.positions - self._lower)
        speed = np.abs(wanted)
        # What a joint does only by rounding halts nothing.
        counts = speed > 1e-4 * float(speed.max())
        stop_s = stopping_time_s(wanted, self._accelerations)
        parts = np.where(counts, stoppable_part(distance, speed, stop_s, period_s), math.inf)
        least = float(parts.min())
        if least >= scale:
            return scale, wanted
        at_limit = parts < min(scale, _HALTED)
        bound = at_limit if at_limit.any() else parts <= least
        for place in np.flatnonzero(bound).tolist():
            limit = self._upper[place] if rising[place] else self._lower[place]
            word, name = "upper" if rising[place] else "lower", self.kinematics.names[place]
            reasons.append(
                Reason(
                    StatusCode.JOINT_BOUND,
                    f"joint '{name}' is near its {word} limit ({float(limit):.4g} with its margin)",
                    self._place(self.kinematics.model.joint_origin(name)),
                )
            )
        if halts_all:
            return least, wanted
        allowed = np.maximum(distance, 0.0) / (period_s + 0.5 * scale * stop_s) / scale
        return scale, np.clip(wanted, -allowed, allowed)

    def _before_obstacles(
        self, scale: float, wanted: Array, reasons: list[Reason], period_s: float
    ) -> float:
        """Return the fraction of the speed at which the joints stop before two bodies collide."""
        assert self._edges is not None
        settings = self.settings
        threshold = max(
            settings.self_collision_proximity_threshold,
            settings.scene_collision_proximity_threshold,
        )
        stop_s = stopping_time_s(scale * wanted, self._accelerations)
        way = scale * wanted * (0.5 * stop_s + period_s)
        near = self._edges.within_motion(way, threshold + _TOUCH_M)
        if not near:
            return scale
        self._near = [(one, one.separation(self.kinematics)) for one in near]
        free = np.array([one.distance_m for one in near]) - _TOUCH_M
        approach = -scale * (np.array([row for _, row in self._near]) @ wanted)
        own = np.where(
            [one.is_self for one in near],
            settings.self_collision_proximity_threshold,
            settings.scene_collision_proximity_threshold,
        )
        stoppable = stoppable_part(free, np.maximum(approach, 0.0), stop_s, period_s)
        parts = np.where(
            approach > 1e-9, scale * np.minimum(stoppable, np.maximum(free, 0.0) / own), scale
        )
        place = int(np.argmin(parts))
        least = float(parts[place])
        which = near[place] if least < scale else None
        if which is not None:
            code = (
                StatusCode.HALT_FOR_COLLISION
                if least < _HALTED
                else StatusCode.DECELERATE_FOR_COLLISION
            )
            reasons.append(self._collision(code, which))
        return least

    def _finish(
        self, wanted: Array, reasons: list[Reason], period_s: float, scale: float
    ) -> ServoStep:
        velocities = common_step(self.velocities, wanted, self._accelerations, period_s)
        if wanted.any() and not self._can_stop(velocities, period_s, reasons):
            # The way on which the joints stop from the last command was free.
            still = np.zeros(len(wanted))
            velocities = common_step(self.velocities, still, self._accelerations, period_s)
        self.velocities = np.where(np.abs(velocities) <= _STILL, 0.0, velocities)
        self.positions = self.positions + self.velocities * period_s
        is_moving = not self.is_still or bool(np.abs(wanted).max(initial=0.0) > _STILL)
        return ServoStep(
            self.positions, self.velocities, is_moving, tuple(dict.fromkeys(reasons)), scale
        )

    def _can_stop(self, velocities: Array, period_s: float, reasons: list[Reason]) -> bool:
        """Return whether all can still stop before limits and obstacles, at velocities, (n,).

        The joints move on for a period and then stop together, so that they stay on a straight
        line in joint space, which is checked against collisions as a planned motion is. Appends
        a reason if it is not free.
        """
        if not velocities.any():
            return True
        time_s = period_s + 0.5 * stopping_time_s(velocities, self._accelerations)
        way = velocities * time_s
        above = (way > _STILL) & (way > self._upper - self.positions + _STILL)
        below = (way < -_STILL) & (way < self._lower - self.positions - _STILL)
        if above.any() or below.any():
            return False
        if self._edges is None or self.clearance is None:
            return True
        nearest = self._near[0] if self._near else None
        distance_m = math.inf if nearest is None else nearest[0].distance_m
        if distance_m <= 0.0:
            # Out of a collision: all pairs have to move apart.
            return all(
                float(row @ velocities) >= 0.0 for one, row in self._near if one.distance_m <= 0.0
            )
        self._edges.least_m = min(_KEPT_M, 0.5 * distance_m)
        if self._edges.is_edge_free(self.positions, self.positions + way):
            return True
        if nearest is not None:
            reasons.append(self._collision(StatusCode.HALT_FOR_COLLISION, nearest[0]))
        return False

    def _collision(self, code: StatusCode, one: Approach) -> Reason:
        first, second = one.bodies
        text = f"'{first}' is {max(one.distance_m, 0.0):.3f} m from '{second}'"
        return Reason(code, text, self._place(self.kinematics.model.to_root(one.point)))

    @staticmethod
    def _place(point: Array) -> tuple[float, float, float]:
        x, y, z = point.tolist()
        return x, y, z


def _approach(way: Array, most: float, tolerance: float, period_s: float) -> Array:
    """Return the velocity, (3,), towards a target, which falls so that the tool stops there.

    Args:
        way: Way that is left, (3,), m or rad.
        most: Largest speed, m/s or rad/s.
        tolerance: Distance at which the target is reached, m or rad.
        period_s: Time until the next step, s.
    """
    distance = math.sqrt(float(way @ way))
    if distance <= 0.1 * tolerance:
        return np.zeros(3)
    stop = math.sqrt(2.0 * distance * most / _RAMP_S)
    speed = min(most, stop, 0.5 * distance / period_s)
    return np.asarray(way * (speed / distance))
