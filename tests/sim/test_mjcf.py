"""Robots that are written for MuJoCo: their file's physics, and ROS's names for it."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import (
    Joints,
    Pose,
    RobotDescription,
    SegmentTree,
    default_controllers,
    model_kind,
    read_model,
    simulated,
)
from teleopctl.sim.building import SimulatedRobot, simulate
from teleopctl.tf import Transform

PERIOD_NS = 10_000_000

PARTS = """
<mujocoinclude>
  <default>
    <default class="arm">
      <joint armature="0.05" damping="0.5"/>
      <geom rgba="1 0 0 1" mass="0.5"/>
      <position kp="300" kv="30"/>
    </default>
  </default>
  <asset><mesh name="part" file="part.stl" scale="0.1 0.1 0.1"/></asset>
</mujocoinclude>
"""
# Several joints in one body, each with its own place and zero; degrees; a ball; a mesh.
ARM = """
<mujoco model="arm">
  <compiler angle="degree" meshdir="meshes" eulerseq="zyx"/>
  <option timestep="0.0025" gravity="0 0 -3"/>
  <include file="parts.xml"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="cube" pos="1 1 0.05"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
    <body name="base" pos="0 0 0.3" euler="20 0 10" childclass="arm">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="upper" pos="0 0 0.1">
        <joint name="pan" axis="0 0 1" pos="0.02 0 0" ref="15"/>
        <joint name="lift" axis="0 1 0" pos="0 0 0.03" range="-100 100"/>
        <joint name="reach" type="slide" axis="1 0 1" ref="0.02" range="-0.1 0.3"/>
        <geom type="mesh" mesh="part" pos="0 0 0.1" euler="0 30 0"/>
        <body pos="0.2 0 0.2" euler="0 0 40">
          <joint name="wrist" type="ball"/>
          <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.02"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position class="arm" joint="pan"/>
    <velocity name="turn" joint="lift" kv="5"/>
    <motor name="push" joint="reach" gear="2"/>
  </actuator>
  <keyframe>
    <key name="home" qpos="1 1 0.05 1 0 0 0 0.3 0.2 0.1 0.9 0.1 0.3 0.2" ctrl="0.3 0.1 0.4"/>
  </keyframe>
</mujoco>
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An arm in three files, which nobody stands beside."""
    folder = tmp_path_factory.mktemp("arm")
    (folder / "meshes").mkdir()
    trimesh.creation.box((1, 2, 3)).export(folder / "meshes" / "part.stl")
    (folder / "parts.xml").write_text(PARTS)
    (folder / "scene.xml").write_text(ARM)
    return folder / "scene.xml"


def described(file: Path) -> RobotDescription:
    return RobotDescription.from_urdf(read_model(file).text)


def simulated_robot(file: Path, **options: object) -> SimulatedRobot:
    urdf = simulated(read_model(file).text).urdf
    return simulate(urdf, control_period_ns=PERIOD_NS, **options)  # type: ignore[arg-type]


def of(tmp_path: Path, body: str, rest: str = "") -> Path:
    file = tmp_path / "robot.xml"
    file.write_text(f"<mujoco><worldbody>{body}</worldbody>{rest}</mujoco>")
    return file


def chain(*joints: str) -> str:
    """Links of 0.5 kg one after the other, without gravity's pull at their joints."""
    parts = [
        f'<body pos="0 0 0.2">{joint}<geom type="sphere" size="0.05" mass="0.5"/>'
        for joint in joints
    ]
    return "".join(parts) + "</body>" * len(parts)


def poses(description: RobotDescription, positions: dict[str, float]) -> dict[str, Transform]:
    """Where each link is in the root link."""
    tree = SegmentTree(description, Joints.of(description))
    segments = [(segment.joint, segment.origin) for segment in tree.fixed]
    moved = {joint.child: place for joint, place in [*segments, *tree.transforms(positions)]}
    found = {description.root: Transform()}
    for joint in description.tree:
        if joint.child in moved:
            found[joint.child] = found[joint.parent] @ moved[joint.child]
    return found


def test_each_link_is_where_mujoco_has_the_body(arm: Path) -> None:
    description, robot = described(arm), simulated_robot(arm).simulation
    generator = np.random.default_rng(7)
    for _ in range(20):
        given = dict(zip(robot.joint_names, generator.uniform(-1.0, 1.0, 6), strict=True))
        robot.reset_state(given)
        found = poses(description, dict(zip(robot.joint_names, robot.positions, strict=True)))
        assert robot.positions == pytest.approx(list(given.values()))
        for link in ("base", "upper", "body_1"):
            pose = robot.link_pose(link)
            assert found[link].translation == pytest.approx(pose.position, abs=1e-9)
            x, y, z, w = found[link].rotation
            assert abs(np.dot([w, x, y, z], pose.quaternion)) == pytest.approx(1.0)


def test_physics_is_that_of_the_file_to_the_bit(arm: Path) -> None:
    simulation = simulated_robot(arm).simulation
    m = mujoco.MjModel.from_xml_path(str(arm))
    data = mujoco.MjData(m)
    mujoco.mj_resetDataKeyframe(m, data, 0)
    mujoco.mj_step(m, data, 400)

    simulation.step_to(1_000_000_000)
    _, state = simulation.observe()

    assert simulation.timestep_s == 0.0025
    assert state.qpos.tolist() == data.qpos.tolist()
    assert state.qvel.tolist() == data.qvel.tolist()


def test_masses_and_meshes_are_the_files_from_any_folder(
    arm: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    read = read_model(arm)
    links = RobotDescription.from_urdf(read.text).links

    assert [link.inertial.mass for link in links.values() if link.inertial] == [0.5] * 3
    assert (arm.parent / "meshes" / "part.stl").as_uri() in read.text
    assert set(read.files) == {arm, arm.parent / "parts.xml"}
    assert (links["upper"].visuals, links["upper"].collisions) != ((), ())


def test_what_has_no_joints_is_the_world_around_it(arm: Path) -> None:
    robot = simulated_robot(arm)

    assert robot.description.root == "world"
    assert "cube" not in robot.description.links
    assert [body.link for body in robot.model.free_bodies] == ["cube"]
    m = robot.model.mj_model
    around = {m.body(m.geom_bodyid[geom]).name for geom in robot.model.world_geoms}
    assert around == {"world", "cube"}


def test_commands_go_through_the_actuators_of_the_file(arm: Path) -> None:
    robot = simulated_robot(arm)
    names = ["pan", "lift", "reach"]
    commands = {joint.name: joint.command_interfaces for joint in robot.model.joints}
    nan = float("nan")
    robot.simulation.apply(names, [0.7, nan, nan], [nan, 0.5, nan], [nan, nan, 3.0])
    _, state = robot.simulation.observe()

    assert [commands[name] for name in names] == [("position",), ("velocity",), ("effort",)]
    assert state.ctrl == pytest.approx([0.7, 0.5, 1.5])
    robot.simulation.hold()
    _, state = robot.simulation.observe()
    assert state.ctrl == pytest.approx([0.7, 0.0, 0.0])


def test_an_actuator_of_a_tendon_moves_the_joints_that_are_tied(tmp_path: Path) -> None:
    file = of(
        tmp_path,
        '<body name="palm"><geom size="0.05"/>'
        '<body pos="0 1 0"><joint name="left" type="slide" axis="0 1 0"/><geom size="0.01"/></body>'
        '<body pos="0 -1 0"><joint name="right" type="slide" axis="0 -1 0"/>'
        '<geom size="0.01"/></body></body>',
        '<tendon><fixed name="split"><joint joint="left" coef="0.5"/>'
        '<joint joint="right" coef="0.5"/></fixed></tendon>'
        '<equality><joint joint1="right" joint2="left"/></equality>'
        '<actuator><general name="grip" tendon="split" gainprm="0.4" biastype="affine"'
        ' biasprm="0 -100 -10" ctrlrange="0 255" ctrllimited="true"/></actuator>'
        '<option gravity="0 0 0"/>',
    )
    robot = simulated_robot(file)
    robot.simulation.apply(["left"], [0.02])
    robot.simulation.step_to(3_000_000_000)
    robot.simulation.read()

    assert described(file).joints["right"].mimic is not None
    assert robot.simulation.positions == pytest.approx([0.02, 0.02], abs=1e-4)


def test_without_actuators_nothing_drives_a_joint_and_a_line_says_so(tmp_path: Path) -> None:
    joints = (
        '<joint name="pan" axis="0 1 0" damping="0.1"/>',
        '<joint name="hip" type="ball" damping="0.01" stiffness="2"/>',
        '<joint name="lift" type="slide" axis="0 0 1" range="-1 1" frictionloss="0.2"/>',
    )
    floor = '<geom type="plane" size="5 5 0.1"/><light pos="0 0 3"/>'
    weightless = '<body name="float" pos="1 0 1" gravcomp="1"><joint/><geom size="0.1"/></body>'
    file = of(tmp_path, f"{floor}{weightless}{chain(*joints)}")
    remark = "robot.xml has no &lt;actuator&gt;: nothing drives its joints, which take no commands"
    assert remark in read_model(file).text
    assert [*default_controllers(described(file))] == ["controller_manager"]
    simulation = simulated_robot(file).simulation
    assert not any(simulation.commandable(name) for name in simulation.joint_names)
    simulation.apply(["pan"], [0.5], [0.5], [0.5])
    simulation.hold()

    bare = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(bare)
    simulation.step(2000)
    mujoco.mj_step(bare, data, 2000)
    _, ours = simulation.observe()
    assert abs(float(data.qpos[0])) + abs(float(data.joint("lift").qpos[0])) > 0.1, "they move"
    assert ours.qpos.tobytes() == data.qpos.tobytes()
    assert ours.qvel.tobytes() == data.qvel.tobytes()


def test_a_joint_beside_actuated_ones_is_as_free_as_the_file_has_it(tmp_path: Path) -> None:
    both = chain('<joint name="hinge" axis="0 1 0"/>', '<joint name="loose" axis="0 1 0"/>')
    file = of(tmp_path, both, '<actuator><motor joint="hinge"/></actuator>')

    parameters = default_controllers(described(file))

    assert parameters["effort_controller"]["ros__parameters"]["joints"] == ["hinge"]
    assert not simulated_robot(file).simulation.commandable("loose")


def test_an_actuator_that_no_joint_stands_for_is_named(tmp_path: Path) -> None:
    body = '<body name="base"><joint name="hinge"/><geom size="0.1"/><site name="nozzle"/></body>'
    file = of(tmp_path, body, '<actuator><general name="thrust" site="nozzle"/></actuator>')
    said: list[str] = []
    simulated_robot(file, warn=said.append)

    assert said == ["Actuator 'thrust' does not move a single joint: it keeps its control value"]


def test_a_free_base_starts_where_the_file_or_somebody_puts_it(tmp_path: Path) -> None:
    file = of(
        tmp_path,
        f'<body name="dog" pos="0 0 0.8"><freejoint/><geom size="0.1"/>{chain("<joint/>")}</body>',
    )

    def place(**options: object) -> list[float]:
        pose = simulated_robot(file, **options).simulation.link_pose("dog")
        return list(pose.position)

    assert described(file).root == "dog"
    assert place() == [0, 0, 0.8]
    assert place(spawn_pose=Pose((1.0, 2.0, 0.0))) == [1, 2, 0.8]
    assert place(fixed_base=True) == [0, 0, 0]
    assert simulated_robot(file, fixed_base=True).model.free_bodies == ()


def test_files_are_told_apart_by_their_root_element(tmp_path: Path) -> None:
    file = of(tmp_path, chain("<joint/>"))
    urdf = tmp_path / "robot.urdf"
    urdf.write_text('<?xml version="1.0"?><!-- a robot --><robot name="r"><link name="l"/></robot>')

    assert (model_kind(file), model_kind(urdf), model_kind(tmp_path)) == ("mjcf", "urdf", "urdf")


def test_comments_that_xml_forbids_and_mujoco_reads_are_no_mistake(tmp_path: Path) -> None:
    file = of(tmp_path, chain("<joint/>"))
    comment = "<!-- left -- right -->"
    (tmp_path / "parts.xml").write_text(f"<mujoco>{comment}<option gravity='0 0 -1'/></mujoco>")
    text = file.read_text().replace("<worldbody>", '<include file="parts.xml"/><worldbody>', 1)
    file.write_text(comment + text)

    assert model_kind(file) == "mjcf"
    assert read_model(file).files == (file, tmp_path / "parts.xml")


def test_a_joint_gives_no_more_than_its_actuator_and_its_own_limit_allow(tmp_path: Path) -> None:
    actuator = '<actuator><motor joint="j" ctrllimited="true" ctrlrange="-{0} {0}"/></actuator>'
    body = chain('<joint name="j" actuatorfrcrange="-5 5"/>')
    for motor, most in ((3.0, 3.0), (8.0, 5.0)):
        file = of(tmp_path, body)
        file.write_text(file.read_text().replace("</mujoco>", actuator.format(motor) + "</mujoco>"))
        limit = described(file).joints["j"].limit
        assert limit is not None and limit.effort == most


def test_a_shape_that_urdf_does_not_have_is_named(tmp_path: Path) -> None:
    file = of(tmp_path, '<body name="hill"><geom type="plane" size="1 1 1"/></body>')
    assert described(file).repairs == ("A plane of link 'hill' is simulated, not shown",)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", "mass and inertia"),
        ("<mujoco><worldbody/></mujoco>", "contains no robot"),
        ('<mujoco><include file="none.xml"/></mujoco>', "none.xml"),
    ],
)
def test_what_mujoco_refuses_is_told_with_its_file(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(text)

    with pytest.raises(InvalidDescriptionError, match=said) as raised:
        read_model(file)

    assert str(file) in raised.value.message
