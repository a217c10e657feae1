"""A world around a robot: added to its model, and real to the touch."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.robot import read_world
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import INERTIAL, box, control, joint, link, robot

BLOCK = box("visual", "0.2 0.2 0.2") + box("collision", "0.2 0.2 0.2")
FLOATING = 'type="floating"><parent link="world"/>'


def world_urdf(*parts: str) -> str:
    return f'<robot name="w"><link name="world"/>{"".join(parts)}</robot>'


def cube(name: str = "cube", xyz: str = "2 0 0.5") -> str:
    place = f'<child link="{name}"/><origin xyz="{xyz}"/></joint>'
    thing = link(name, INERTIAL.replace("0 0 0.25", "0 0 0") + BLOCK)
    return f'{thing}<joint name="{name}_joint" {FLOATING}{place}'


def wall(xyz: str) -> str:
    return link("wall", BLOCK) + joint("wall_joint", "world", "wall", kind="fixed", xyz=xyz)


def rod(root: str = "base") -> Any:
    """A rod of 1 m on a hinge, half a metre above the ground, that swings about y."""
    shape = INERTIAL + box("collision", "0.05 0.05 1", "0 0 0.5")
    hinge = joint("hinge", root, "rod", axis="0 1 0")
    return robot(link(root, ""), link("rod", shape), hinge, control(hinge="position"))


def build(tmp_path: Path, content: str, description: Any = None) -> RobotModel:
    file = tmp_path / "world.xml"
    file.write_text(content)
    return build_model(description or rod(), world=read_world(file), fixed_base=True)


def test_what_is_on_a_floating_joint_falls_and_what_is_on_a_fixed_one_holds_it(
    tmp_path: Path,
) -> None:
    model = build(tmp_path, world_urdf(wall("2 0 0.1"), cube()))
    simulation = Simulation(model, control_period_ns=100_000_000)
    simulation.step(1000)

    assert [body.link for body in model.free_bodies] == ["cube"]
    assert simulation.free_bodies.pose(0)[:3] == pytest.approx([2.0, 0.0, 0.3], abs=1e-3)
    simulation.reset_state()
    assert simulation.free_bodies.pose(0)[2] == 0.5


def test_what_has_come_to_rest_falls_when_it_is_put_elsewhere(tmp_path: Path) -> None:
    model = build(tmp_path, world_urdf(wall("2 0 0.1"), cube()))
    simulation = Simulation(model, control_period_ns=100_000_000)
    simulation.step(3000)
    simulation.free_bodies.put(0, np.array([2.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    simulation.refresh()
    simulation.step(100)
    assert simulation.free_bodies.pose(0)[2] == pytest.approx(1.0 - 9.81 * 0.1 * 0.101 / 2.0)


def test_things_at_rest_cost_nothing(tmp_path: Path) -> None:
    model = build(tmp_path, world_urdf(wall("2 0 0.1"), cube()))
    data = mujoco.MjData(model.mj_model)
    model.put_at_start(model.mj_model, data)
    contacts = []
    for _ in range(300):
        mujoco.mj_step(model.mj_model, data, 10)
        contacts.append(data.ncon)
    # Of the steps themselves: what a simulation shows has the contacts of what sleeps as well.
    assert max(contacts) > 0
    assert contacts[-1] == 0


@pytest.mark.parametrize(("xyz", "reached"), [("0.8 0 0.5", False), ("0.8 2 0.5", True)])
def test_the_robot_cannot_go_through_the_world(tmp_path: Path, xyz: str, reached: bool) -> None:
    model = build(tmp_path, world_urdf(wall(xyz)))
    simulation = Simulation(model, control_period_ns=100_000_000)
    for _ in range(20):
        simulation.apply(["hinge"], position=[1.57])
        simulation.step(simulation.steps_to_tick)
    simulation.read()

    assert (simulation.positions[0] > 1.5) == reached


def test_free_bodies_of_the_world_start_at_the_robots_root(tmp_path: Path) -> None:
    for root in ("base", "world"):
        model = build(tmp_path, world_urdf(cube()), rod(root))
        assert [body.parent for body in model.free_bodies] == [root]


def test_the_robots_joints_are_numbered_as_without_a_world(tmp_path: Path) -> None:
    with_world = build(tmp_path, world_urdf(wall("2 0 0"), cube())).mj_model
    without = build_model(rod(), fixed_base=True).mj_model
    assert with_world.joint("hinge").qposadr == without.joint("hinge").qposadr
    assert with_world.nbody == without.nbody + 2


def test_a_link_that_the_robot_has_too_is_one_error_with_the_file(tmp_path: Path) -> None:
    with pytest.raises(InvalidDescriptionError, match=r"world.xml: 'rod' is in the world, and is"):
        build(tmp_path, world_urdf(cube("rod")))


def test_what_nobody_knows_in_a_world_is_told_with_its_line(tmp_path: Path) -> None:
    odd = f"<sponsor/>\n{control(cube_joint='position')}"
    model = build(tmp_path, world_urdf(cube(), "\n", odd))
    assert model.warnings == (
        "world.xml: <sponsor> in <robot> is unknown (line 3)",
        "world.xml: <ros2_control> 'hardware' is left out: models of a world have no "
        "controllers, and move only when pushed",
    )
    xacro = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    looped = world_urdf(cube(), "\n<xacro:if value='1'><sponsor/></xacro:if>")
    told = build(tmp_path, looped.replace("<robot", f"<robot {xacro}")).warnings
    assert told == (f"world.xml: <sponsor> in <robot> is unknown ({tmp_path / 'world.xml'}:3)",)


def test_what_mujoco_refuses_is_told_with_the_file(tmp_path: Path) -> None:
    text = world_urdf('<mujoco><compiler angle="turns"/></mujoco>', cube())
    with pytest.raises(InvalidDescriptionError, match=r"world.xml: "):
        build(tmp_path, text)


def test_meshes_of_a_world_lie_beside_it(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    trimesh.creation.box((2.0, 2.0, 2.0)).export(tmp_path / "meshes" / "b.stl")
    mesh = '<visual><geometry><mesh filename="meshes/b.stl"/></geometry></visual>'
    model = build(tmp_path, world_urdf(link("rock", mesh), wall("2 0 0"),
        joint("rock_joint", "world", "rock", kind="fixed")))  # fmt: skip
    assert model.warnings == ()
    assert model.mj_model.nmesh == 1


def test_a_broken_mesh_of_a_world_costs_that_one_alone(tmp_path: Path) -> None:
    (tmp_path / "b.obj").write_text("f 1 2 3")
    mesh = '<visual><geometry><mesh filename="b.obj"/></geometry></visual>'
    hold = joint("rock_joint", "world", "rock", kind="fixed")
    model = build(tmp_path, world_urdf(link("rock", mesh), hold, wall("2 0 0")))
    (warning,) = model.warnings
    assert warning.startswith("world.xml: Mesh 'b.obj' is left out: ")
    assert len(model.world_geoms) == 2


def test_what_a_world_lacks_is_warned_about_with_its_file(tmp_path: Path) -> None:
    eye = '<gazebo reference="cube"><sensor name="eye" type="imu"/></gazebo>'
    bare = cube().replace(INERTIAL.replace("0 0 0.25", "0 0 0"), "")
    model = build(tmp_path, world_urdf(bare, eye))
    assert model.warnings == (
        "world.xml: Link 'cube' has no mass; it is computed from its shape with a density of "
        "1000 kg/m^3",
        "world.xml: Sensor 'eye' is left out: only robots have sensors",
    )


def test_a_world_that_overlaps_the_robot_touches_it_once_they_have_come_apart(
    tmp_path: Path,
) -> None:
    model = build(tmp_path, world_urdf(wall("0 0 1")))
    assert model.excluded == (("rod", "wall"),)


SCENE = """<mujoco model="scene">
  <compiler angle="degree" meshdir="parts"/>
  <option timestep="0.5" gravity="0 0 -9"/>
  <visual><headlight ambient="1 0 0"/></visual>
  <asset>
    <texture type="skybox" builtin="flat" rgb1="0 0 0" width="8" height="48"/>
    <material name="red" rgba="1 0 0 1"/>
    <mesh name="b" file="b.stl"/>
  </asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom type="box" size="0.1 0.1 0.1" pos="2 0 0.1"/>
    <body name="can" pos="2 0 0.5"><freejoint/>
      <geom type="cylinder" size="0.05 0.1" material="red"/></body>
    <body pos="2 2 1"><freejoint/><geom type="mesh" mesh="b"/>
      <body pos="0 0 1"><geom size="0.1"/></body></body>
  </worldbody>
  <sensor><framepos objtype="body" objname="can"/></sensor>
  <keyframe><key qpos="0 0 0 1 0 0 0 0 0 0 1 0 0 0"/></keyframe>
</mujoco>"""


def test_a_scene_of_mujocos_is_a_world_with_its_own_ground_and_sky(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    trimesh.creation.box((0.2, 0.2, 0.2)).export(tmp_path / "parts" / "b.stl")
    model = build(tmp_path, SCENE)
    m = model.mj_model

    assert [body.link for body in model.free_bodies] == ["can", "object1"]
    assert model.warnings == ("world.xml: 1 sensors are left out",)
    assert list(m.geom_type).count(mujoco.mjtGeom.mjGEOM_PLANE) == 1
    assert list(m.tex_type).count(mujoco.mjtTexture.mjTEXTURE_SKYBOX) == 1
    assert m.opt.gravity[2] == -9.0, "a world says how things fall in it"
    assert m.vis.headlight.ambient[1] > 0.0
    simulation = Simulation(model, control_period_ns=100_000_000)
    simulation.step(2000)
    assert simulation.free_bodies.pose(0)[2] == pytest.approx(0.3, abs=1e-3)
    assert simulation.free_bodies.pose(1)[2] == pytest.approx(0.1, abs=1e-3)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("<mujoco><worldbody>\n<stone/></worldbody></mujoco>", "world.xml: .*stone.*line 2"),
        ("<mujoco><include file='none.xml'/></mujoco>", "world.xml: .*none.xml"),
        (
            "<mujoco><worldbody><geom size='1' pos='1e400 0 0'/></worldbody></mujoco>",
            "world.xml: ",
        ),
    ],
)
def test_a_scene_that_cannot_be_is_one_error_with_the_file(
    tmp_path: Path, scene: str, message: str
) -> None:
    with pytest.raises(InvalidDescriptionError, match=message):
        build(tmp_path, scene)


def test_two_models_of_one_world_are_identical(tmp_path: Path) -> None:
    runs = []
    for _ in range(2):
        model = build(tmp_path, world_urdf(wall("2 0 0.1"), cube("cube", "2.05 0.03 0.5")))
        simulation = Simulation(model, control_period_ns=100_000_000)
        simulation.step(1500)
        runs.append(simulation.free_bodies.pose(0))
    assert np.array_equal(runs[0], runs[1])


def test_a_shape_of_the_scene_itself_that_overlaps_the_robot_is_the_worlds(tmp_path: Path) -> None:
    scene = "<mujoco><worldbody><geom type='box' size='.1 .1 .1' pos='0 0 1'/></worldbody></mujoco>"
    model = build(tmp_path, scene)
    assert model.excluded == (("rod", "world"),)
    simulation = Simulation(model, control_period_ns=100_000_000)
    simulation.step(500)
    assert not simulation.diverged
