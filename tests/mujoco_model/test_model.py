"""From robot description to MuJoCo model."""

import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from teleopctl.errors import InvalidDescriptionError, TeleopctlError
from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.sim.simulation import Simulation
from teleopctl.tf.transforms import matrix_from_quaternion
from tests.sim.robots import INERTIAL, box, control, joint, link, model, pendulum, robot

TETRAHEDRON = """v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""


def mesh(kind: str, uri: str) -> str:
    return f'<{kind}><geometry><mesh filename="{uri}" scale="0.1 0.1 0.1"/></geometry></{kind}>'


def names(mj_model, kind: str) -> list[str]:
    count = getattr(mj_model, {"body": "nbody", "joint": "njnt"}[kind])
    return [getattr(mj_model, kind)(index).name for index in range(count)]


def test_links_behind_fixed_joints_keep_their_names() -> None:
    built = model(
        link("base", ""),
        link("rod"),
        link("tool", ""),
        joint("hinge", "base", "rod"),
        joint("weld", "rod", "tool", kind="fixed"),
    )

    assert {"base", "rod", "tool"} <= set(names(built.mj_model, "body"))


def test_a_root_link_named_world_is_the_world() -> None:
    built = model(
        link("world", ""), link("base"), joint("stand", "world", "base", kind="fixed", xyz="0 0 1")
    )

    assert built.mj_model.body("base").pos == pytest.approx([0, 0, 1])
    assert names(built.mj_model, "body").count("world") == 1


def test_visuals_touch_nothing_and_collisions_are_not_drawn() -> None:
    built = model(link("base", box("visual", "1 1 1") + box("collision", "1 1 1") + INERTIAL))

    m = built.mj_model
    base = [g for g in range(m.ngeom) if m.geom_bodyid[g] == m.body("base").id]
    assert [(m.geom_group[g], m.geom_contype[g]) for g in base] == [(1, 0), (3, 1)]


def test_a_link_with_nothing_but_collision_shapes_is_drawn_by_them() -> None:
    m = model(link("base", box("collision", "1 1 1") + INERTIAL)).mj_model

    base = [g for g in range(m.ngeom) if m.geom_bodyid[g] == m.body("base").id]
    assert [(m.geom_group[g], m.geom_contype[g]) for g in base] == [(1, 1)]


def test_meshes_are_found_by_uri(tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    file.write_text(TETRAHEDRON)

    built = model(link("base", mesh("visual", file.as_uri()) + mesh("collision", str(file))))

    assert built.warnings == ()
    assert built.mj_model.nmesh >= 1


def test_a_missing_mesh_costs_one_warning_and_its_geometry() -> None:
    uri = "file:///nowhere/part.stl"
    built = model(link("base", mesh("visual", uri) + mesh("collision", uri) + INERTIAL))

    assert len(built.warnings) == 1
    assert uri in built.warnings[0]
    assert built.mj_model.nmesh == 0


def test_a_mesh_of_an_unknown_package_is_left_out_too() -> None:
    built = model(link("base", mesh("visual", "package://no_such_package/part.stl") + INERTIAL))

    assert "no_such_package" in built.warnings[0]


def test_a_collada_mesh_is_converted(tmp_path: Path) -> None:
    file = tmp_path / "part.dae"
    trimesh.creation.box((1, 2, 3)).export(file)

    assert model(link("base", mesh("visual", str(file)))).mj_model.nmesh == 1


def test_a_collada_mesh_has_the_size_that_its_unit_says(tmp_path: Path) -> None:
    file = tmp_path / "part.dae"
    trimesh.creation.box((100, 200, 300)).export(file)
    text = file.read_text()
    assert "</asset>" in text
    unit = '<unit name="millimeter" meter="0.001"/>'
    text = re.sub("<unit[^>]*/>", "", text)
    # The schema has the unit behind the times.
    file.write_text(re.sub(r"(</modified>)", rf"\1{unit}", text))

    built = model(link("base", mesh("visual", str(file)))).mj_model

    # The tag scales it by 0.1 besides.
    assert np.ptp(built.mesh_vert, axis=0).max() == pytest.approx(0.03, rel=1e-3)


def test_a_moving_link_without_inertia_gets_it_from_its_shape() -> None:
    built = model(
        link("base", ""), link("rod", box("collision", "0.1 0.1 1")), joint("j", "base", "rod")
    )

    assert "'rod' has no mass" in built.warnings[0]
    assert built.mj_model.body("rod").mass[0] == pytest.approx(10.0)


def test_a_moving_frame_without_anything_weighs_next_to_nothing() -> None:
    built = model(link("base", ""), link("dummy", ""), joint("j", "base", "dummy"))

    assert "'dummy'" in built.warnings[0]
    assert 0 < built.mj_model.body("dummy").mass[0] < 0.01


def test_a_massless_link_that_carries_a_heavy_one_is_left_alone() -> None:
    built = model(
        link("base", ""),
        link("frame", ""),
        link("load"),
        joint("j", "base", "frame"),
        joint("weld", "frame", "load", kind="fixed"),
    )

    assert built.warnings == ()


def solid(mass: float, xx: float, yy: float, zz: float, yz: float = 0.0) -> RobotModel:
    inertia = f'ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="{yz}"'
    inertial = f'<inertial><mass value="{mass}"/><inertia {inertia}/></inertial>'
    parts = (link("rod", inertial + box("collision", "0.1 0.1 1")), joint("j", "base", "rod"))
    return model(link("base", ""), *parts)


@pytest.mark.parametrize(
    ("moments", "lowered"),
    [
        ((1.0, 1.0, 4.0), (2.0, 1.0, 1.0)),
        ((1e-4, 1e-4, 2.000001e-4), (2e-4, 1e-4, 1e-4)),
        # Nearly a line: the smallest principal moment is zz - yz^2 / yy.
        ((1.256e-4, 1.256e-4, 1.1091e-10, 1.1787e-7), (1.256e-4, 1.256e-4, 2.9434e-13)),
    ],
)
def test_of_an_impossible_inertia_the_largest_moment_is_lowered_and_that_is_told(
    moments: tuple[float, ...], lowered: tuple[float, ...]
) -> None:
    built = solid(0.068, *moments)
    assert "Link 'rod': no body has the principal moments" in built.warnings[0]
    assert built.mj_model.body("rod").inertia == pytest.approx(lowered, rel=1e-4)


@pytest.mark.parametrize(
    "moments",
    [
        (0.02, 0.02, 0.0),
        # As of a telescope's part: with all its digits the smallest is below 1e-15.
        (1.256e-4, 1.256e-4, 1.1091e-10, 1.180262e-7),
        (1.09e-6, 1.09e-6, -2e-12),
    ],
)
def test_a_rod_whose_smallest_moment_is_lost_in_the_digits_gets_a_small_one(
    moments: tuple[float, ...],
) -> None:
    built = solid(0.068, *moments)
    assert "of which the smallest is raised to" in built.warnings[0]
    expected = (moments[0], moments[1], 1e-5 * moments[0])
    assert built.mj_model.body("rod").inertia == pytest.approx(expected, rel=1e-4)


def test_an_inertia_in_other_units_is_none_and_that_is_told() -> None:
    built = solid(0.158, 6.9e4, 7.9e4, 4.2e4)
    assert (
        "are those of 0.158 kg 707 m from its centre; the units may be wrong" in built.warnings[0]
    )
    assert max(built.mj_model.body("rod").inertia) < 1e-3


def test_a_thin_disk_is_a_body_and_nothing_is_told() -> None:
    assert solid(1.0, 1e-4, 1e-4, 2e-4).warnings == ()


@pytest.mark.parametrize("mass", [0.0, -1.0])
def test_a_moving_link_whose_mass_is_none_gets_that_of_its_shape(mass: float) -> None:
    built = solid(mass, 0.01, 0.01, 0.01)
    assert "Link 'rod' has no mass; it is computed from its shape" in " ".join(built.warnings)
    assert built.mj_model.body("rod").mass[0] == pytest.approx(10.0)


def test_two_cameras_of_one_name_are_two_cameras() -> None:
    eye = """<gazebo reference="{}"><sensor name="eye" type="camera"><camera name="eye">
      <horizontal_fov>1</horizontal_fov><image><width>8</width><height>8</height></image>
      </camera></sensor></gazebo>"""
    built = model(link("base", ""), eye.format("base"), eye.format("base"))
    assert [camera.name for camera in built.cameras] == ["eye", "base/eye"]
    assert built.warnings == ("Two cameras are named 'eye': one is renamed to 'base/eye'",)


def test_a_zero_inertia_is_replaced_and_told() -> None:
    inertial = """<inertial><mass value="1"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>"""
    built = model(link("base", ""), link("rod", inertial), joint("j", "base", "rod"))

    assert "must be positive" in built.warnings[0]
    assert (built.mj_model.body("rod").inertia > 0).all()


def test_neighbours_do_not_touch_but_others_do() -> None:
    shape = box("collision", "0.2 0.2 0.6", "0 0 0.25") + INERTIAL
    built = model(
        link("base", shape),
        link("a", shape),
        link("b", shape),
        link("c", shape),
        joint("ja", "base", "a"),
        joint("jb", "a", "b"),
        joint("jc", "base", "c", xyz="1 0 0"),
    )
    m = built.mj_model
    pairs = {
        (m.exclude_signature[i] >> 16, m.exclude_signature[i] & 0xFFFF) for i in range(m.nexclude)
    }

    def excluded(first: str, second: str) -> bool:
        one, two = m.body(first).id, m.body(second).id
        return (one, two) in pairs or (two, one) in pairs

    assert excluded("base", "a") and excluded("a", "b") and excluded("base", "c")
    assert not excluded("a", "c") and not excluded("base", "b")


CRATE = """<link name="crate"><inertial><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>"""


def floating(child: str, xyz: str, parent: str = "world") -> str:
    return joint(f"{child}_joint", parent, child, kind="floating", limit="", xyz=xyz)


def test_a_free_object_touches_what_it_stands_in_and_that_is_told() -> None:
    table = link("world", box("collision", "1 1 0.2", "0 0 0.5"))
    robot = model(table, CRATE, floating("crate", "0 0 0.69"))

    assert robot.excluded == ()
    assert robot.mj_model.nexclude == 0
    simulation = Simulation(robot, control_period_ns=10_000_000)
    simulation.step(2000)
    assert simulation.link_pose("crate").position[2] == pytest.approx(0.7, abs=2e-3)


def test_a_free_object_that_overlaps_a_link_is_pushed_out_of_it_and_that_is_told() -> None:
    post = link("post", box("collision", "0.2 0.2 1", "0 0 0.5"))
    fixed = joint("stand", "world", "post", kind="fixed", xyz="0 0 0")
    robot = model(link("world", ""), post, fixed, CRATE, floating("crate", "0.19 0 0.1"))

    assert robot.warnings == (
        "'crate' and 'post' overlap at the start by 10.0 mm: they are pushed apart",
    )
    simulation = Simulation(robot, control_period_ns=10_000_000)
    simulation.step(2000)
    assert simulation.link_pose("crate").position[0] > 0.199
    touching = (link("world", ""), post, fixed, CRATE, floating("crate", "0.19999 0 0.1"))
    assert model(*touching).warnings == ()


def test_what_moves_freely_starts_at_the_world() -> None:
    with pytest.raises(InvalidDescriptionError, match="'crate_joint' is floating but starts at"):
        model(link("base", ""), CRATE, floating("crate", "0 0 1", parent="base"))


def test_links_that_overlap_at_the_start_may_pass_through_each_other() -> None:
    shape = box("collision", "0.2 0.2 0.6") + INERTIAL
    built = model(
        link("base", ""),
        link("left", shape),
        link("right", shape),
        joint("jl", "base", "left", xyz="0 0 1"),
        joint("jr", "base", "right", xyz="0.1 0 1"),
    )

    assert built.excluded == (("left", "right"),)


@pytest.mark.parametrize("form", ["urdf", "ros2_control"])
def test_a_mimic_joint_is_held_by_a_constraint_in_either_form(form: str) -> None:
    urdf = '<mimic joint="lead" multiplier="-2" offset="0.5"/>' if form == "urdf" else ""
    parameters = (
        ""
        if form == "urdf"
        else '<param name="mimic">lead</param><param name="multiplier">-2</param>'
    )
    tag = f"""<ros2_control name="h" type="system"><hardware><plugin>x/Y</plugin></hardware>
      <joint name="lead"><command_interface name="position"/></joint>
      <joint name="follow">{parameters}<state_interface name="position"/></joint></ros2_control>"""
    built = model(
        link("base", ""),
        link("a"),
        link("b"),
        joint("lead", "base", "a"),
        joint("follow", "base", "b", content=urdf),
        tag,
    )

    m = built.mj_model
    assert m.neq == 1
    assert (m.joint(m.eq_obj1id[0]).name, m.joint(m.eq_obj2id[0]).name) == ("follow", "lead")
    offset = 0.5 if form == "urdf" else 0.0
    assert m.eq_data[0][:3] == pytest.approx([offset, -2.0, 0.0])


def test_a_camera_looks_along_the_x_axis_of_its_link_with_z_up() -> None:
    sensor = """<gazebo reference="eye"><sensor name="s" type="camera">
      <pose>0.1 0 0 0 0.5 0</pose><update_rate>15</update_rate>
      <camera name="front"><horizontal_fov>1.2</horizontal_fov>
      <image><width>400</width><height>200</height></image></camera>
      <plugin name="p" filename="libgazebo_ros_camera.so"><frame_name>eye_frame</frame_name>
      </plugin></sensor></gazebo>"""
    built = model(
        link("base", ""),
        link("eye", ""),
        joint("mount", "base", "eye", kind="fixed", xyz="1 2 3"),
        sensor,
    )

    camera = built.camera("front")
    assert (camera.frame_id, camera.rate_hz, camera.width) == ("eye_frame", 15.0, 400)
    data = mujoco.MjData(built.mj_model)
    mujoco.mj_forward(built.mj_model, data)
    assert data.cam("front").xpos == pytest.approx([1.1, 2, 3])
    axes = data.cam("front").xmat.reshape(3, 3)
    # Pitched down by 0.5 rad: forward is MuJoCo's -z, right its x, up its y.
    assert -axes[:, 2] == pytest.approx([np.cos(0.5), 0, -np.sin(0.5)])
    assert axes[:, 0] == pytest.approx([0, -1, 0])
    assert axes[:, 1] == pytest.approx([np.sin(0.5), 0, np.cos(0.5)])
    # The optical frame of ROS: z forward, x right, y down. The link is not turned in the world.
    optical = np.array(matrix_from_quaternion(camera.optical_rotation))
    assert optical == pytest.approx(np.column_stack([axes[:, 0], -axes[:, 1], -axes[:, 2]]))
    half_height = np.tan(0.6) / 2
    assert np.radians(built.mj_model.cam_fovy[0]) == pytest.approx(2 * np.arctan(half_height))


def test_an_unknown_camera_is_named_with_those_there_are() -> None:
    with pytest.raises(TeleopctlError, match="no camera 'side'"):
        pendulum().camera("side")


def test_friction_and_colour_come_from_the_gazebo_tag() -> None:
    built = model(
        link("base", box("visual", "1 1 1") + box("collision", "1 1 1")),
        '<gazebo reference="base"><material>Gazebo/Orange</material><mu1>0.3</mu1></gazebo>',
    )

    m = built.mj_model
    geoms = [g for g in range(m.ngeom) if m.geom_bodyid[g] == m.body("base").id]
    assert m.geom_friction[geoms[1]][0] == pytest.approx(0.3)
    assert m.geom_rgba[geoms[0]][:3] == pytest.approx([0.95, 0.45, 0.05], abs=1e-6)


def test_limits_of_zero_stand_for_none() -> None:
    built = pendulum(limit='lower="0" upper="0" effort="0" velocity="0"')

    limits = built.joints[0].limits
    assert np.isinf([limits.lower, limits.upper, limits.effort, limits.velocity]).all()


def bounded(name: str, low: str, high: str) -> str:
    return (
        f'<command_interface name="{name}"><param name="min">{low}</param>'
        f'<param name="max">{high}</param></command_interface>'
    )


def hinge(inside: str, limit: str = 'lower="-2" upper="2" effort="20" velocity="3"') -> Any:
    tag = f"""<ros2_control name="h" type="system"><hardware><plugin>x/Y</plugin></hardware>
      <joint name="hinge">{inside}</joint></ros2_control>"""
    return model(
        link("base", ""), link("rod"), joint("hinge", "base", "rod", limit=limit), tag
    ).mj_model


def test_of_the_bounds_of_command_interfaces_only_that_of_effort_limits_the_drive() -> None:
    m = hinge(
        bounded("position", "-1", "9")
        + bounded("velocity", "-2", "2")
        + bounded("effort", "-5", "5")
    )

    drive = m.actuator("hinge_drive")
    assert drive.actrange == pytest.approx([-2, 2])
    assert not m.actuator_ctrllimited[drive.id]
    assert m.joint("hinge").range == pytest.approx([-2, 2])
    assert m.jnt_actfrcrange[m.joint("hinge").id] == pytest.approx([-5, 5])


def test_limits_that_are_switched_off_leave_neither_drive_nor_stops_nor_effort_limited() -> None:
    m = hinge('<limits enable="false"/>' + bounded("position", "-1", "1"))

    drive = m.actuator("hinge_drive").id
    assert not m.actuator_actlimited[drive] and not m.actuator_ctrllimited[drive]
    assert not m.jnt_limited[m.joint("hinge").id] and not m.jnt_actfrclimited[m.joint("hinge").id]


def test_a_joint_whose_limits_are_one_position_can_be_simulated() -> None:
    m = hinge(bounded("position", "-1", "1"), 'lower="0.5" upper="0.5" effort="1" velocity="1"')

    assert m.actuator("hinge_drive").actrange == pytest.approx([0.5, 0.5])
    assert m.joint("hinge").range == pytest.approx([0.5, 0.5])


def test_a_command_interface_that_physics_cannot_offer_is_told() -> None:
    assert "'hinge/stiffness'" in pendulum("position stiffness").warnings[0]


def test_the_ground_gets_out_of_the_way_of_a_link_of_its_name() -> None:
    assert {"ground_plane", "ground_plane_"} <= set(
        names(model(link("ground_plane", "")).mj_model, "body")
    )


def test_the_same_description_gives_the_same_model() -> None:
    description = robot(
        link("base", ""), link("rod"), joint("j", "base", "rod"), control(j="position")
    )

    sizes, contents = zip(
        *(
            (mujoco.mj_sizeModel(built.mj_model), built.mj_model.actuator_gainprm.tobytes())
            for built in (build_model(description), build_model(description))
        ),
        strict=True,
    )
    assert sizes[0] == sizes[1] and contents[0] == contents[1]


def test_what_mujoco_refuses_is_one_error() -> None:
    with pytest.raises(TeleopctlError, match="cannot be simulated"):
        model(link("base", ""), '<mujoco><option cone="none"/></mujoco>')


@pytest.mark.nightly
def test_a_robot_of_800_links_that_overlap_is_built_in_one_go() -> None:
    # Its contacts before the overlaps are known would need 88 MB of forces.
    shape = INERTIAL + box("collision", "0.05 0.05 0.05")
    links = [link(f"l{i}", shape) for i in range(800)]
    joints = [joint(f"j{i}", f"l{i - 1}", f"l{i}", xyz="0.02 0 0") for i in range(1, 800)]

    built = model(*links, *joints)

    assert len(built.joints) == 799
    assert ("l0", "l2") in built.excluded or ("l2", "l0") in built.excluded


@pytest.mark.parametrize(
    ("tag", "frame"),
    [
        ("", "eye_optical"),
        ("<frame_id>eye</frame_id>", "eye_optical"),
        ("<frame_id>lens</frame_id>", "lens"),
    ],
)
def test_images_are_in_the_optical_frame(tag: str, frame: str) -> None:
    camera = "<camera><horizontal_fov>1</horizontal_fov><image><width>8</width><height>8</height>"
    sensor = f"<sensor name='e' type='camera'>{tag}{camera}</image></camera></sensor>"
    built = model(link("eye", ""), f'<gazebo reference="eye">{sensor}</gazebo>')

    assert built.cameras[0].frame_id == frame


@pytest.mark.parametrize(
    ("tag", "links", "frame"),
    [
        ("", {"eye_optical_link": "-1.57 0 -1.57"}, "eye_optical_link"),
        ("<gz_frame_id>lens</gz_frame_id>", {"lens": "-1.5708 0 -1.5708"}, "lens"),
        ("<gz_frame_id>body</gz_frame_id>", {"body": "0 0 0"}, "eye_optical"),
        (
            "<gz_frame_id>body</gz_frame_id>",
            {"body": "0 0 0", "rgb_optical": "-1.57 0 -1.57", "odd_optical": "0 0 0"},
            "rgb_optical",
        ),
        ("<optical_frame_id>body</optical_frame_id>", {"body": "0 0 0"}, "body"),
        # A link that is turned otherwise has the name that would be ours.
        ("", {"eye_optical": "0 0 0"}, "e_optical"),
    ],
)
def test_images_are_in_a_frame_that_is_turned_as_they_are(
    tag: str, links: dict[str, str], frame: str
) -> None:
    camera = "<camera><horizontal_fov>1</horizontal_fov><image><width>8</width><height>8</height>"
    sensor = f"<sensor name='e' type='camera'>{tag}{camera}</image></camera></sensor>"
    frames = "".join(
        link(name, "")
        + f'''<joint name="to_{name}" type="fixed"><parent link="eye"/>
          <child link="{name}"/><origin rpy="{rpy}"/></joint>'''
        for name, rpy in links.items()
    )
    built = model(link("eye", ""), frames, f'<gazebo reference="eye">{sensor}</gazebo>')

    assert built.cameras[0].frame_id == frame
    told = "The frame 'body' of camera 'e' has another orientation than the camera: its "
    told += "images are in "
    ignored = "gz_frame_id" in tag and "body" in tag
    assert built.warnings == ((f"{told}'{frame}'",) if ignored else ())


def test_each_camera_has_a_frame_where_it_stands() -> None:
    """One of a pair has an optical link; the others stand on the same link elsewhere."""
    camera = "<camera><horizontal_fov>1</horizontal_fov><image><width>8</width><height>8</height>"
    sensors = "".join(
        f"<sensor name='{name}' type='camera'><pose>0 {y} 0 0 0 0</pose>{camera}</image></camera>"
        "</sensor>"
        for name, y in (("left", 0.1), ("middle", 0), ("right", -0.1))
    )
    optical = """<joint name="to_optical" type="fixed"><parent link="eye"/>
      <child link="left_optical"/><origin xyz="0 0.1 0" rpy="-1.5708 0 -1.5708"/></joint>"""
    parts = (link("eye", ""), link("left_optical", ""), optical)
    built = model(*parts, f'<gazebo reference="eye">{sensors}</gazebo>')

    frames = {camera.name: camera.frame_id for camera in built.cameras}
    assert frames == {"left": "left_optical", "middle": "eye_optical", "right": "right_optical"}
