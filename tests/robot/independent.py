"""Forward kinematics by yourdfpy, which shares nothing with ours."""

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
    """Each link's frame in the root link's, as 4x4 matrices."""
    robot = read(urdf)
    robot.update_cfg({name: positions.get(name, 0.0) for name in robot.actuated_joint_names})
    return {link: robot.get_transform(link) for link in robot.link_map}


def pose_matrix(pose: Pose) -> np.ndarray:
    """A pose as a 4x4 matrix that maps from its frame into its parent."""
    matrix: np.ndarray = compose_matrix(translate=pose.xyz, angles=pose.rpy)
    return matrix
