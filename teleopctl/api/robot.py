"""Robot from a description file: links, joints, limits, meshes, forward kinematics."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError, NotFoundError
from teleopctl.packages import resolve_uri
from teleopctl.robot import (
    JointModel,
    Joints,
    Mesh,
    Pose,
    RobotDescription,
    SegmentTree,
    read_model,
    with_absolute_mesh_paths,
    xacro_arguments,
)
from teleopctl.tf import Transform, matrix_from_quaternion, quaternion_from_rpy

if TYPE_CHECKING:
    import mujoco
    import yourdfpy

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RobotJoint:
    """Joint of a robot that moves along or about one axis.

    Positions are in rad, or in m for prismatic joints; the other units follow from these, and
    efforts are in N m or N. A missing limit is infinite.

    Attributes:
        name: Name of the joint.
        type: ``revolute``, ``continuous`` or ``prismatic``.
        parent: Name of the parent link.
        child: Name of the child link.
        axis: Unit vector of the axis in the joint's frame, (3,).
        lower: Smallest position.
        upper: Largest position.
        velocity: Largest speed.
        effort: Largest effort.
        mimic: Name of the joint that this one follows, or None.
        multiplier: Factor of the followed position.
        offset: Position that is added to the product (rad or m).

    Example:
        >>> robot = load_robot("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> joint = robot.joints["joint_5"]
        >>> joint.mimic, joint.multiplier, joint.velocity
        ('joint_4', -1.0, 10.0)
    """

    name: str
    type: str
    parent: str
    child: str
    axis: tuple[float, float, float]
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    mimic: str | None = None
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class RobotMesh:
    """Mesh file of a robot: path, scale, and pose on a link.

    Attributes:
        link: Name of the link.
        path: Path of the mesh file, which need not exist.
        T_link_mesh: Pose of the mesh in the link's frame, (4, 4).
        scale: Factors along x, y and z that apply before the pose.

    Example:
        >>> robot = load_robot("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> mesh = robot.meshes()[0]
        >>> mesh.link, mesh.path.name, mesh.scale
        ('base_link', 'basement.STL', (0.01, 0.01, 0.01))
    """

    link: str
    path: Path
    T_link_mesh: Array
    scale: tuple[float, float, float]


class Robot:
    """A robot from its description: links, joints, meshes, kinematics; `load_robot` reads a file.

    Args:
        urdf: The description as URDF text.

    Attributes:
        name: Name of the robot.
        urdf: The description as URDF text, with xacro expanded.
        root_link: Name of the root link.
        link_names: Names of all links, in the order of the description.
        joints: Joints that move along or about one axis, by name.
        repairs: One sentence for each repair of the description.

    Raises:
        InvalidDescriptionError: The text is not URDF, or the links do not form a tree.

    Example:
        >>> robot = Robot('''<robot name="pole"><link name="base"/><link name="tip"/>
        ...     <joint name="lift" type="prismatic"><parent link="base"/><child link="tip"/>
        ...     <axis xyz="0 0 1"/><limit lower="0" upper="2" effort="1" velocity="1"/></joint>
        ...     </robot>''')
        >>> robot.joints["lift"].upper
        2.0
        >>> robot.forward_kinematics({"lift": 0.5})["tip"][:3, 3].tolist()
        [0.0, 0.0, 0.5]
    """

    def __init__(self, urdf: str) -> None:
        self._description = description = RobotDescription.from_urdf(urdf)
        self._models = Joints.of(description)
        self._segments = SegmentTree(description, self._models)
        self.name = description.name
        self.urdf = description.urdf
        self.root_link = description.root
        self.link_names = list(description.links)
        self.joints = {name: _robot_joint(name, model) for name, model in self._models.items()}
        self.repairs = list(description.repairs)

    @property
    def actuated_joint_names(self) -> list[str]:
        """Names of the joints that mimic no other joint, in the description's order."""
        return [name for name, joint in self.joints.items() if joint.mimic is None]

    def forward_kinematics(self, positions: Mapping[str, float] | None = None) -> dict[str, Array]:
        """Return the pose of every link in the root link's frame, as (4, 4) arrays by link.

        Floating and planar joints are taken at their origins.

        Args:
            positions: Joint positions (rad or m) by name. Missing joints are at zero, and joints
                that follow others are computed.

        Returns:
            Homogeneous transforms, (4, 4), by link.

        Raises:
            NotFoundError: The robot has no such joint.
        """
        given = dict(positions or {})
        for name in given:
            if name not in self.joints:
                raise NotFoundError(
                    f"robot '{self.name}' has no joint '{name}'",
                    hint=f"It has {', '.join(self.joints) or 'none that move'}.",
                )
        start = {name: given.get(name, 0.0) for name in self.actuated_joint_names}
        poses = self._segments.link_poses({**start, **given})
        return {link: _matrix(pose) for link, pose in poses.items()}

    def meshes(self, *, collision: bool = False) -> list[RobotMesh]:
        """Return the visual (or collision) mesh files of the robot, with their poses on links.

        Args:
            collision: Whether to return the collision meshes instead of the visual ones.

        Raises:
            NotFoundError: The package of a mesh is unknown.
        """
        return list(self._meshes(collision))

    def _meshes(self, collision: bool) -> Iterator[RobotMesh]:
        for link in self._description.links.values():
            for shape in link.collisions if collision else link.visuals:
                if isinstance(shape.geometry, Mesh):
                    yield RobotMesh(
                        link.name,
                        resolve_uri(shape.geometry.uri),
                        _matrix(_transform(shape.origin)),
                        shape.geometry.scale,
                    )

    def to_yourdfpy(self, *, load_meshes: bool = True) -> yourdfpy.URDF:
        """Return the robot as a ``yourdfpy.URDF``, with its scene graph.

        Args:
            load_meshes: Whether to load the visual meshes.
        """
        import yourdfpy

        def locate(fname: str) -> str:
            return str(resolve_uri(fname))

        return yourdfpy.URDF.load(
            io.BytesIO(self.urdf.encode()), load_meshes=load_meshes, filename_handler=locate
        )

    def to_mujoco(self) -> mujoco.MjModel:
        """Return the robot as a compiled MuJoCo model, without a world and without sensors.

        Raises:
            InvalidDescriptionError: MuJoCo cannot simulate the description.
        """
        from teleopctl.mujoco_model import build_model

        return build_model(self._description).mj_model


def load_robot(path: Path | str, **arguments: str) -> Robot:
    """Read a robot from a URDF, xacro, SDF or MJCF file; return a `Robot`.

    Args:
        path: Path of a URDF, xacro, SDF or MJCF file, or ``package://PACKAGE/PATH``.
        arguments: Values of the arguments of a xacro file (``<xacro:arg>``).

    Raises:
        InvalidDescriptionError: The file cannot be read, or does not declare an argument.
        NotFoundError: The package or the file does not exist.

    Example:
        >>> robot = load_robot("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> robot.actuated_joint_names
        ['joint_1', 'joint_2', 'joint_3', 'joint_4']
        >>> T_world_claw = robot.forward_kinematics({"joint_1": 0.5})["claw_support"]
        >>> T_world_claw.shape
        (4, 4)
    """
    file = resolve_uri(str(path))
    if not file.is_file():
        raise NotFoundError(f"{file}: no such file")
    read = read_model(file, arguments)
    taken = xacro_arguments(read.files)
    for name in arguments:
        if name not in taken:
            raise InvalidDescriptionError(
                f"{file} takes no argument '{name}'",
                hint=f"It takes {', '.join(taken) or 'none'}.",
            )
    return Robot(with_absolute_mesh_paths(read.text, file.parent))


def _robot_joint(name: str, model: JointModel) -> RobotJoint:
    joint, limits, mimic = model.joint, model.limits, model.mimic
    return RobotJoint(
        name,
        joint.type,
        joint.parent,
        joint.child,
        joint.axis,
        limits.lower,
        limits.upper,
        limits.velocity,
        limits.effort,
        *((mimic.joint, mimic.multiplier, mimic.offset) if mimic else ()),
    )


def _transform(pose: Pose) -> Transform:
    return Transform(pose.xyz, quaternion_from_rpy(*pose.rpy))


def _matrix(transform: Transform) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = matrix_from_quaternion(transform.rotation)
    matrix[:3, 3] = transform.translation
    return matrix
