"""A robot's MuJoCo model as kinematics uses it: links, joint positions, poses, no dynamics."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError, NotFoundError
from teleopctl.kinematics.compiled import build_compiled, compiled_model
from teleopctl.kinematics.poses import Array
from teleopctl.robot import Joints, RobotDescription

if TYPE_CHECKING:
    from teleopctl.robot import World


class KinematicModel:
    """MuJoCo model of a robot whose root link is fixed at the origin, with a state of its own.

    Poses are expressed in the frame of the root link, as MoveIt's planning frame is.

    Args:
        description: The robot.
        world: World in which the robot stands; None for free space, without ground.

    Attributes:
        description: The robot.
        joints: Its joints, with limits and mimic relations.
        mj_model: The compiled ``mujoco.MjModel``.
        mj_data: Its ``mujoco.MjData``.
        links: MuJoCo's number of the body of each link.
        warnings: What was repaired or left out in the description, one sentence each.
        touching: Pairs of links that touch at nearly all joint positions, for example as the hulls
            of their meshes, so that this says nothing; in alphabetical order.
        R_root_world: Rotation of MuJoCo's world frame in the root link's frame, (3, 3).
        is_turned: Whether that rotation is not the identity.

    Raises:
        InvalidDescriptionError: MuJoCo cannot build the robot.
    """

    def __init__(self, description: RobotDescription, world: World | None = None) -> None:
        self.description = description
        self.joints = Joints.of(description)
        self._world = world
        compiled = compiled_model(description, self.joints, world)
        self.warnings, self.touching = compiled.warnings, compiled.touching
        # Any: MuJoCo's classes have no types.
        self._spec: Any = compiled.spec
        self._use(compiled.mj_model)
        self.mj_data.qpos[:] = compiled.start
        self._update()
        root = self.links[description.root]
        self.R_root_world = np.array(self.mj_data.xmat[root]).reshape(3, 3).T
        self._p_world_root = np.array(self.mj_data.xpos[root])
        self.is_turned = not np.allclose(self.R_root_world, np.eye(3), atol=1e-12)

    # Any: MuJoCo's spec has no types.
    def with_changes(self, change: Callable[[Any], None]) -> KinematicModel:
        """Return a model of the robot, compiled with changes of the spec, in the present state.

        The new model shares nothing that moves with this one, so that another thread may use it.
        The first change of a model that was loaded from the cache builds it from its files.

        Args:
            change: Function called with a copy of this model's ``mujoco.MjSpec``, to add geoms and
                bodies without joints. It must not remove or move any link.

        Raises:
            InvalidDescriptionError: MuJoCo cannot compile what was added.
        """
        if self._spec is None:
            self._spec = build_compiled(self.description, self.joints, self._world).spec
        spec = self._spec.copy()
        change(spec)
        other = copy.copy(self)
        try:
            with catch_warnings():
                # MuJoCo passes these warnings to `mujoco.set_mju_user_warning` too.
                simplefilter("ignore", UserWarning)
                other._use(spec.compile())  # noqa: SLF001 - of this class
        except ValueError as error:
            raise InvalidDescriptionError(" ".join(str(error).split())) from error
        other.mj_data.qpos[:] = self.mj_data.qpos
        other._update()  # noqa: SLF001 - of this class
        return other

    def address(self, joint: str) -> int:
        """Return the index of a joint's position in MuJoCo's ``qpos``.

        Raises:
            NotFoundError: The robot has no such joint with one axis.
        """
        try:
            return self._addresses[joint]
        except KeyError:
            raise NotFoundError(
                f"The robot has no joint '{joint}' that moves along or about one axis",
                hint=f"It has: {', '.join(self._addresses) or 'none'}",
            ) from None

    def body(self, link: str) -> int:
        """Return MuJoCo's number of the body of a link.

        Raises:
            NotFoundError: The robot has no such link.
        """
        try:
            return self.links[link]
        except KeyError:
            raise NotFoundError(
                f"The robot has no link '{link}'", hint=f"It has: {', '.join(self.links)}"
            ) from None

    def positions(self) -> dict[str, float]:
        """Return the present positions of all joints with one axis, rad or m, by name."""
        return {name: float(self.mj_data.qpos[at]) for name, at in self._addresses.items()}

    def set_positions(self, positions: Mapping[str, float]) -> None:
        """Move joints; mimic joints without a position of their own follow. Others stay.

        Args:
            positions: Positions by joint, rad or m; names that the robot has not are ignored.
        """
        independent = {n: p for n, p in positions.items() if n in self._addresses}
        for name, position in self.joints.positions(independent).items():
            if name in self._addresses:
                self.mj_data.qpos[self._addresses[name]] = position
        self._update()

    def pose(self, link: str) -> Array:
        """Return the present pose of a link in the root link's frame, (4, 4).

        Raises:
            NotFoundError: The robot has no such link.
        """
        body = self.body(link)
        pose = np.eye(4)
        pose[:3, :3] = self.R_root_world @ self.mj_data.xmat[body].reshape(3, 3)
        pose[:3, 3] = self.R_root_world @ (self.mj_data.xpos[body] - self._p_world_root)
        return pose

    def to_world(self, pose: Array) -> Array:
        """Return a pose in the root link's frame, (4, 4), as a pose in MuJoCo's world frame."""
        moved = np.eye(4)
        moved[:3, :3] = self.R_root_world.T @ pose[:3, :3]
        moved[:3, 3] = self.R_root_world.T @ pose[:3, 3] + self._p_world_root
        return moved

    def to_root(self, point: Array) -> Array:
        """Return a point in MuJoCo's world frame, (3,), in the root link's frame."""
        return np.asarray(self.R_root_world @ (point - self._p_world_root))

    def joint_origin(self, joint: str) -> Array:
        """Return the origin of a joint's axis, (3,), in the root link's frame, m."""
        return self.to_root(self.mj_data.xanchor[self.mj_model.joint(joint).id])

    def twist_to_world(self, twist: Array) -> Array:
        """Return a twist in the axes of the root link, (6,), in those of MuJoCo's world frame."""
        if not self.is_turned:
            return twist
        turn = self.R_root_world.T
        return np.concatenate((turn @ twist[:3], turn @ twist[3:]))

    def _use(self, mj_model: Any) -> None:
        self.mj_model: Any = mj_model
        self.mj_data: Any = mujoco.MjData(mj_model)
        numbers = {mj_model.body(n).name: n for n in range(mj_model.nbody)}
        links = self.description.links
        self.links = {link: numbers[link] for link in links if link in numbers}
        self._addresses = {
            name: int(mj_model.joint(name).qposadr[0])
            for name in self.joints
            if mujoco.mj_name2id(mj_model, mujoco.mjtObj.mjOBJ_JOINT, name) >= 0
        }

    def _update(self) -> None:
        mujoco.mj_kinematics(self.mj_model, self.mj_data)
        mujoco.mj_comPos(self.mj_model, self.mj_data)
