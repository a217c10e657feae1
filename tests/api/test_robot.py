"""`load_robot`: a robot's links, joints, meshes and frames for programs."""

import numpy as np
import pytest

from teleopctl import Robot, load_robot
from teleopctl.errors import InvalidDescriptionError, NotFoundError

ARM = "package://teleop_description/urdf/teleop.urdf.xacro"
SLIDE = """
<robot name="lift">
  <link name="base"/>
  <link name="car"/>
  <link name="door"/>
  <joint name="shaft" type="prismatic">
    <parent link="base"/><child link="car"/>
    <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="3" effort="100" velocity="2"/>
  </joint>
  <joint name="hinge" type="continuous">
    <parent link="car"/><child link="door"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
    <mimic joint="shaft" multiplier="2" offset="0.1"/>
  </joint>
</robot>
"""


@pytest.fixture(scope="module")
def arm():
    return load_robot(ARM)


def test_joints_have_limits_and_followers(arm):
    assert arm.actuated_joint_names == ["joint_1", "joint_2", "joint_3", "joint_4"]
    joint = arm.joints["joint_5"]
    assert (joint.parent, joint.child) == ("claw_support", "gripper_left")
    assert (joint.mimic, joint.multiplier, joint.offset) == ("joint_4", -1.0, 0.0)
    assert (joint.lower, joint.velocity, joint.effort) == (0.0, 10.0, 30.0)


def test_links_have_poses_in_the_frame_of_the_root(arm):
    assert arm.root_link == "world"
    claw = arm.forward_kinematics()["claw_support"]
    assert claw[:3, 3] == pytest.approx([-0.02, 0.82, 1.457])
    assert set(arm.forward_kinematics()) == set(arm.link_names)


def test_positions_move_links_and_those_that_follow():
    poses = Robot(SLIDE).forward_kinematics({"shaft": 1.0})
    assert poses["door"][:3, 3] == pytest.approx([1.0, 0.0, 1.5])
    turned = np.pi / 2 + 2.1
    assert poses["door"][:2, 0] == pytest.approx([np.cos(turned), np.sin(turned)])


def test_yourdfpy_and_mujoco_see_the_same_robot(arm):
    positions = {"joint_1": 0.4, "joint_2": -0.3, "joint_3": 0.2, "joint_4": -0.5}
    other = arm.to_yourdfpy(load_meshes=False)
    other.update_cfg(positions)
    poses = arm.forward_kinematics(positions)
    for link in arm.link_names:
        assert other.get_transform(link, "world") == pytest.approx(poses[link], abs=1e-9)
    assert {arm.to_mujoco().joint(i).name for i in range(5)} == set(arm.joints)


def test_meshes_are_files_with_a_place_on_their_link(arm):
    meshes = arm.meshes()
    assert all(mesh.path.is_file() for mesh in meshes)
    base = meshes[0]
    assert (base.link, base.scale) == ("base_link", (0.01, 0.01, 0.01))
    assert base.T_link_mesh[:3, 3] == pytest.approx([-0.5, -0.5, 0.0])
    assert arm.meshes(collision=True) == []  # its collision shapes are boxes


def test_meshes_beside_a_strangers_file_are_found(tmp_path):
    (tmp_path / "part.stl").write_bytes(b"")
    text = "<robot name='r'><link name='a'><visual><geometry><mesh filename='part.stl'/>"
    file = tmp_path / "r.urdf"
    file.write_text(text + "</geometry></visual></link></robot>")
    assert [mesh.path for mesh in load_robot(file).meshes()] == [tmp_path / "part.stl"]


def test_arguments_go_to_xacro(tmp_path):
    file = tmp_path / "r.xacro"
    file.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:arg name="prefix" default="a_"/><link name="$(arg prefix)base"/></robot>'
    )
    assert load_robot(file).link_names == ["a_base"]
    assert load_robot(file, prefix="b_").link_names == ["b_base"]
    with pytest.raises(InvalidDescriptionError, match="takes no argument 'side'") as caught:
        load_robot(file, side="left")
    assert "prefix" in str(caught.value.hint)


def test_mistakes_are_named(arm, tmp_path):
    with pytest.raises(NotFoundError, match="no joint 'joint_9'"):
        arm.forward_kinematics({"joint_9": 0.0})
    with pytest.raises(NotFoundError, match="no such file"):
        load_robot(tmp_path / "none.urdf")
    with pytest.raises(InvalidDescriptionError):
        Robot("<robot")
