"""Forward kinematics by yourdfpy, which shares no code with teleopctl's."""

import io
from collections.abc import Mapping

import numpy as np
import yourdfpy
from trimesh.transformations import compose_matrix

from teleopctl.robot.urdf import Pose


def read(urdf: str) -> yourdfpy.URDF:
    return yourdfpy.URDF.load(
        io.StringIO(urdf), load_meshes=False, build_collision_scene_graph=False
    )


def link_frames(urdf: str, positions: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Return the pose of each link in the root link's frame, as (4, 4) matrices by link."""
    robot = read(urdf)
    robot.update_cfg({name: positions.get(name, 0.0) for name in robot.actuated_joint_names})
    return {link: robot.get_transform(link) for link in robot.link_map}


def pose_matrix(pose: Pose) -> np.ndarray:
    """Return a pose as a (4, 4) matrix that maps coordinates of the child to the parent frame."""
    matrix: np.ndarray = compose_matrix(translate=pose.xyz, angles=pose.rpy)
    return matrix
