"""Check a robot description in CI: ROBOT=my_robot.urdf pytest test_robot.py"""

import os

import numpy as np

import teleopctl

FILE = os.environ.get("ROBOT", "package://teleop_description/urdf/teleop.urdf.xacro")
robot = teleopctl.load_robot(FILE)


def test_the_description_needs_no_repair() -> None:
    assert robot.repairs == []


def test_all_meshes_exist() -> None:
    meshes = robot.meshes() + robot.meshes(collision=True)
    assert [str(mesh.path) for mesh in meshes if not mesh.path.is_file()] == []


def test_another_reader_sees_the_same_frames() -> None:
    other = robot.to_yourdfpy(load_meshes=False)
    for link, T_root_link in robot.forward_kinematics().items():
        assert np.allclose(other.get_transform(link, robot.root_link), T_root_link), link


def test_physics_stays_finite_for_two_seconds() -> None:
    simulation = teleopctl.RobotSimulation(robot)
    simulation.step(200)
    assert all(np.isfinite(value) for value in simulation.velocities.values())
