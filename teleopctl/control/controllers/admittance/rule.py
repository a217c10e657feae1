"""Admittance rule: motion of joints that follows from a measured wrench."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul
from typing import NamedTuple

from teleopctl.robot import ChainFrame, SerialChain
from teleopctl.tf import Quaternion, Transform, Vector3, conjugate, multiply, rotate

# Below this sine of half the angle a rotation vector is twice the quaternion's vector.
_TINY = 1e-9


class AdmittanceGains(NamedTuple):
    """Parameters of the rule that may change while it runs; each for x, y, z, rx, ry, rz.

    Attributes:
        selected_axes: Whether a force or torque along the axis counts, in the control frame.
        mass: Mass (kg) and inertia (kg m²) along the axes of the base.
        damping_ratio: Ratio of the damping to the critical one.
        stiffness: Stiffness (N/m, Nm/rad) along the axes of the control frame.
        joint_damping: Deceleration of a joint for each unit of its speed, 1/s.
        filter_coefficient: Weight of a new wrench in the exponential filter, above 0 to 1.
        weight: Weight of the tool, N.
        centre: Centre of gravity of the tool in the gravity compensation frame, m.
    """

    selected_axes: tuple[bool, ...]
    mass: tuple[float, ...]
    damping_ratio: tuple[float, ...]
    stiffness: tuple[float, ...]
    joint_damping: float
    filter_coefficient: float
    weight: float
    centre: Vector3

    @property
    def damping(self) -> tuple[float, ...]:
        """Damping of each axis, Ns/m or Nms/rad: ``D = 2 ratio sqrt(mass stiffness)``."""
        return tuple(
            2.0 * ratio * math.sqrt(mass * stiffness)
            for ratio, mass, stiffness in zip(
                self.damping_ratio, self.mass, self.stiffness, strict=True
            )
        )


@dataclass(frozen=True)
class AdmittanceFrames:
    """Frames of the rule, as frames of the chain of joints.

    Attributes:
        sensor: Frame of the force-torque sensor, whose motion follows the rule.
        control: Frame of stiffness, damping and selected axes.
        world: Frame in which gravity points along negative z.
        gravity: Frame of the tool's centre of gravity.
    """

    sensor: ChainFrame
    control: ChainFrame
    world: ChainFrame
    gravity: ChainFrame


class AdmittanceState(NamedTuple):
    """Values of the rule after an update, as `control_msgs/AdmittanceControllerState` has them.

    Attributes:
        gains: Parameters of the rule.
        control: Rotation of the control frame in the base.
        reference: Pose of the sensor in the base, at the reference positions.
        offset: Translation and rotation of the sensor from the reference.
        acceleration: Acceleration of the offset, linear and angular, in the base.
        velocity: Velocity of the offset, linear and angular, in the base.
        wrench: Filtered force and torque in the base, without the tool's weight.
        joint_positions: Offsets of the joints, rad or m.
        joint_velocities: Velocities of these offsets.
        joint_accelerations: Accelerations of these offsets.
    """

    gains: AdmittanceGains
    control: Quaternion
    reference: Transform
    offset: Transform
    acceleration: tuple[float, ...]
    velocity: tuple[float, ...]
    wrench: tuple[float, ...]
    joint_positions: tuple[float, ...]
    joint_velocities: tuple[float, ...]
    joint_accelerations: tuple[float, ...]


class AdmittanceRule:
    """Rule by which a sensor's frame moves as a mass on a spring and a damper under a wrench.

    In the base frame, with the offset x of the sensor from its reference pose,
    ``M x'' = F - D x' - K x``; K and D are diagonal in the control frame, M in the base. The joints
    follow by the damped inverse of the Jacobian J, ``q'' = (J^T J + alpha I)^-1 J^T x'' - d q'``,
    which is integrated twice. Source: Villani and De Schutter, Force Control, Handbook of Robotics.

    Args:
        chain: Joints from the base to the tip.
        frames: Frames of the rule.
        alpha: Damping of the Jacobian's inverse.
        gains: Parameters that may change.

    Attributes:
        gains: Parameters that may be replaced.
        joint_positions: Offsets of the joints, rad or m, which are added to the references.
        joint_velocities: Velocities of these offsets.
        joint_accelerations: Accelerations of these offsets.
    """

    def __init__(
        self, chain: SerialChain, frames: AdmittanceFrames, alpha: float, gains: AdmittanceGains
    ) -> None:
        self._chain = chain
        self._frames = frames
        self._alpha = alpha
        self.gains = gains
        self.reset()

    def reset(self) -> None:
        """Reset the offsets, their velocities and the filtered wrench to zero."""
        zeros = [0.0] * len(self._chain.joints)
        self.joint_positions: list[float] = list(zeros)
        self.joint_velocities: list[float] = list(zeros)
        self.joint_accelerations: list[float] = list(zeros)
        # Force and torque in the world frame.
        self._wrench: list[float] = [0.0] * 6
        self._velocity: tuple[float, ...] = (0.0,) * 6
        self._acceleration: tuple[float, ...] = (0.0,) * 6
        self._base_wrench: tuple[float, ...] = (0.0,) * 6
        self._reference = self._offset = Transform()
        self._control = self._offset.rotation

    def hold(self, joint_positions: Sequence[float]) -> None:
        """Set the offsets of the joints, at rest."""
        self.joint_positions = list(joint_positions)
        self.joint_velocities = [0.0] * len(joint_positions)
        self.joint_accelerations = [0.0] * len(joint_positions)
        self._velocity = self._acceleration = (0.0,) * 6

    def update(
        self,
        positions: Sequence[float],
        wrench: Sequence[float],
        reference: Sequence[float],
        period: float,
    ) -> bool:
        """Advance the offsets by a period; return False, without a change, if that is impossible.

        Args:
            positions: Measured positions of the joints, in the order of the chain.
            wrench: Force (N) and torque (Nm) in the sensor's frame.
            reference: Reference positions of the joints.
            period: Seconds since the last update.
        """
        chain, frames, gains = self._chain, self._frames, self.gains
        poses = chain.joint_poses(positions)
        sensor = _pose(poses, frames.sensor)
        control = _pose(poses, frames.control).rotation
        self._reference = _pose(chain.joint_poses(reference), frames.sensor)
        world = conjugate(_pose(poses, frames.world).rotation)
        gravity = multiply(world, _pose(poses, frames.gravity).rotation)
        self._filter(wrench, multiply(world, sensor.rotation), gravity)
        back = conjugate(world)
        force, torque = _turned(back, self._wrench)
        self._base_wrench = (*force, *torque)
        self._control = control

        (px, py, pz), (rx, ry, rz) = sensor.translation, self._reference.translation
        turn = multiply(sensor.rotation, conjugate(self._reference.rotation))
        self._offset = Transform((px - rx, py - ry, pz - rz), turn)
        target = self._target_acceleration(rotation_vector(turn))
        columns = chain.jacobian(frames.sensor, poses)
        solution = damped_least_squares(columns, target, self._alpha)
        if solution is None:
            return False
        damping = gains.joint_damping
        accelerations = [
            value - damping * speed
            for value, speed in zip(solution, self.joint_velocities, strict=True)
        ]
        speeds = [
            speed + value * period
            for speed, value in zip(self.joint_velocities, accelerations, strict=True)
        ]
        self.joint_positions = [
            place + speed * period
            for place, speed in zip(self.joint_positions, speeds, strict=True)
        ]
        self.joint_velocities, self.joint_accelerations = speeds, accelerations
        self._velocity = _product(columns, speeds)
        self._acceleration = _product(columns, accelerations)
        return True

    def _filter(self, wrench: Sequence[float], sensor: Quaternion, gravity: Quaternion) -> None:
        """Filter a wrench in the world frame, without the weight of the tool."""
        (fx, fy, fz), (tx, ty, tz) = _turned(sensor, wrench)
        weight = self.gains.weight
        x, y, _ = rotate(gravity, self.gains.centre)
        # The weight (0, 0, -w) at the centre (x, y, z) has the torque (-y w, x w, 0).
        new = (fx, fy, fz + weight, tx + y * weight, ty - x * weight, tz)
        part = self.gains.filter_coefficient
        self._wrench = [
            part * value + (1.0 - part) * old for value, old in zip(new, self._wrench, strict=True)
        ]

    def _target_acceleration(self, turn: Vector3) -> tuple[float, ...]:
        """Return the acceleration of the sensor, linear and angular, in the base frame."""
        gains, control = self.gains, self._control
        inverse = conjugate(control)
        offset = (*self._offset.translation, *turn)
        force, place, speed = (
            [value for part in _turned(inverse, vector) for value in part]
            for vector in (self._base_wrench, offset, self._velocity)
        )
        net = [
            (f if selected else 0.0) - d * v - k * x
            for f, x, v, selected, d, k in zip(
                force,
                place,
                speed,
                gains.selected_axes,
                gains.damping,
                gains.stiffness,
                strict=True,
            )
        ]
        linear, angular = _turned(control, net)
        return tuple(
            value / mass for value, mass in zip((*linear, *angular), gains.mass, strict=True)
        )

    @property
    def state(self) -> AdmittanceState:
        """Values after the last update."""
        return AdmittanceState(
            self.gains,
            self._control,
            self._reference,
            self._offset,
            self._acceleration,
            self._velocity,
            self._base_wrench,
            tuple(self.joint_positions),
            tuple(self.joint_velocities),
            tuple(self.joint_accelerations),
        )


def _pose(poses: Sequence[Transform], frame: ChainFrame) -> Transform:
    return poses[frame.joints] @ frame.offset


def _turned(rotation: Quaternion, vector: Sequence[float]) -> tuple[Vector3, Vector3]:
    """Return the linear and the angular part of a vector of six numbers, rotated."""
    a, b, c, d, e, f = vector
    return rotate(rotation, (a, b, c)), rotate(rotation, (d, e, f))


def _product(columns: Sequence[Sequence[float]], factors: Sequence[float]) -> tuple[float, ...]:
    """Return the product of a matrix of six rows, given by its columns, and a vector."""
    return tuple(
        sum(value * factor for value, factor in zip(row, factors, strict=True))
        for row in zip(*columns, strict=True)
    )


def rotation_vector(q: Quaternion) -> Vector3:
    """Return the axis of a rotation times its angle, from 0 to pi rad."""
    x, y, z, w = q if q[3] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    sine = math.sqrt(x * x + y * y + z * z)
    factor = 2.0 if sine < _TINY else 2.0 * math.atan2(sine, w) / sine
    return x * factor, y * factor, z * factor


def damped_least_squares(
    columns: Sequence[Sequence[float]], target: Sequence[float], damping: float
) -> list[float] | None:
    """Return ``(J^T J + damping I)^-1 J^T target``; None if the matrix has no inverse.

    Solved by Cholesky's method in plain floats: 13 us for six joints, where numpy takes 8 us, and
    its import 0.1 s.

    Args:
        columns: Columns of J.
        target: Vector with as many numbers as J has rows.
        damping: At least 0; above 0 the matrix has an inverse.
    """
    factor: list[list[float]] = []  # rows of the lower triangular L with L L^T = J^T J + damping I
    solution: list[float] = []
    for i, column in enumerate(columns):
        row: list[float] = []
        for j in range(i):
            other = factor[j]
            value = sum(map(mul, column, columns[j])) - sum(map(mul, row, other))
            row.append(value / other[j])
        square = sum(map(mul, column, column)) + damping - sum(map(mul, row, row))
        if not square > 0.0:
            return None
        pivot = math.sqrt(square)
        # Forward substitution, L y = J^T target.
        value = sum(map(mul, column, target)) - sum(map(mul, row, solution))
        solution.append(value / pivot)
        row.append(pivot)
        factor.append(row)
    # Backward substitution, L^T x = y.
    for i in range(len(solution) - 1, -1, -1):
        row = factor[i]
        solution[i] = value = solution[i] / row[i]
        for j in range(i):
            solution[j] -= row[j] * value
    return solution
