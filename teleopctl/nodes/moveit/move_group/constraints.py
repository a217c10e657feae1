"""Constraints of a motion request, and how far a state violates them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.commander import read_pose
from teleopctl.errors import NotFoundError, UsageError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import (
    GroupKinematics,
    KinematicModel,
    MoveItErrorCode,
    PathConstraint,
    PlanningError,
    rotation_vector,
)

if TYPE_CHECKING:
    from teleopctl.nodes.moveit.move_group.context import MoveGroupContext

# Any, here and below: message classes are generated at run time from definitions.
_BOX, _SPHERE, _CYLINDER = 1, 2, 3
_ROTATION_VECTOR = 1
# Rounding of a position or an angle that is no violation, m or rad.
_ROUNDING = 1e-6
# Part of a tolerance to which states are moved, so that those between two of them meet it too.
_WITHIN = 0.6
# Tolerance from which a turn is free: half a turn is written as 3.14 or 3.14159, rad.
_ANY_RAD = 3.14


@dataclass(frozen=True)
class Region:
    """Region in which a point of a link must lie: spheres, boxes, cylinders, meshes as boxes.

    Attributes:
        link: Link or frame.
        offset: The point in its frame, (3,), m.
        parts: Pose in the root link's frame, (4, 4), and half lengths along x, y, z, (3,), of each
            part; the half lengths are equal for a sphere.
        kinds: Kind of each part: box 1, sphere 2, cylinder 3.
    """

    link: str
    offset: np.ndarray
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]
    kinds: tuple[int, ...]

    @property
    def centre(self) -> np.ndarray:
        """Centre of the first part, (3,), m."""
        return np.asarray(self.parts[0][0][:3, 3])

    @property
    def tolerance_m(self) -> float:
        """Radius of the largest sphere around the centre that lies within the first part, m."""
        return float(self.parts[0][1].min())

    def beyond_m(self, point: np.ndarray) -> np.ndarray:
        """Return the way of a point, (3,), from the nearest part, a little smaller, (3,), m."""
        ways = [
            _way(kind, pose, _WITHIN * half, point)
            for kind, (pose, half) in zip(self.kinds, self.parts, strict=True)
        ]
        return min(ways, key=lambda way: float(np.linalg.norm(way)))

    def distance_m(self, point: np.ndarray) -> float:
        """Return the distance of a point, (3,), from the region, m; 0 within."""
        return min(
            _outside(kind, pose, half, point)
            for kind, (pose, half) in zip(self.kinds, self.parts, strict=True)
        )


@dataclass(frozen=True)
class Orientation:
    """Orientation constraint of a link.

    Attributes:
        link: Link or frame.
        rotation: Rotation in the root link's frame, (3, 3).
        tolerances: Largest angles about the axes x, y, z, (3,), rad.
        is_vector: Whether these are components of the rotation vector, and not Euler angles.
    """

    link: str
    rotation: np.ndarray
    tolerances: np.ndarray
    is_vector: bool

    def excess_rad(self, rotation: np.ndarray) -> float:
        """Return by how much a rotation, (3, 3), exceeds the tolerances, rad; 0 within."""
        return float(np.max(np.abs(self._angles(rotation)) - self.tolerances, initial=0.0))

    def beyond_rad(self, rotation: np.ndarray) -> np.ndarray:
        """Return by how much a rotation is beyond a part of each tolerance, signed, (3,), rad."""
        angles, most = self._angles(rotation), _WITHIN * np.minimum(self.tolerances, 2.0 * np.pi)
        # A turn without a limit has none here either.
        most = np.where(self.tolerances >= np.pi, np.inf, most)
        return np.asarray(angles - np.clip(angles, -most, most))

    def _angles(self, rotation: np.ndarray) -> np.ndarray:
        error = self.rotation.T @ rotation
        return rotation_vector(error) if self.is_vector else _euler(error)


class _Condition:
    """A `ConstraintSet` as a `PathConstraint`."""

    def __init__(self, constraints: ConstraintSet) -> None:
        self._constraints = constraints

    def __call__(self, positions: np.ndarray) -> bool:
        return self._constraints.is_met(positions)

    def residual(self, positions: np.ndarray) -> np.ndarray:
        return self._constraints.residual(positions)


class ConstraintSet:
    """Constraints on positions of joints, and on position and orientation of links.

    Args:
        context: Robot, state and scene, for frames.
        message: A ``moveit_msgs/msg/Constraints``.
        kinematics: Kinematics of the group whose positions are checked; None to check the model
            as it is.
        model: The model, if there are no kinematics.

    Raises:
        PlanningError: A constraint cannot be understood.
    """

    def __init__(
        self,
        context: MoveGroupContext,
        message: Any,
        kinematics: GroupKinematics | None,
        model: KinematicModel | None = None,
    ) -> None:
        self._context = context
        self._kinematics = kinematics
        self._model = kinematics.model if kinematics is not None else model
        if message.visibility_constraints:
            raise PlanningError(
                "Visibility constraints are not supported", MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
            )
        self.joints = {one.joint_name: _joint_range(one) for one in message.joint_constraints}
        self.regions = [_region(context, one) for one in message.position_constraints]
        self.orientations = [_orientation(context, one) for one in message.orientation_constraints]
        self.weights = [
            float(one.weight)
            for kind in ("joint", "position", "orientation")
            for one in getattr(message, f"{kind}_constraints")
        ]

    def __bool__(self) -> bool:
        return bool(self.joints or self.regions or self.orientations)

    def narrow(self, kinematics: GroupKinematics) -> None:
        """Narrow the limits of a group's joints to the ranges of the joint constraints."""
        for place, name in enumerate(kinematics.names):
            if name not in self.joints or kinematics.limits[place].angle_wraparound:
                continue
            target, below, above = self.joints[name]
            lower = max(float(kinematics.lower[place]), target - below)
            upper = min(float(kinematics.upper[place]), target + above)
            if lower <= upper:
                kinematics.lower[place], kinematics.upper[place] = lower, upper

    def violation(self, positions: np.ndarray) -> str:
        """Return the first violation at positions of the group, (n,), in words; empty if none."""
        assert self._kinematics is not None
        self._kinematics.set(positions)
        return self.unmet()

    def unmet(self) -> str:
        """Return the first constraint that the model does not meet, in words; empty if it does."""
        return next((text for distance, text in self._check() if distance > _ROUNDING), "")

    def condition(self) -> PathConstraint | None:
        """Return the constraints as a condition on positions; None if there are none."""
        return _Condition(self) if self else None

    def is_met(self, positions: np.ndarray) -> bool:
        """Return whether positions of the group, (n,), meet the constraints."""
        assert self._kinematics is not None
        self._kinematics.set(positions)
        return all(distance <= _ROUNDING for distance, _ in self._check())

    def residual(self, positions: np.ndarray) -> np.ndarray:
        """Return by how much positions of the group are beyond a part of the tolerances, signed.

        Parts of the vector are joints (rad or m), regions (m, along x, y, z) and orientations (rad,
        about three axes). What is within that part of the tolerances is 0.

        Args:
            positions: The positions, (n,).
        """
        assert self._kinematics is not None
        self._kinematics.set(positions)
        model = self._kinematics.model
        parts = []
        for name, (target, below, above) in self.joints.items():
            away = model.joints[name].limits.offset(self._joint(model, name), target)
            parts.append(np.array([away - np.clip(away, -_WITHIN * below, _WITHIN * above)]))
        for region in self.regions:
            pose = self._pose(model, region.link)
            parts.append(region.beyond_m(pose[:3, 3] + pose[:3, :3] @ region.offset))
        parts += [one.beyond_rad(self._pose(model, one.link)[:3, :3]) for one in self.orientations]
        return np.concatenate(parts)

    def results(self) -> list[Any]:
        """Return the result of each constraint as ``moveit_msgs/msg/ConstraintEvalResult``."""
        result: Any = get_message("moveit_msgs/msg/ConstraintEvalResult")
        return [
            result(result=distance <= _ROUNDING, distance=float(distance))
            for distance, _ in self._check()
        ]

    def _check(self) -> Iterator[tuple[float, str]]:
        model = self._model
        assert model is not None
        for name, (target, below, above) in self.joints.items():
            at = self._joint(model, name)
            away = model.joints[name].limits.offset(at, target)
            yield max(away - above, -away - below, 0.0), f"joint '{name}' is at {at:.4g}"
        for region in self.regions:
            pose = self._pose(model, region.link)
            point = pose[:3, 3] + pose[:3, :3] @ region.offset
            distance = region.distance_m(point)
            yield distance, f"'{region.link}' is {distance:.4g} m outside its region"
        for orientation in self.orientations:
            excess = orientation.excess_rad(self._pose(model, orientation.link)[:3, :3])
            yield excess, f"'{orientation.link}' is turned {excess:.4g} rad too far"

    def _joint(self, model: KinematicModel, name: str) -> float:
        try:
            return float(model.mj_data.qpos[model.address(name)])
        except NotFoundError as error:
            raise PlanningError(error.message, MoveItErrorCode.INVALID_GOAL_CONSTRAINTS) from error

    def _pose(self, model: KinematicModel, link: str) -> np.ndarray:
        if link in model.links:
            return model.pose(link)
        fixed = self._context.scene.fixed_to(link)
        if fixed is None:
            raise PlanningError(
                f"A constraint is about '{link}', which is no link of the robot",
                MoveItErrorCode.INVALID_LINK_NAME,
            )
        return np.asarray(model.pose(fixed[0]) @ fixed[1])


def _joint_range(message: Any) -> tuple[float, float, float]:
    """Return the position of a joint constraint, and the tolerances below and above it."""
    values = (message.position, message.tolerance_below, message.tolerance_above)
    if not all(map(math.isfinite, values)):
        raise PlanningError(
            f"The constraint of joint '{message.joint_name}' has a value that is not finite",
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
        )
    return (float(message.position), abs(float(values[1])), abs(float(values[2])))


def _region(context: MoveGroupContext, message: Any) -> Region:
    at = context.frame(message.header.frame_id)
    offset = message.target_point_offset
    volume = message.constraint_region
    parts, kinds = [], []
    for number, primitive in enumerate(volume.primitives):
        pose = _part_pose(volume.primitive_poses, number, message.link_name)
        kind, size = int(primitive.type), [float(value) for value in primitive.dimensions]
        if kind == _SPHERE and size:
            half = np.full(3, size[0])
        elif kind == _BOX and len(size) >= 3:
            half = 0.5 * np.array(size[:3])
        elif kind == _CYLINDER and len(size) >= 2:
            half = np.array((size[1], size[1], 0.5 * size[0]))
        else:
            raise PlanningError(
                f"The region of '{message.link_name}' is no box, sphere or cylinder with its "
                "dimensions",
                MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            )
        if not (np.isfinite(half).all() and (half >= 0.0).all()):
            raise PlanningError(
                f"The region of '{message.link_name}' has the dimensions {size}",
                MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            )
        parts.append((np.asarray(at @ pose), half))
        kinds.append(kind)
    for number, mesh in enumerate(volume.meshes):
        pose = _part_pose(volume.mesh_poses, number, message.link_name)
        points = np.array([(v.x, v.y, v.z) for v in mesh.vertices], np.float64).reshape(-1, 3)
        if not len(points) or not np.isfinite(points).all():
            raise PlanningError(
                f"The region of '{message.link_name}' is a mesh without vertices",
                MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            )
        centred = np.eye(4)
        centred[:3, 3] = 0.5 * (points.min(axis=0) + points.max(axis=0))
        parts.append((np.asarray(at @ pose @ centred), 0.5 * np.ptp(points, axis=0)))
        kinds.append(_BOX)
    if not parts:
        raise PlanningError(
            f"The position constraint of '{message.link_name}' has no region",
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
        )
    place = np.array((offset.x, offset.y, offset.z), np.float64)
    return Region(message.link_name, place, tuple(parts), tuple(kinds))


def _part_pose(poses: Any, number: int, link: str) -> np.ndarray:
    if number >= len(poses):
        return np.eye(4)
    try:
        return read_pose(poses[number], f"The region of '{link}'")
    except UsageError as error:
        raise PlanningError(error.message, MoveItErrorCode.INVALID_GOAL_CONSTRAINTS) from error


def _orientation(context: MoveGroupContext, message: Any) -> Orientation:
    pose: Any = get_message("geometry_msgs/msg/Pose")()
    pose.orientation = message.orientation
    try:
        own = read_pose(pose, f"The orientation of '{message.link_name}'")
    except UsageError as error:
        raise PlanningError(error.message, MoveItErrorCode.INVALID_GOAL_CONSTRAINTS) from error
    tolerances = np.abs(
        (
            message.absolute_x_axis_tolerance,
            message.absolute_y_axis_tolerance,
            message.absolute_z_axis_tolerance,
        )
    )
    if np.isnan(tolerances).any():
        raise PlanningError(
            f"The orientation of '{message.link_name}' has a tolerance that is no number",
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
        )
    at = context.frame(message.header.frame_id)
    return Orientation(
        message.link_name,
        np.asarray(at[:3, :3] @ own[:3, :3]),
        np.where(tolerances >= _ANY_RAD, np.pi, tolerances),
        int(message.parameterization) == _ROTATION_VECTOR,
    )


def _outside(kind: int, pose: np.ndarray, half: np.ndarray, point: np.ndarray) -> float:
    own = np.abs(pose[:3, :3].T @ (point - pose[:3, 3]))
    if kind == _SPHERE:
        return max(float(np.linalg.norm(own)) - float(half[0]), 0.0)
    if kind == _CYLINDER:
        over = (math.hypot(own[0], own[1]) - half[0], own[2] - half[2])
    else:
        over = tuple(own - half)
    return float(np.linalg.norm(np.maximum(over, 0.0)))


def _way(kind: int, pose: np.ndarray, half: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the way to a point from the nearest one of a part, in the root's axes, (3,), m."""
    own = pose[:3, :3].T @ (point - pose[:3, 3])
    if kind == _SPHERE:
        nearest = own * min(1.0, float(half[0]) / max(float(np.linalg.norm(own)), 1e-12))
    else:
        nearest = np.clip(own, -half, half)
        if kind == _CYLINDER:
            radius = max(math.hypot(own[0], own[1]), 1e-12)
            nearest[:2] = own[:2] * min(1.0, float(half[0]) / radius)
    return np.asarray(pose[:3, :3] @ (own - nearest))


def _euler(rotation: np.ndarray) -> np.ndarray:
    """Return the intrinsic angles about x, y, z of a rotation, (3,), rad."""
    y = math.asin(max(-1.0, min(1.0, float(rotation[0, 2]))))
    if abs(rotation[0, 2]) > 1.0 - 1e-9:
        return np.array((math.atan2(rotation[1, 0], rotation[1, 1]), y, 0.0))
    x = math.atan2(-rotation[1, 2], rotation[2, 2])
    return np.array((x, y, math.atan2(-rotation[0, 1], rotation[0, 0])))
