"""SDF: worlds and models of Gazebo's, with what is left out told by file and line."""

from __future__ import annotations

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.robot import Joints, Mimic, RobotDescription, Scene, read_model, read_world
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import link, robot

BOX = "<geometry><box><size>0.2 0.2 0.2</size></box></geometry>"
SHAPES = f"<collision name='c'>{BOX}</collision><visual name='v'>{BOX}</visual>"
MASS = (
    "<inertial><mass>2</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>"
    "</inertial>"
)


def scene(folder: Path, content: str, version: str = "1.9") -> Scene:
    file = folder / "world.sdf"
    file.write_text(f"<sdf version='{version}'>\n{content}</sdf>")
    found = read_world(file).scene
    assert found is not None
    return found


def simulated(folder: Path, content: str) -> RobotModel:
    scene(folder, content)
    base = robot(link("base", ""))
    return build_model(base, world=read_world(folder / "world.sdf"), fixed_base=True)


def world(*parts: str) -> str:
    return f"<world name='w'>{''.join(parts)}</world>"


def model(name: str, content: str, pose: str = "0 0 0 0 0 0", static: str = "") -> str:
    return f"<model name='{name}'><pose>{pose}</pose>{static}{content}</model>"


def placed(folder: Path, content: str, body: str, version: str = "1.9") -> list[float]:
    """Where a body of the only model is, in the model."""
    (found,) = scene(folder, world(model("m", content)), version).models
    return [round(value, 9) for value in found.bodies[body].pose.translation]


def test_a_world_falls_stands_and_turns_as_it_is_written(tmp_path: Path) -> None:
    door = (
        f"<link name='frame'>{MASS}</link><link name='leaf'><pose>0 0 1 0 0 0</pose>{MASS}</link>"
        "<joint name='to_world' type='fixed'><parent>world</parent><child>frame</child></joint>"
        "<joint name='hinge' type='revolute'><parent>frame</parent><child>leaf</child>"
        "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1.5</upper></limit></axis></joint>"
    )
    built = simulated(
        tmp_path,
        world(
            "<gravity>0 0 -3.7</gravity>",
            "<include><uri>model://ground_plane</uri></include>",
            "<include><uri>model://sun</uri></include>",
            model("cube", f"<link name='l'>{MASS}{SHAPES}</link>", "3 0 1 0 0 0"),
            model("wall", f"<link name='l'>{SHAPES}</link>", "3 0 0.1 0 0 0", "<static>1</static>"),
            model("door", door, "6 0 0 0 0 0"),
        ),
    )
    simulation = Simulation(built, control_period_ns=10_000_000)
    simulation.step(2500)
    assert [thing.name for thing in built.things] == ["ground_plane", "cube", "wall", "door"]
    assert [body.link for body in built.free_bodies] == ["cube"]
    assert simulation.free_bodies.pose(0)[:3] == pytest.approx([3.0, 0.0, 0.3], abs=1e-3)
    m = built.mj_model
    assert m.opt.gravity[2] == -3.7
    hinge = m.joint("world/door/leaf_hinge")
    assert list(hinge.range) == [-1.0, 1.5]
    assert m.body("cube").mass[0] == 2.0
    assert list(m.geom_type).count(int(mujoco.mjtGeom.mjGEOM_PLANE)) == 2, "felt, and seen"
    assert built.warnings == ()


def test_poses_are_relative_to_what_they_name(tmp_path: Path) -> None:
    turned = f"0 0 0 0 0 {math.pi / 2}"
    content = (
        f"<frame name='f'><pose>1 0 0 {turned[6:]}</pose></frame>"
        "<link name='a'><pose relative_to='f'>2 0 0 0 0 0</pose></link>"
        "<link name='b'><pose relative_to='a'>0 0 3 0 0 0</pose></link>"
        "<link name='c'><pose relative_to='j'>0 1 0 0 0 0</pose></link>"
        "<joint name='j' type='fixed'><pose relative_to='b'>5 0 0 0 0 0</pose>"
        "<parent>b</parent><child>c</child></joint>"
        "<link name='d'><pose degrees='true' relative_to='f'>1 0 0 0 0 90</pose></link>"
        "<link name='e'><pose rotation_format='quat_xyzw'>0 0 7 0 0 0 2</pose></link>"
    )
    assert placed(tmp_path, content, "a") == [1.0, 2.0, 0.0]
    assert placed(tmp_path, content, "b") == [1.0, 2.0, 3.0]
    assert placed(tmp_path, content, "c") == [0.0, 7.0, 3.0]
    assert placed(tmp_path, content, "e") == [0.0, 0.0, 7.0]


def test_models_are_included_from_the_folders_of_gazebo(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shelf = tmp_path / "elsewhere" / "shelf"
    shelf.mkdir(parents=True)
    (shelf / "model.config").write_text(
        "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.6'>new.sdf</sdf></model>"
    )
    inner = model(
        "shelf", f"<link name='board'>{SHAPES}</link>", "0 0 1 0 0 0", "<static>1</static>"
    )
    (shelf / "new.sdf").write_text(f"<sdf version='1.6'>{inner}</sdf>")
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(shelf.parent))
    found = scene(
        tmp_path,
        world(
            "<include><uri>model://shelf</uri></include>",
            "<include><uri>model://shelf</uri><pose>1 0 0 0 0 0</pose></include>",
            model("room", "<include><uri>model://shelf</uri><name>s</name></include>"),
            "\n<include><uri>model://no_such_thing</uri></include>",
        ),
    )
    assert [m.name for m in found.models] == ["shelf", "shelf_1", "room"]
    assert [m.pose.translation for m in found.models[:2]] == [(0, 0, 1), (1, 0, 0)]
    assert list(found.models[2].bodies) == ["s::board"]
    assert found.models[2].static
    (remark,) = found.remarks
    assert re.search(r"world\.sdf:3: <include> is left out: model://no_such_thing is not", remark)


INNER = model(
    "inner", f"<frame name='tip'><pose>0 0 1 0 0 0</pose></frame><link name='l'>{MASS}</link>"
)


def test_the_frame_of_a_model_that_is_to_be_somewhere_is_there(tmp_path: Path) -> None:
    (tmp_path / "inner.sdf").write_text(f"<sdf version='1.9'>{INNER}</sdf>")
    include = (
        "<include><uri>inner.sdf</uri><name>{}</name>"
        "<placement_frame>tip</placement_frame><pose>0 0 5 0 0 0</pose></include>"
    )
    held = INNER.replace("'inner'", "'c' placement_frame='tip'").replace(
        "0 0 0 0 0 0", "0 0 5 0 0 0"
    )
    within = f"<link name='base'/>{include.format('b')}{held}"
    found = scene(tmp_path, world(include.format("a"), model("m", within)))
    first, second = found.models
    assert first.pose.translation == (0.0, 0.0, 4.0)
    assert {name: body.pose.translation for name, body in second.bodies.items()} == {
        "base": (0.0, 0.0, 0.0),
        "b::l": (0.0, 0.0, 4.0),
        "c::l": (0.0, 0.0, 4.0),
    }


def test_poses_in_a_world_are_relative_to_models_and_to_what_is_in_them(tmp_path: Path) -> None:
    (tmp_path / "inner.sdf").write_text(f"<sdf version='1.9'>{INNER}</sdf>")
    found = scene(
        tmp_path,
        world(
            "<light name='lamp'><pose relative_to='a'>0 0 3 0 0 0</pose></light>",
            "<include><uri>inner.sdf</uri><name>a</name><pose>1 0 0 0 0 0</pose></include>",
            "<model name='b'><pose relative_to='a'>0 2 0 0 0 0</pose><link name='l'/></model>",
            "<model name='c'><pose relative_to='a::tip'>0 3 0 0 0 0</pose><link name='l'/></model>",
        ),
    )
    assert [m.pose.translation for m in found.models] == [(1, 0, 0), (1, 2, 0), (1, 3, 1)]
    assert found.lights[0].pose.translation == (1, 0, 3)


@pytest.mark.parametrize(
    ("parent", "child"),
    [("base", "arm"), ("at_base", "arm"), ("base", "at_arm"), ("base", "j2"), ("chain", "arm")],
)
def test_a_joint_is_between_the_links_that_its_frames_are_fixed_to(
    tmp_path: Path, parent: str, child: str
) -> None:
    content = (
        f"<link name='base'>{MASS}</link><link name='arm'><pose>0 0 1 0 0 0</pose>{MASS}</link>"
        f"<link name='hand'>{MASS}</link>"
        "<frame name='at_base' attached_to='base'/><frame name='at_arm' attached_to='arm'/>"
        "<frame name='chain' attached_to='at_base'/>"
        f"<joint name='j' type='revolute'><parent>{parent}</parent><child>{child}</child>"
        "<axis><xyz>0 0 1</xyz></axis></joint>"
        "<joint name='j2' type='fixed'><parent>arm</parent><child>hand</child></joint>"
    )
    (found,) = scene(tmp_path, world(model("m", content))).models
    assert (found.joints[0].parent, found.joints[0].child) == (
        "base",
        "hand" if child == "j2" else "arm",
    )


def test_a_joint_ends_where_its_range_does_on_one_side_too(tmp_path: Path) -> None:
    def hinged(axis: str) -> str:
        return (
            f"<link name='a'>{MASS}</link><link name='b'>{MASS}</link><joint name='j' "
            f"type='revolute'><parent>a</parent><child>b</child>\n<axis>{axis}</axis></joint>"
        )

    one = "<limit><lower>-0.1</lower></limit><dynamics><spring_stiffness>3</spring_stiffness>"
    built = simulated(
        tmp_path,
        world(
            model("one", hinged(f"{one}<spring_reference>1</spring_reference></dynamics>")),
            model(
                "locked", hinged("<limit><lower>0</lower><upper>0</upper></limit>"), "1 0 0 0 0 0"
            ),
            model("odd", hinged("<limit><lower>1</lower><upper>0</upper></limit>"), "2 0 0 0 0 0"),
        ),
    )
    hinges = {name: built.mj_model.joint(f"world/{name}/b_j") for name in ("one", "locked", "odd")}
    assert {name: bool(built.mj_model.jnt_limited[joint.id]) for name, joint in hinges.items()} == {
        "one": True,
        "locked": True,
        "odd": False,
    }
    assert hinges["one"].range[0] == -0.1 and hinges["one"].range[1] > 1000.0
    assert hinges["locked"].range == pytest.approx([0.0, 0.0], abs=1e-6)
    assert built.mj_model.jnt_stiffness[hinges["one"].id].flat[0] == 3.0
    (warning,) = built.warnings
    assert warning.endswith(":5: <limit> is left out: its lower end is above its upper one")

    file = tmp_path / "model.sdf"
    file.write_text(f"<sdf version='1.9'>{model('m', hinged(one + '</dynamics>'))}</sdf>")
    description = RobotDescription.from_urdf(read_model(file).text)
    limits = Joints.of(description)["j"].limits
    assert (limits.lower, limits.effort, limits.velocity) == (-0.1, math.inf, math.inf)
    assert description.repairs == ()
    hinge = build_model(description).mj_model.joint("j")
    assert (hinge.stiffness.flat[0], hinge.qpos_spring[0]) == (3.0, 0.0)


def test_a_follower_and_a_sensor_of_sdf_are_those_of_urdf(tmp_path: Path) -> None:
    content = (
        f"<link name='a'>{MASS}</link><link name='b'><pose>0 0 1 0 0 0</pose>{MASS}"
        "<sensor name='s' type='imu'><pose relative_to='a' degrees='true'>0 0 3 0 0 90</pose>"
        f"</sensor></link><link name='c'><self_collide>false</self_collide>{MASS}</link>"
        "<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis/></joint>"
        "<joint name='k' type='revolute'><parent>a</parent><child>c</child><axis>"
        "<mimic joint='j'><multiplier>2</multiplier><offset>1</offset><reference>3</reference>"
        "</mimic></axis></joint>"
    )
    file = tmp_path / "model.sdf"
    file.write_text(f"<sdf version='1.11'>{model('m', content)}</sdf>")
    description = RobotDescription.from_urdf(read_model(file).text)
    (sensor,) = description.gazebo.sensors
    assert sensor.pose.xyz == pytest.approx((0.0, 0.0, 2.0))
    assert sensor.pose.rpy == pytest.approx((0.0, 0.0, math.pi / 2))
    assert description.joints["k"].mimic == Mimic("j", 2.0, 1.0 - 2.0 * 3.0)
    assert description.gazebo.links["c"].self_collide is False


def test_what_has_no_effect_is_told_unless_it_says_what_is_so(tmp_path: Path) -> None:
    def block(kinematic: str, decay: str, bounce: str, across: str) -> str:
        friction = f"<friction><ode><mu>1</mu><mu2>{across}</mu2></ode></friction>"
        return model(
            "m",
            f"<link name='l'><kinematic>{kinematic}</kinematic>"
            f"<velocity_decay><linear>{decay}</linear></velocity_decay>"
            f"<collision name='c'>{BOX}<surface><soft_contact><dart><stiffness>{bounce}"
            f"</stiffness></dart></soft_contact>{friction}</surface></collision></link>",
        )

    assert scene(tmp_path, world(block("false", "0.0", "0", "1.0"))).remarks == ()
    found = scene(tmp_path, world(block("1", "0.5", "0.9", "0.2")))
    assert [remark.partition(":2: ")[2] for remark in found.remarks] == [
        "<kinematic> has no effect",
        "<velocity_decay/linear> has no effect",
        "<soft_contact> is left out",
        "<mu2> has no effect: friction is <mu> in all directions",
    ]


@pytest.mark.parametrize(
    "include",
    ["<include/>", "<include><uri>https://fuel.gazebosim.org/1.0/x/models/a**b</uri></include>"],
)
def test_an_include_of_nothing_is_told(tmp_path: Path, include: str) -> None:
    (remark,) = scene(tmp_path, world(include), "1.\N{SUPERSCRIPT TWO}").remarks
    assert ":2: <include> is left out: " in remark


def test_models_of_one_name_side_by_side_are_two(tmp_path: Path) -> None:
    chair = model("chair", f"<link name='l'>{MASS}</link>")
    assert [m.name for m in scene(tmp_path, chair * 2).models] == ["chair", "chair_1"]


def test_what_gazebo_lets_pass_is_read_and_told(tmp_path: Path) -> None:
    shapes = "".join(
        f"\n<visual name='{size}'><geometry><box><size>{size}</size></box></geometry></visual>"
        for size in ("1 1 0", "1 1 1")
    )
    room = model("room", f"<link name='l'><pose>1 2 3 0 0 0 9</pose>{shapes}</link>")
    file = tmp_path / "world.sdf"
    file.write_text(f"\n<?xml version='1.0'?>\n<gazebo version='1.2'>{world(room)}</gazebo>")
    found = read_world(file).scene
    assert found is not None
    (body,) = found.models[0].bodies.values()
    assert body.pose.translation == (1.0, 2.0, 3.0)
    assert len(body.shapes) == 1
    assert found.remarks == (
        f"{file}:3: <pose> has 7 numbers: the first 6 count",
        f"{file}:4: <box> is left out: its sizes should be positive numbers",
    )


def test_frames_and_links_in_long_chains_are_found(tmp_path: Path) -> None:
    count = 1200
    content = "".join(
        f"<frame name='f{n}'><pose relative_to='f{n + 1}'>0 0 1 0 0 0</pose></frame>"
        for n in range(count)
    )
    content += f"<frame name='f{count}'/><link name='l'><pose relative_to='f0'/></link>"
    assert placed(tmp_path, content, "l") == [0.0, 0.0, float(count)]


def test_what_nobody_reads_is_told_with_its_lines(tmp_path: Path) -> None:
    found = scene(
        tmp_path,
        world(
            "\n<actor name='walker'/>",
            "<physics><max_step_size>1</max_step_size></physics>",
            "\n<plugin filename='libfancy.so' name='x'/>",
            "<plugin filename='gz-sim-physics-system' name='y'/>",
            model("a", "<link name='l'><visual name='v'><geometry><polyline/></geometry></visual>"),
        ).replace("</visual></model>", "</visual></link></model>"),
    )
    words = [remark.partition("world.sdf:")[2] for remark in found.remarks]
    assert words == [
        "3: <actor> 'walker' is left out",
        "4: <plugin> 'x' (libfancy.so) is left out",
        "4: <polyline> is left out",
        " Without meaning outside of Gazebo's window, drawing and solver: <max_step_size> (line 3)",
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<world name='w'>", ":2: invalid XML"),
        ("<actor/>", ":1: there is neither a world nor a model"),
        (model("m", "<link name='l'><pose>1 2</pose></link>"), ":2: <pose> should be 6 finite"),
        (model("m", "<link name='l'><pose>nan 0 0 0 0 0</pose></link>"), "got 'nan 0"),
        (
            model("m", "<link name='l'><inertial><mass>-3</mass></inertial></link>"),
            ":2: link 'l' has a mass of -3 kg",
        ),
        (
            model("m", "<frame name='a'><pose relative_to='a'/></frame><link name='l'>"
                  "<pose relative_to='a'/></link>"),
            "frame 'a' is, in the end, relative to itself",
        ),
        (model("m", "<link name='l'/>\n<link name='l'/>"), ":3: <link>: name 'l' is given twice"),
        (model("m", "<link/>"), ":2: <link>: it has no name"),
        (
            model("m", "<link name='l'/><joint name='j' type='fixed'><parent>l</parent>"
                  "<child>x</child></joint>"),
            ":2: joint 'j' is at 'x', which is not a link",
        ),
        (world("<include><uri>world.sdf</uri></include>"), ""),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_with_its_place(
    tmp_path: Path, content: str, message: str
) -> None:
    if not message:
        assert "there is no model" in scene(tmp_path, content).remarks[0]
        return
    with pytest.raises(InvalidDescriptionError, match=re.escape(message)):
        simulated(tmp_path, content)


def test_a_file_that_includes_itself_ends(tmp_path: Path) -> None:
    inner = model("m", "<include><uri>loop.sdf</uri></include>")
    (tmp_path / "loop.sdf").write_text(f"<sdf version='1.9'>{inner}</sdf>")
    with pytest.raises(InvalidDescriptionError, match="files include one another"):
        scene(tmp_path, world("<include><uri>loop.sdf</uri></include>"))


def test_what_stands_is_hollow_where_its_mesh_is(tmp_path: Path) -> None:
    trimesh.creation.annulus(r_min=4.0, r_max=5.0, height=4.0, sections=8).export(
        tmp_path / "ring.stl"
    )
    ring = (
        "<collision name='c'><geometry><mesh><uri>ring.stl</uri><scale>0.1 0.1 0.1</scale></mesh>"
        "</geometry><surface><friction><ode><mu>0.3</mu></ode></friction></surface></collision>"
    )
    ball = (
        f"<link name='l'>{MASS}<collision name='c'><geometry><sphere><radius>0.1</radius></sphere>"
        "</geometry></collision></link>"
    )
    built = simulated(
        tmp_path,
        world(
            model("ring", f"<link name='l'>{ring}</link>", "3 0 0.2 0 0 0", "<static>1</static>"),
            model("within", ball, "3 0 0.1 0 0 0"),
            model("above", ball, "3.45 0 0.501 0 0 0"),
        ),
    )
    assert built.warnings == ()
    m = built.mj_model
    data = mujoco.MjData(m)
    mujoco.mj_step(m, data, 500)
    assert data.body("within").xpos == pytest.approx([3.0, 0.0, 0.1], abs=1e-3)
    assert data.body("above").xpos[2] == pytest.approx(0.5, abs=2e-3)
    slabs = [geom for geom in range(m.ngeom) if m.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH]
    assert {m.geom_friction[geom][0] for geom in slabs} == {0.3}


ROVER = model(
    "rover",
    f"<link name='chassis'><pose>0 0 0.1 0 0 0</pose>{MASS}{SHAPES}"
    "<sensor name='eye' type='imu'><pose>0 0 0.3 0 0 0</pose></sensor></link>"
    f"<link name='wheel'><pose>0.3 0.2 0.1 -1.5707963267948966 0 0</pose>{MASS}"
    "<collision name='c'><geometry><cylinder><radius>0.1</radius><length>0.05</length></cylinder>"
    "</geometry><surface><friction><ode><mu>0.7</mu></ode></friction></surface></collision></link>"
    "<joint name='axle' type='revolute'><pose>0 0 0.1 0 0 0</pose><parent>chassis</parent>"
    "<child>wheel</child><axis><xyz>0 0 1</xyz></axis></joint>"
    "\n<gripper/><plugin filename='libx.so' name='x'><left_joint>axle</left_joint></plugin>",
)


def test_a_robot_of_sdf_is_a_robot_of_urdf(tmp_path: Path) -> None:
    file = tmp_path / "model.sdf"
    file.write_text(f"<sdf version='1.8'>{ROVER}</sdf>")
    description = RobotDescription.from_urdf(read_model(file).text)

    assert (description.name, description.root) == ("rover", "chassis")
    axle = description.joints["axle"]
    assert (axle.type, axle.axis) == ("continuous", (0.0, 0.0, 1.0))
    # The wheel's frame is that of its joint, 10 cm along the wheel's own axis.
    assert axle.origin.xyz == pytest.approx((0.3, 0.3, 0.0))
    (sensor,) = description.gazebo.sensors
    assert (sensor.link, sensor.pose.xyz) == ("chassis", (0.0, 0.0, 0.3))
    (plugin,) = description.gazebo.plugins
    assert plugin.parameter("left_joint") == "axle"
    assert description.gazebo.links["wheel"].mu1 == 0.7
    assert description.repairs == (f"{file}:2: <gripper> is left out",)

    built = build_model(description)
    data = mujoco.MjData(built.mj_model)
    mujoco.mj_forward(built.mj_model, data)
    # The wheel's shape is where SDF has it: its centre 20 cm beside the chassis.
    wheel = data.body("wheel").xipos - data.body("chassis").xipos
    assert wheel == pytest.approx([0.3, 0.2, 0.0], abs=1e-9)
    assert np.sum(built.mj_model.body_mass) == pytest.approx(4.0)


def test_what_urdf_has_no_form_for_is_made_or_named(tmp_path: Path) -> None:
    ellipsoid = "<geometry><ellipsoid><radii>0.3 0.2 0.1</radii></ellipsoid></geometry>"
    body = (
        f"<link name='base'>{MASS}<collision name='c'>{ellipsoid}</collision>"
        "\n<visual name='v'><geometry><plane/></geometry></visual></link>"
        f"<link name='caster'>{MASS}<collision name='c'>{BOX}</collision></link>"
        "\n<joint name='roll' type='ball'><parent>base</parent><child>caster</child></joint>"
    )
    file = tmp_path / "model.sdf"
    file.write_text(f"<sdf version='1.8'>{model('m', body)}</sdf>")
    description = RobotDescription.from_urdf(read_model(file).text)

    assert description.repairs == (
        f"{file}:2: the plane of link 'base' is left out: a robot has none, a world may",
        f"{file}:3: the ball joint 'roll' is a fixed one: 'caster' slides without friction "
        "instead of rolling",
    )
    built = build_model(description)
    assert built.warnings == description.repairs, "told once, and nothing besides"
    m = built.mj_model
    mesh = int(m.geom_dataid[m.geom_type == mujoco.mjtGeom.mjGEOM_MESH][0])
    first, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
    corners = m.mesh_vert[first : first + count]
    turned = np.empty_like(corners, dtype=float)
    for corner, there in zip(corners, turned, strict=True):
        mujoco.mju_rotVecQuat(there, corner.astype(float), m.mesh_quat[mesh])
    assert np.abs(turned).max(axis=0) == pytest.approx([0.3, 0.2, 0.1], rel=1e-3)


def test_a_world_is_no_robot(tmp_path: Path) -> None:
    file = tmp_path / "world.sdf"
    file.write_text(f"<sdf version='1.8'>{world(ROVER)}</sdf>")
    with pytest.raises(InvalidDescriptionError, match="it is a world with 1 models, and no robot"):
        read_model(file)


def test_a_world_has_its_place_on_the_earth(tmp_path: Path) -> None:
    place = (
        "<spherical_coordinates><surface_model>EARTH_WGS84</surface_model>"
        "<latitude_deg>47.4</latitude_deg><longitude_deg>8.5</longitude_deg>"
        "<elevation>408</elevation>\n<heading_deg>90</heading_deg></spherical_coordinates>"
    )
    found = scene(tmp_path, world(place))
    assert found.origin == (47.4, 8.5, 408.0)
    (remark,) = found.remarks
    assert remark.endswith("world.sdf:3: <heading_deg> is taken for 0")
    assert scene(tmp_path, world()).origin is None
    with pytest.raises(InvalidDescriptionError, match="<latitude_deg> should be a finite number"):
        scene(tmp_path, world(place.replace("47.4", "north")))


def test_lights_fade_shine_and_are_out_as_they_are_written(tmp_path: Path) -> None:
    fades = (
        "<attenuation><constant>0.5</constant><linear>0.2</linear><quadratic>0.1</quadratic>"
        "</attenuation>"
    )
    found = simulated(
        tmp_path,
        world(
            "<magnetic_field>1e-5 2e-5 3e-5</magnetic_field>",
            f"<light name='a' type='point'>{fades}<specular>0.4 0.5 0.6 1</specular></light>",
            "<light name='out' type='point'><light_on>false</light_on></light>",
        ),
    )
    assert found.warnings == ()
    lights = [n for n in range(found.mj_model.nlight) if found.mj_model.light_type[n] == 2]
    (lamp,) = lights
    assert found.mj_model.light_attenuation[lamp] == pytest.approx([0.5, 0.2, 0.1])
    assert found.mj_model.light_specular[lamp] == pytest.approx([0.4, 0.5, 0.6])
    assert found.mj_model.opt.magnetic == pytest.approx([1e-5, 2e-5, 3e-5])


def test_in_old_worlds_the_solver_has_the_gravity(tmp_path: Path) -> None:
    found = scene(tmp_path, world("<physics><gravity>0 0 -1</gravity></physics>"), "1.4")
    assert found.gravity == (0.0, 0.0, -1.0)
    assert found.remarks == ()


def test_what_stands_there_twice_and_what_is_misspelt_is_told(tmp_path: Path) -> None:
    twice = f"<link name='l'>\n<inertal/><pose>0 0 1 0 0 0</pose>\n<pose/>{SHAPES}</link>"
    found = scene(tmp_path, world(model("m", twice)))
    assert [remark.partition("world.sdf:")[2] for remark in found.remarks] == [
        "3: <inertal> in <link> is unknown (is it inertial?)",
        "4: Of several <pose> side by side the first is used",
    ]


def test_what_is_for_gazebo_alone_is_one_line(tmp_path: Path) -> None:
    window = "\n<gui><fullscreen>1</fullscreen></gui>\n<scene><ambient>1 1 1 1</ambient></scene>"
    dull = "<visual name='v'><cast_shadows>0</cast_shadows><geometry><box/></geometry></visual>"
    found = scene(tmp_path, world(window, model("m", f"<link name='l'>{dull * 3}</link>")))
    (remark,) = found.remarks
    assert remark.endswith(
        "drawing and solver: <gui> (line 3), <scene> (line 4), <cast_shadows> (line 4)"
    )


def test_a_joint_may_have_the_name_of_its_link_as_in_old_files(tmp_path: Path) -> None:
    content = (
        f"<link name='base'>{MASS}</link><link name='wheel'><pose>0 1 0 0 0 0</pose>{MASS}</link>"
        "<joint name='wheel' type='revolute'><pose>0 0 1 0 0 0</pose><parent>base</parent>"
        "<child>wheel</child><axis><xyz>0 1 0</xyz></axis></joint>"
    )
    (found,) = scene(tmp_path, world(model("m", content)), "1.4").models
    assert found.bodies["wheel"].pose.translation == (0.0, 1.0, 0.0)
    assert found.joints[0].pose.translation == (0.0, 1.0, 1.0)
    assert found.joints[0].child == "wheel"


def test_xml_as_gazebo_takes_it_is_read(tmp_path: Path) -> None:
    file = tmp_path / "world.sdf"
    file.write_text(
        "<!-- a -- b -->\n<?xml version='1.0'?>\n<sdf version='1.9'><world name='w'>\n"
        "<acme:tint/><model name='m'><link name='l'/></model></world></sdf>"
    )
    found = read_world(file).scene
    assert found is not None
    assert [one.name for one in found.models] == ["m"]
    assert found.remarks == (f"{file}:4: <acme:tint> in <world> is unknown",)
    file.write_text("<sdf version='1.9'>\n<world name='w'></sdf>")
    with pytest.raises(InvalidDescriptionError, match=r"world\.sdf:2: invalid XML: .*mismatch"):
        read_world(file)


def test_friction_below_zero_holds_whatever_there_is(tmp_path: Path) -> None:
    rough = "<surface><friction><ode><mu>-1</mu><mu2>-1</mu2></ode></friction></surface>"
    shapes = SHAPES.replace("</collision>", f"{rough}</collision>")
    found = simulated(tmp_path, world(model("m", f"<link name='l'>{MASS}{shapes}</link>")))
    assert found.warnings == ()
    assert found.mj_model.geom_friction[:, 0].max() == 1000.0


def test_words_that_mean_nothing_are_told(tmp_path: Path) -> None:
    odd = (
        "<model name='m' canonical_link='x'><pose rotation_format='y'>0 0 1 0 0 0</pose>"
        "<link name='l'/></model>"
    )
    found = scene(tmp_path, world("<physics type='z'/><light name='a' type='w'/>", odd))
    assert [remark.partition("world.sdf:2: ")[2] for remark in found.remarks] == [
        "'type' of <physics> has no effect: MuJoCo simulates",
        "<model> 'm' has no link 'x': its first one is canonical",
        "<pose> has a rotation_format 'y', and is read as euler_rpy",
        "<light> 'a' of the type w is treated as a point",
    ]


def test_a_cone_stands_on_its_base_as_heavy_as_it_is(tmp_path: Path) -> None:
    shape = "<geometry><cone><radius>0.3</radius><length>0.4</length></cone></geometry>"
    inertial = "<inertial auto='true'/>"
    body = f"<link name='base'>{inertial}<collision name='c'>{shape}</collision></link>"
    file = tmp_path / "model.sdf"
    text = f"<model name='m'><pose>1 0 0.2 0 0 0</pose>{body}</model>"
    file.write_text(f"<sdf version='1.11'>{text}</sdf>")
    world = read_world(file)
    assert world.scene is not None
    assert not world.scene.remarks
    built = build_model(
        RobotDescription.from_urdf('<robot name="r"><link name="world"/></robot>'), world=world
    )
    data = mujoco.MjData(built.mj_model)
    mujoco.mj_step(built.mj_model, data, 2000)
    assert data.body("m").xpos == pytest.approx([1.0, 0.0, 0.2], abs=2e-3)
    # A third of its cylinder's; drawn with 24 sides it has 1 % less.
    expected = math.pi * 0.3**2 * 0.4 / 3.0 * 1000.0
    assert built.mj_model.body("m").mass[0] == pytest.approx(expected, rel=0.02)
    robot = RobotDescription.from_urdf(read_model(file).text)
    assert not robot.repairs
