"""Efforts of joints for a motion, with what the robot carries."""

import numpy as np
import pytest

from teleopctl.kinematics import (
    AttachedBody,
    CollisionBody,
    CollisionScene,
    CollisionShape,
    GroupKinematics,
    KinematicModel,
    MotionSettings,
    ShapeKind,
    find_groups,
    joint_efforts,
    overload_note,
    plan_to_joints,
)
from teleopctl.robot import RobotDescription

# A rod of 2 kg and 1 m about a horizontal axis.
ROD = """<robot name="rod"><link name="base"/>
<link name="rod"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 -1 0"/>
<limit lower="-3" upper="3" velocity="2" effort="20"/></joint>
<link name="tool0"/><joint name="tip" type="fixed"><parent link="rod"/><child link="tool0"/>
<origin xyz="1 0 0"/></joint></robot>"""
G = 9.81
BOX = CollisionShape.primitive(ShapeKind.BOX, (0.1, 0.1, 0.1))


def held(weight: float) -> CollisionScene:
    scene = CollisionScene(KinematicModel(RobotDescription.from_urdf(ROD)))
    box = CollisionBody("box", np.eye(4), (BOX,), (np.eye(4),))
    scene.attach(AttachedBody(box, "tool0", weight=weight))
    return scene


def kinematics(model: KinematicModel) -> GroupKinematics:
    return GroupKinematics(model, find_groups(model.description).group())


def test_efforts_are_gravity_and_inertia():
    own = kinematics(KinematicModel(RobotDescription.from_urdf(ROD)))
    efforts = joint_efforts(
        own,
        np.array([[0.0], [np.pi / 2], [0.0]]),
        np.array([[0.0], [1.0], [0.0]]),
        np.array([[0.0], [0.0], [3.0]]),
    )
    inertia = 0.2 + 2.0 * 0.5**2
    expected = [2.0 * G * 0.5, 0.0, 2.0 * G * 0.5 + 3.0 * inertia]
    assert efforts[:, 0] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("weight", "mass"), [(0.5, 0.5), (0.0, 1.0)])
def test_an_attached_object_weighs_what_is_given_or_as_water(weight, mass):
    compiled = held(weight).compile()
    assert compiled.mass("box") == pytest.approx(mass)
    efforts = joint_efforts(
        kinematics(compiled.model), np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1))
    )
    assert efforts[0, 0] == pytest.approx((2.0 * 0.5 + mass) * G)


def test_a_joint_that_a_plan_overloads_is_named():
    for weight, is_too_much in ((0.5, False), (3.0, True)):
        own = kinematics(held(weight).compile().model)
        plan = plan_to_joints(
            own, np.zeros(1), np.array([0.2]), settings=MotionSettings(velocity_scaling=0.1)
        )
        note = overload_note(own, plan)
        assert bool(note) is is_too_much
    assert note.startswith("Joint 'hinge' needs 4")
    assert note.endswith(" s, more than its limit of 20 N m")
