"""Arm of a robot: forward and inverse kinematics, plans and servo of one group."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from teleopctl.errors import NotFoundError, UsageError
from teleopctl.kinematics.clearance import ClearanceChecker
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.groups import JointGroup, RobotGroups, find_groups, with_tip
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array
from teleopctl.packages import resolve_uri
from teleopctl.robot import RobotDescription
from teleopctl.tf import matrix_from_quaternion, quaternion_from_rpy

if TYPE_CHECKING:
    from teleopctl.kinematics.motion.plan import MotionPlan, MotionSettings
    from teleopctl.kinematics.servo.core import ServoCore
    from teleopctl.kinematics.servo.status import ServoStep
    from teleopctl.kinematics.solver import IkSolution, PoseTask
    from teleopctl.kinematics.workspace import Workspace
    from teleopctl.robot import World


class HasUrdf(Protocol):
    """Object with a robot's description as text, such as `teleopctl.Robot`."""

    @property
    def urdf(self) -> str:
        """The description as URDF text."""
        ...


Positions = Mapping[str, float] | Sequence[float] | Array
"""Positions of joints (rad or m): by name, or one for each independent joint of the group."""
# A pose is (4, 4), a position (3,).
_POSE, _POSITION = (4, 4), (3,)


class Arm:
    """A group of a robot's joints that moves a tool: kinematics, plans and servo.

    Positions are those of the group's independent joints, from the root to the tip, as a sequence
    or by name; joints that are not named are where `positions` has them. Poses are (4, 4) matrices
    of the tool in the root link's frame. Collisions of links, and with the world, are avoided.

    Args:
        robot: Path or ``package://`` URI of a URDF, xacro, SDF or MJCF file, URDF text, or an
            object with the text, such as a `Robot`.
        group: Name of the group; by default the first one that moves a tip.
        tool: Tool that poses are about: a link that the group moves, or the tool's pose in the
            frame of the group's tip as x, y, z (m), as x, y, z, roll, pitch, yaw (rad), or (4, 4).
            By default the tool of the SRDF, or the tip.
        srdf: SRDF file with groups and named states, or what was read of one; by default they are
            found in the description.
        world: World whose bodies are obstacles: an SDF, YAML, URDF or MJCF file.

    Attributes:
        names: Names of the independent joints; n of them.
        lower: Smallest positions, (n,), rad or m.
        upper: Largest positions, (n,), rad or m.
        states: Positions by joint of each named state.
        warnings: What was repaired, or is wrong, in the files, one sentence each.

    Raises:
        InvalidDescriptionError: A file cannot be read, or is no robot.
        InvalidFileError: The SRDF cannot be read, or is that of another robot.
        NotFoundError: There is no such file, group, or link.
        UsageError: The tool is no pose, or the group has no tip.

    Example:
        >>> from teleopctl import Arm
        >>> arm = Arm("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> arm.names
        ('joint_1', 'joint_2', 'joint_3')
        >>> T_root_tool = arm.fk([0.5, 0.2, -0.3])
        >>> found = arm.ik(T_root_tool)
        >>> found.is_reached
        True
        >>> bool(abs(arm.fk(found.positions)[:3, 3] - T_root_tool[:3, 3]).max() < 1e-4)
        True
    """

    def __init__(
        self,
        robot: str | Path | RobotDescription | HasUrdf,
        group: str = "",
        tool: str | Sequence[float] | Array | None = None,
        srdf: str | Path | RobotGroups | None = None,
        *,
        world: str | Path | World | None = None,
    ) -> None:
        description = _description(robot)
        if isinstance(world, str | Path):
            from teleopctl.robot import read_world

            world = read_world(resolve_uri(str(world)))
        if isinstance(srdf, RobotGroups):
            groups = srdf
        elif srdf is not None:
            from teleopctl.kinematics.srdf import read_srdf

            groups = read_srdf(Path(srdf), description)
        else:
            groups = find_groups(description)
        own, offset = _with_tool(groups.group(group), tool, description)
        self.groups, self.group = groups, own
        self.model = KinematicModel(description, world)
        self.kinematics = GroupKinematics(self.model, own, offset)
        self.names = self.kinematics.names
        self.lower, self.upper = self.kinematics.lower, self.kinematics.upper
        self.states = groups.states.get(own.name, {})
        self.warnings = (*self.model.warnings, *groups.warnings)
        self._positions = self.kinematics.present()

    @property
    def positions(self) -> Array:
        """Present positions of the joints, (n,): start of searches and plans, state of servo."""
        return self._positions.copy()

    @positions.setter
    def positions(self, positions: Positions) -> None:
        self._positions = self._vector(positions)
        if "_servo" in self.__dict__:
            self._servo.reset(self._positions)

    @property
    def tool_name(self) -> str:
        """Name of the tool in messages: the tip, or the tip with its tool."""
        tip = self.group.tip
        return f"{tip} with its tool" if self.kinematics.has_tool else tip

    def fk(self, positions: Positions | str | None = None) -> Array:
        """Return the pose of the tool, (4, 4).

        Args:
            positions: Positions of the joints, or the name of a state; by default `positions`.

        Raises:
            NotFoundError: The group has no such joint or state.
            UsageError: There is another number of positions, or one is not finite.
        """
        self.kinematics.set(self._vector(positions))
        return self.kinematics.pose()

    def jacobian(self, positions: Positions | str | None = None) -> Array:
        """Return the Jacobian of the tool's origin, (6, n), in the axes of the root link.

        Rows are linear (m/s), then angular velocity (rad/s), at 1 rad/s or 1 m/s of each joint.

        Args:
            positions: As for `fk`.
        """
        self.kinematics.set(self._vector(positions))
        return self.kinematics.jacobian()

    def collisions(self, positions: Positions | str | None = None) -> list[tuple[str, str]]:
        """Return the pairs of bodies in collision, the deepest overlap first.

        Args:
            positions: As for `fk`.
        """
        self.kinematics.set(self._vector(positions))
        return [one.bodies for one in self.clearance.collisions()]

    def ik(
        self,
        pose: Sequence[float] | Array,
        start: Positions | None = None,
        *,
        collisions: bool = False,
    ) -> IkSolution:
        """Return positions at which the tool has a pose, or the nearest that were found.

        Args:
            pose: Pose of the tool, (4, 4), or its position alone, (3,), m. Of a pose, what the
                joints allow is reached: see `IkSolution`.
            start: Positions from which the search begins; by default `positions`.
            collisions: Whether bodies may touch.

        Raises:
            UsageError: The pose is none, or has values that are not finite.
        """
        from teleopctl.kinematics.solver import IkSolver

        begin = self._vector(start)
        target, is_position = self._target(pose, begin)
        solver = IkSolver(
            self.kinematics,
            task=_position_task(is_position),
            clearance=None if collisions else self.clearance,
        )
        return solver.solve(target, begin)

    def workspace(self, samples: int = 10_000, *, collisions: bool = False) -> Workspace:
        """Return positions of the tool at random positions of the joints.

        Args:
            samples: Number of random joint positions.
            collisions: Whether to keep those at which links touch.
        """
        from teleopctl.kinematics.workspace import sample_workspace

        clearance = None if collisions else self.clearance
        return sample_workspace(self.kinematics, clearance=clearance, samples=samples)

    def plan(
        self,
        goal: Positions | str,
        start: Positions | None = None,
        settings: MotionSettings | None = None,
        *,
        is_position: bool = False,
    ) -> MotionPlan:
        """Return a collision-free motion to a goal, timed under the joints' limits.

        Args:
            goal: Name of a state, positions by name, (n,) positions, or a pose of the tool, (4, 4).
            start: Positions at which the motion begins; by default `positions`.
            settings: Planner, time for the search, scaling of velocities and accelerations.
            is_position: Whether the goal is the position of the tool, (3,) or that of (4, 4), and
                its rotation does not matter.

        Raises:
            PlanningError: There is no such motion, or none was found in time.
        """
        from teleopctl.kinematics.motion.plan import plan_to_joints, plan_to_pose

        begin = self._vector(start)
        if not isinstance(goal, str | Mapping) and (is_position or np.shape(goal) == _POSE):
            target, _ = self._target(goal, begin)
            return plan_to_pose(
                self.kinematics,
                begin,
                target,
                task=_position_task(is_position),
                clearance=self.clearance,
                settings=settings,
            )
        return plan_to_joints(
            self.kinematics,
            begin,
            self._vector(goal),
            clearance=self.clearance,
            settings=settings,
        )

    def line(
        self,
        pose: Sequence[float] | Array,
        start: Positions | None = None,
        settings: MotionSettings | None = None,
    ) -> MotionPlan:
        """Return a motion of the tool on a straight line, timed under the joints' limits.

        Args:
            pose: Pose at the end, (4, 4), or a position (3,) that keeps the tool's rotation.
            start: Positions at which the motion begins; by default `positions`.
            settings: Scaling of velocities and accelerations.

        Raises:
            PlanningError: The line cannot be followed to its end.
        """
        from teleopctl.kinematics.motion.plan import plan_line

        begin = self._vector(start)
        target, _ = self._target(pose, begin)
        return plan_line(
            self.kinematics, begin, [target], clearance=self.clearance, settings=settings
        )

    def servo_step(self, twist: Sequence[float] | Array, period_s: float) -> ServoStep:
        """Return the next positions of joints that follow a twist of the tool; advance to them.

        Args:
            twist: Linear (m/s) and angular (rad/s) velocity of the tool in the axes of the root
                link, (6,).
            period_s: Time until the next step, s.

        Raises:
            UsageError: The twist has not six finite numbers, or the time is not above 0.
        """
        wanted = np.asarray(twist, np.float64)
        if wanted.shape != (6,) or not np.isfinite(wanted).all():
            raise UsageError(
                "A twist is six finite numbers: vx, vy, vz in m/s, wx, wy, wz in rad/s"
            )
        if not 0.0 < period_s < math.inf:
            raise UsageError(f"The period must be a time above 0, got {period_s:g}")
        step = self._servo.twist_step(wanted, period_s)
        self._positions = np.array(step.positions)
        return step

    # --- parts ----------------------------------------------------------------------------------

    @cached_property
    def clearance(self) -> ClearanceChecker:
        """Checker of collisions: all links but those that the SRDF and the gripper allow."""
        return arm_clearance(self.model, self.groups, self.group)

    @cached_property
    def _servo(self) -> ServoCore:
        from teleopctl.kinematics.motion.limits import MotionLimits
        from teleopctl.kinematics.servo.core import ServoCore

        core = ServoCore(
            self.kinematics,
            MotionLimits.of(self.kinematics).accelerations,
            clearance=self.clearance,
        )
        core.reset(self._positions)
        return core

    def _target(self, pose: Sequence[float] | Array, start: Array) -> tuple[Array, bool]:
        """Return a pose, (4, 4), and whether only its position counts."""
        try:
            target = np.asarray(pose, np.float64)
        except (TypeError, ValueError):
            target = np.zeros(0)
        if target.shape == _POSE:
            return target, False
        if target.shape != _POSITION:
            raise UsageError(
                f"A pose is a (4, 4) matrix, or x, y, z in m; got shape {target.shape}"
            )
        if not np.isfinite(target).all():
            raise UsageError("The position has values that are no finite numbers")
        # The rotation, that of the start, is a soft task.
        whole = self.fk(start)
        whole[:3, 3] = target
        return whole, True

    def _vector(self, positions: Positions | str | None) -> Array:
        """Return positions as a vector, (n,)."""
        if positions is None:
            return self._positions.copy()
        if isinstance(positions, str):
            positions = self.groups.state(self.group.name, positions)
            positions = {name: at for name, at in positions.items() if name in self.names}
        if isinstance(positions, Mapping):
            vector = self._positions.copy()
            for name, position in positions.items():
                if name not in self.names:
                    raise NotFoundError(
                        f"The group '{self.group.name}' has no joint '{name}' that moves by itself",
                        hint=f"It has: {', '.join(self.names)}",
                    )
                vector[self.names.index(name)] = position
        else:
            try:
                vector = np.array(positions, np.float64)
            except (TypeError, ValueError):
                vector = np.zeros(0)
        if vector.shape != (len(self.names),):
            raise UsageError(
                f"The group '{self.group.name}' has {len(self.names)} joints, got "
                f"{vector.size} positions",
                hint=f"Its joints are: {', '.join(self.names)}",
            )
        if not np.isfinite(vector).all():
            raise UsageError("A position is no finite number")
        return vector


def _position_task(is_position: bool) -> PoseTask | None:
    from teleopctl.kinematics.solver import PoseTask

    return PoseTask.POSITION if is_position else None


def arm_clearance(
    model: KinematicModel, groups: RobotGroups, group: JointGroup
) -> ClearanceChecker:
    """Return the checker of an arm's collisions, in which the fingers of its gripper may touch.

    Args:
        model: Model of the robot.
        groups: Its groups, with the pairs of links that may touch.
        group: Group of the arm.
    """
    clearance = ClearanceChecker(model, groups.allowed_collisions)
    if gripper := groups.gripper_of(group.name):
        # Fingers close on each other, or on what they hold.
        joints = model.description.joints
        clearance.allow_within(joints[name].child for name in gripper.joints)
    return clearance


def load_description(path: Path, arguments: Mapping[str, str] | None = None) -> RobotDescription:
    """Return the description of a robot file of any format.

    Args:
        path: The file.
        arguments: Values of the arguments of a xacro file, by name.

    Raises:
        InvalidDescriptionError: The file cannot be read, or is no robot.
        NotFoundError: There is no such file.
    """
    # A running robot's description is no file: the import takes as long as reading it.
    from teleopctl.robot import read_model, with_absolute_mesh_paths

    if not path.is_file():
        raise NotFoundError(f"There is no file {path}")
    read = read_model(path, dict(arguments or {}))
    return RobotDescription.from_urdf(with_absolute_mesh_paths(read.text, path.parent))


def _description(robot: str | Path | RobotDescription | HasUrdf) -> RobotDescription:
    if isinstance(robot, RobotDescription):
        return robot
    if isinstance(robot, str) and robot.lstrip().startswith("<"):
        return RobotDescription.from_urdf(robot)
    if isinstance(robot, str | Path):
        return load_description(resolve_uri(str(robot)))
    return RobotDescription.from_urdf(robot.urdf)


def _with_tool(
    group: JointGroup, tool: str | Sequence[float] | Array | None, description: RobotDescription
) -> tuple[JointGroup, Array | None]:
    """Return a group with its tool's link as its tip, and the pose of the tool in that frame."""
    if tool is None:
        return group, None
    if isinstance(tool, str):
        moved = moved_links(group, description)
        if tool not in moved:
            problem = "does not move" if tool in description.links else "knows no"
            raise NotFoundError(
                f"The group '{group.name}' {problem} link '{tool}'",
                hint=f"It moves: {', '.join(moved)}",
            )
        return with_tip(group, tool), None
    offset = np.asarray(tool, np.float64)
    if offset.shape == _POSE and np.isfinite(offset).all():
        return group, offset
    if offset.shape not in (_POSITION, (6,)) or not np.isfinite(offset).all():
        raise UsageError(
            "A tool is a link's name, x y z, x y z roll pitch yaw, or a (4, 4) matrix of numbers"
        )
    pose = np.eye(4)
    pose[:3, 3] = offset[:3]
    if offset.size > _POSITION[0]:
        pose[:3, :3] = matrix_from_quaternion(quaternion_from_rpy(*offset[3:].tolist()))
    return group, pose


def moved_links(group: JointGroup, description: RobotDescription) -> list[str]:
    """Return the links that a group's joints move, from the root outwards."""
    moved = {description.joints[name].child for name in group.joints}
    for joint in description.tree:
        if joint.parent in moved:
            moved.add(joint.child)
    return [joint.child for joint in description.tree if joint.child in moved]
