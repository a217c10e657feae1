"""Forward kinematics and Jacobian of a joint group's tip, for vectors of joint positions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import mujoco
import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.groups import JointGroup
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array, invert_pose, pose_matrix
from teleopctl.robot import JointLimits

# Number of random positions by which the degrees of freedom of a tip are counted, and the part of
# the largest singular value from which one counts.
_SAMPLES = 32
_LEAST_SINGULAR = 1e-4
# Range (rad or m) that is sampled of a joint without limits.
_HALF_TURN = np.pi


class GroupKinematics:
    """Kinematics of the tip of a group, as functions of its independent joints.

    Mimic joints are no variables: they follow their leaders, with the part of the Jacobian that is
    due to them. `set` moves the model; what the other methods return is about the model as it is.

    Args:
        model: Model of the robot, which the group moves.
        group: The group.
        T_tip_tool: Pose of the tool in the frame of the tip, (4, 4); None for the group's own
            tool, or else the tip.

    Attributes:
        model: Model of the robot.
        group: The group.
        names: Names of the independent joints, from the root to the tip; n of them.
        limits: Limits of these joints.
        lower: Smallest positions, (n,), rad or m; minus infinity without a limit.
        upper: Largest positions, (n,), rad or m; infinity without a limit.
        T_tip_tool: Pose of the tool in the frame of the tip, (4, 4).
        has_tool: Whether the tool is another frame than the tip.

    Raises:
        UsageError: The group has no tip, or no independent joint.
    """

    def __init__(
        self,
        model: KinematicModel,
        group: JointGroup,
        T_tip_tool: Array | None = None,
    ) -> None:
        if not group.tip:
            raise UsageError(
                f"The group '{group.name}' moves no single tip, so that it has no pose"
            )
        joints = model.joints
        names = tuple(name for name in group.joints if joints[name].mimic is None)
        if not names:
            raise UsageError(f"The group '{group.name}' has no joint that moves by itself")
        self.model, self.group, self.names = model, group, names
        self.limits: tuple[JointLimits, ...] = tuple(joints[name].limits for name in names)
        self.lower = np.array([limit.lower for limit in self.limits])
        self.upper = np.array([limit.upper for limit in self.limits])
        self._mj_model, self._mj_data = model.mj_model, model.mj_data
        self._body = model.body(group.tip)
        places = {name: place for place, name in enumerate(names)}
        self._addresses = np.array([model.address(name) for name in names])
        followers = [
            (model.address(name), places[leader], multiplier, offset)
            for name, leader, multiplier, offset in joints.followers(set(names))
            if leader
        ]
        self._followers = np.array([at for at, *_ in followers], dtype=np.intp)
        self._leaders = np.array([place for _, place, *_ in followers], dtype=np.intp)
        self._factors = np.array([factor for *_, factor, _ in followers])
        self._offsets = np.array([offset for *_, offset in followers])
        # Velocities of MuJoCo's degrees of freedom from those of the independent joints.
        dofs = self._mj_model.jnt_dofadr
        by_address = {int(a): int(dofs[n]) for n, a in enumerate(self._mj_model.jnt_qposadr)}
        self._columns = [by_address[int(at)] for at in self._addresses]
        self._spread: Array | None = None
        if followers:
            spread = np.zeros((self._mj_model.nv, len(names)))
            spread[self._columns, range(len(names))] = 1.0
            for at, place, factor, _ in followers:
                spread[by_address[at], place] = factor
            self._spread = spread
        self._full = np.zeros((6, self._mj_model.nv))
        self._linear, self._angular = self._full[:3], self._full[3:]
        self.set_tool(T_tip_tool)

    def set_tool(self, T_tip_tool: Array | None) -> None:
        """Set the pose of the tool in the frame of the tip, (4, 4); None for the group's own."""
        if T_tip_tool is None and self.group.tool is not None:
            T_tip_tool = pose_matrix(self.group.tool)
        self.T_tip_tool = np.eye(4) if T_tip_tool is None else np.asarray(T_tip_tool, np.float64)
        self.has_tool = T_tip_tool is not None
        self.__dict__.pop("_sampled", None)

    def set(self, positions: Array) -> None:
        """Move the model's joints of this group, with their mimic joints.

        Args:
            positions: Positions of the independent joints, (n,), rad or m.
        """
        data = self._mj_data
        data.qpos[self._addresses] = positions
        if len(self._followers):
            data.qpos[self._followers] = self._factors * positions[self._leaders] + self._offsets
        mujoco.mj_kinematics(self._mj_model, data)
        mujoco.mj_comPos(self._mj_model, data)

    def spread(self) -> Array:
        """Return the velocities of MuJoCo's degrees of freedom at 1 of each joint, (nv, n)."""
        if self._spread is not None:
            return self._spread
        spread = np.zeros((self._mj_model.nv, len(self.names)))
        spread[self._columns, range(len(self.names))] = 1.0
        return spread

    def columns(self) -> Iterator[tuple[int, tuple[int, float]]]:
        """Yield MuJoCo's number of each joint that the group moves, its variable and its factor.

        The variable is the place of an independent joint; the factor is how far the joint moves,
        rad or m, at 1 rad or 1 m of that, without its sign: 1 unless it is a mimic joint.
        """
        by_address = {int(at): joint for joint, at in enumerate(self._mj_model.jnt_qposadr)}
        for place, at in enumerate(self._addresses):
            yield by_address[int(at)], (place, 1.0)
        followers = zip(self._followers, self._leaders, self._factors, strict=True)
        for at, place, factor in followers:
            yield by_address[int(at)], (int(place), abs(float(factor)))

    def present(self) -> Array:
        """Return the model's positions of the independent joints, (n,), rad or m."""
        return np.array(self._mj_data.qpos[self._addresses])

    def vector(self, positions: Mapping[str, float]) -> Array:
        """Return positions by joint as a vector, (n,); joints without one stay where they are."""
        vector = self.present()
        for place, name in enumerate(self.names):
            if name in positions:
                vector[place] = positions[name]
        return vector

    def by_name(self, positions: Sequence[float] | Array) -> dict[str, float]:
        """Return a vector of positions as positions by joint."""
        return {name: float(at) for name, at in zip(self.names, positions, strict=True)}

    def clamp(self, positions: Array) -> Array:
        """Return positions, (n,), moved into the joints' limits."""
        return np.clip(positions, self.lower, self.upper)

    def world_pose(self) -> tuple[Array, Array]:
        """Return origin, (3,), and rotation, (3, 3), of the tool in MuJoCo's world frame."""
        data = self._mj_data
        rotation = data.xmat[self._body].reshape(3, 3)
        if not self.has_tool:
            return data.xpos[self._body], rotation
        tool = self.T_tip_tool
        return data.xpos[self._body] + rotation @ tool[:3, 3], rotation @ tool[:3, :3]

    def pose(self) -> Array:
        """Return the pose of the tool in the root link's frame, (4, 4)."""
        return np.asarray(self.model.pose(self.group.tip) @ self.T_tip_tool)

    def tip_pose(self, T_root_tool: Array) -> Array:
        """Return the pose of the tip, (4, 4), at which the tool has a pose, (4, 4)."""
        return np.asarray(T_root_tool @ invert_pose(self.T_tip_tool))

    def world_jacobian(self) -> Array:
        """Return the geometric Jacobian of the tool's origin, (6, n), in axes of the world frame.

        Rows are linear velocity (m/s), then angular velocity (rad/s), at 1 rad/s or 1 m/s of each
        independent joint.
        """
        if self.has_tool:
            origin, _ = self.world_pose()
            mujoco.mj_jac(
                self._mj_model, self._mj_data, self._linear, self._angular, origin, self._body
            )
        else:
            mujoco.mj_jacBody(
                self._mj_model, self._mj_data, self._linear, self._angular, self._body
            )
        if self._spread is None:
            return self._full[:, self._columns]
        return np.asarray(self._full @ self._spread)

    def jacobian(self) -> Array:
        """Return the geometric Jacobian of the tool's origin, (6, n), in axes of the root link.

        Rows are linear velocity (m/s), then angular velocity (rad/s), at 1 rad/s or 1 m/s of each
        independent joint.
        """
        world = np.array(self.world_jacobian())
        turn = self.model.R_root_world
        return np.vstack((turn @ world[:3], turn @ world[3:]))

    def point_jacobian(self, point: Array, body: int) -> Array:
        """Return the linear Jacobian, (3, n), of a point of a body, in the world frame.

        Args:
            point: The point, (3,), in MuJoCo's world frame, m.
            body: MuJoCo's number of the body.
        """
        jacobian = np.zeros((3, self._mj_model.nv))
        mujoco.mj_jac(self._mj_model, self._mj_data, jacobian, None, point, body)
        if self._spread is None:
            return jacobian[:, self._columns]
        return np.asarray(jacobian @ self._spread)

    def random(self, generator: np.random.Generator) -> Array:
        """Return random positions within the limits, (n,); half a turn for joints without any."""
        lower = np.where(np.isfinite(self.lower), self.lower, -_HALF_TURN)
        upper = np.where(np.isfinite(self.upper), self.upper, _HALF_TURN)
        # A joint with one limit, which may lie beyond half a turn.
        lower, upper = np.minimum(lower, upper - 1e-9), np.maximum(upper, lower + 1e-9)
        return generator.uniform(lower, upper)

    @property
    def dimensions(self) -> tuple[int, int]:
        """Degrees of freedom of the tool, and of its origin alone: at most 6 and 3.

        These are the largest ranks of the Jacobian, and of its linear rows, at random positions.
        """
        whole, linear, _ = self._sampled
        return whole, linear

    @property
    def reach_m(self) -> float:
        """Largest distance of the tool's origin from the axis of a joint, m, at random positions.

        The arm's size, by which lengths compare with angles.
        """
        return self._sampled[2]

    @cached_property
    def _sampled(self) -> tuple[int, int, float]:
        before, generator = self.present(), np.random.default_rng(0)
        jacobians = []
        for _ in range(_SAMPLES):
            self.set(self.random(generator))
            jacobians.append(np.array(self.world_jacobian()))
        self.set(before)
        reach = float(max(np.linalg.norm(one[:3], axis=0).max() for one in jacobians)) or 1.0
        scaled = [np.vstack((one[:3] / reach, one[3:])) for one in jacobians]
        whole, linear = max(map(_rank, scaled)), max(_rank(one[:3]) for one in scaled)
        return whole, linear, reach


def _rank(matrix: Array) -> int:
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > _LEAST_SINGULAR * max(float(values[0]), 1e-12)).sum())
