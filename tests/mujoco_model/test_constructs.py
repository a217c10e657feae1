"""What URDF can say, one small robot for each: it loads, is heavy as written, and behaves."""

import logging
import math
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from teleopctl.mujoco_model import RobotModel, build_model, convex, mesh_content
from teleopctl.mujoco_model.convex import decompose_files
from teleopctl.mujoco_model.mesh_content import load_mesh_content
from teleopctl.robot import InvalidMeshError, RobotDescription, simulated, unknown_tags
from teleopctl.sim import Simulation
from teleopctl.testing import LONGEST_WAIT_S
from tests.sim.robots import INERTIAL, box, control, joint, link, robot

WORLD, BASE = link("world", ""), joint("stand", "world", "base", kind="fixed", xyz="0 0 1")
SHAPES = {
    "box": '<box size="0.2 0.2 0.2"/>',
    "sphere": '<sphere radius="0.1"/>',
    "cylinder": '<cylinder radius="0.1" length="0.2"/>',
    "capsule": '<capsule radius="0.1" length="0.2"/>',
}


def collision(shape: str, extra: str = "") -> str:
    return f"<collision>{extra}<geometry>{shape}</geometry></collision>"


def hanging(kind: str, content: str = "", commands: str = "", **options: str) -> RobotModel:
    """A rod of 0.5 kg below one joint, 1 m above the ground."""
    parts = [joint("j", "base", "rod", kind=kind, xyz="0 0 0", content=content, **options)]
    parts += [control(j=commands)] if commands else []
    return build_model(robot(WORLD, link("base"), link("rod"), BASE, *parts))


def after(model: RobotModel, seconds: float = 5.0) -> Simulation:
    """A robot that was left to itself, with all its numbers being some."""
    simulation = Simulation(model, control_period_ns=10_000_000)
    simulation.step_to(round(seconds * 1e9))
    simulation.read()
    _, data = simulation.observe()
    assert not simulation.diverged
    assert np.isfinite([*data.qpos, *data.qvel]).all()
    return simulation


@pytest.mark.parametrize("shape", SHAPES.values(), ids=list(SHAPES))
def test_a_free_body_of_each_shape_comes_to_rest_on_the_ground(shape: str) -> None:
    # Laid a little askew, so that what may roll over does so.
    turned = collision(shape, '<origin rpy="0.1 0 0"/>')
    built = build_model(robot(link("thing", turned + INERTIAL.replace("0 0 0.25", "0 0 0"))))
    _, data = after(built).observe()

    assert built.mj_model.body("thing").mass == pytest.approx(0.5)
    assert 0.09 < data.body("thing").xpos[2] < 0.22
    assert np.abs(data.qvel).max() < 0.05


@pytest.mark.parametrize(
    ("kind", "limit", "ends"),
    [
        ("revolute", 'lower="-2" upper="2" effort="20" velocity="3"', (-2.0, 2.0)),
        ("continuous", 'effort="20" velocity="3"', (-math.inf, math.inf)),
        ("prismatic", 'lower="-0.1" upper="0.1" effort="20" velocity="3"', (-0.1, 0.1)),
    ],
)
def test_a_loose_joint_of_each_kind_stays_within_its_stops(
    kind: str, limit: str, ends: tuple[float, float]
) -> None:
    built = hanging(kind, limit=limit, axis="0 0 1" if kind == "prismatic" else "1 0 0")
    simulation = after(built)

    # Upright on a hinge is an equilibrium; what slides along gravity lies on its stop.
    assert ends[0] - 0.01 <= simulation.positions[0] <= ends[1] + 0.01
    if kind == "prismatic":
        assert simulation.positions[0] == pytest.approx(-0.1, abs=0.005)
    assert sum(built.mj_model.body_mass) == pytest.approx(1.0)


def test_a_planar_joint_is_named_since_nothing_drives_it() -> None:
    built = hanging("planar", limit="", axis="0 0 1")

    assert built.warnings == (
        "Planar joint 'j' moves freely: it has no drive, and its state is not published",
    )
    after(built, 1.0)


def test_a_chain_of_mimics_follows_in_physics() -> None:
    names = ["a", "b", "c"]
    parts = [WORLD, link("base"), BASE]
    for number, name in enumerate(names):
        mimic = f'<mimic joint="{names[number - 1]}" multiplier="-0.5" offset="0.1"/>'
        follows = {"content": mimic if number else "", "axis": "0 0 1", "xyz": f"{number} 0 0"}
        parts += [link(f"link_{name}"), joint(name, "base", f"link_{name}", **follows)]
    simulation = Simulation(
        build_model(robot(*parts, control(a="position"))), control_period_ns=10_000_000
    )
    simulation.apply(["a"], [0.8])
    simulation.step_to(2_000_000_000)
    simulation.read()

    assert simulation.positions == pytest.approx([0.8, -0.3, 0.25], abs=2e-3)


def test_damping_and_friction_bring_a_joint_to_rest() -> None:
    slowed = hanging("continuous", '<dynamics damping="0.5" friction="0.1"/>', limit="")
    simulation = Simulation(slowed, control_period_ns=10_000_000)
    simulation.reset_state({"j": 3.0}, {"j": 2.0})
    simulation.step_to(10_000_000_000)
    simulation.read()

    assert simulation.velocities == pytest.approx([0.0], abs=1e-3)


def test_a_rotor_is_said_or_assumed_and_told() -> None:
    assumed = hanging("revolute", commands="position")
    said = control(j="position").replace(
        '<joint name="j">', '<joint name="j"><param name="armature">0.3</param>'
    )
    rod = joint("j", "base", "rod", xyz="0 0 0")
    given = build_model(robot(WORLD, link("base"), link("rod"), BASE, rod, said))

    assert assumed.assumed_rotors() == {"j": 0.02}
    assert given.assumed_rotors() == {}
    assert given.mj_model.joint("j").armature == pytest.approx(0.3)


def test_every_tag_and_attribute_that_urdf_does_not_have_is_named() -> None:
    strange = (
        '<sponsor/><transmission name="t"/>'
        '<link name="l" weight="3"><visual><geometry><box size="1 1 1"/></geometry><glow/></visual>'
        "</link>"
    )
    urdf = f'<robot name="r">{strange}</robot>'

    assert unknown_tags(urdf) == [
        "<sponsor> in <robot> is unknown (line 1)",
        "<transmission> has no effect: joints are driven as <ros2_control> says (line 1)",
        "Attribute 'weight' of <link> is unknown (line 1)",
        "<glow> in <visual> is unknown (line 1)",
    ]
    assert set(unknown_tags(urdf)) <= set(build_model(RobotDescription.from_urdf(urdf)).warnings)


@pytest.mark.parametrize("file_type", ["stl_ascii", "dae", "glb", "obj"])
def test_a_mesh_of_each_format_is_as_heavy_and_as_large_as_it_is(
    tmp_path: Path, file_type: str
) -> None:
    file = tmp_path / f"part.{file_type.removesuffix('_ascii')}"
    trimesh.creation.box((0.2, 0.4, 0.6)).export(file, file_type=file_type)
    mesh = collision(f'<mesh filename="{file}" scale="0.5 0.5 0.5"/>')
    built = build_model(robot(link("part", mesh)))
    m = built.mj_model

    assert m.body("part").mass == pytest.approx(1000 * 0.1 * 0.2 * 0.3, rel=1e-4)
    assert np.ptp(m.mesh_vert, axis=0) == pytest.approx([0.1, 0.2, 0.3], rel=1e-4)
    assert m.geom_type[m.body("part").geomadr[0]] == mujoco.mjtGeom.mjGEOM_MESH


def test_a_converted_mesh_is_read_once_until_it_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "part.dae"
    trimesh.creation.box((1, 2, 3)).export(file)

    def fail(_path: Path) -> None:
        raise InvalidMeshError("it was read again")

    first = load_mesh_content(file)
    monkeypatch.setattr(mesh_content, "read_mesh", fail)
    second = load_mesh_content(file)
    file.write_text(file.read_text() + "\n")

    assert second.vertices.tolist() == first.vertices.tolist()
    assert second.faces.tolist() == first.faces.tolist()
    assert len(second.parts) == len(first.parts)
    with pytest.raises(InvalidMeshError, match="it was read again"):
        load_mesh_content(file)


def test_a_mesh_that_another_process_is_reading_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "part.dae"
    trimesh.creation.box((1, 2, 3)).export(file)
    kept = mesh_content._kept_at(file)
    content = mesh_content._read(file)
    assert kept is not None
    waits = threading.Event()
    fcntl = pytest.importorskip("fcntl", reason="Windows has no such locks")
    lock = fcntl.flock

    def told(stream: int, how: int) -> None:
        waits.set()
        lock(stream, how)

    with ThreadPoolExecutor() as threads, mesh_content.alone_with(kept):
        monkeypatch.setattr(fcntl, "flock", told)
        monkeypatch.setattr(mesh_content, "_read", lambda path: "it was read twice")
        read = threads.submit(load_mesh_content, file)
        assert waits.wait(LONGEST_WAIT_S)
        mesh_content._keep(kept, content)
    found = read.result(LONGEST_WAIT_S)
    assert found.vertices.tolist() == content.vertices.tolist()
    assert not kept.with_suffix(".lock").exists()


def test_a_visual_alone_touches_nothing() -> None:
    built = build_model(robot(link("ghost", box("visual", "1 1 1") + INERTIAL)))

    assert built.base is not None
    assert not built.base.can_touch


def test_a_planar_joint_slides_down_its_plane_and_turns_in_it() -> None:
    slope = math.radians(30.0)
    normal = f"0 {-math.sin(slope)} {math.cos(slope)}"
    centred = INERTIAL.replace("0 0 0.25", "0 0 0")
    described = robot(
        link("world", ""),
        link("sledge", centred),
        link("arm", centred),
        joint("slope", "world", "sledge", kind="planar", axis=normal, xyz="0 0 2", limit=""),
        joint("turn", "sledge", "arm", kind="continuous", axis=normal, limit=""),
        control(turn="position"),
    )
    urdf, remarks = simulated(described.urdf)
    assert remarks[0] == (
        "The planar joint 'slope' becomes three joints: 'slope_x' and 'slope_y' slide, "
        "'slope_theta' turns"
    )
    built = build_model(RobotDescription.from_urdf(urdf))
    assert built.warnings == ()
    way = 9.81 * math.sin(slope) * 0.5**2 / 2.0
    x, y, z = after(built, 0.5).link_pose("sledge").position
    assert (x, y, z) == pytest.approx(
        (0.0, -way * math.cos(slope), 2.0 - way * math.sin(slope)), abs=2e-3
    )
    states = {
        part.name: [one.name for one in part.state_interfaces]
        for system in RobotDescription.from_urdf(urdf).ros2_control
        for part in system.joints
    }
    assert states["slope_theta"] == ["position", "velocity"]


def sectors(path: Path) -> list[convex.Piece]:
    """A ring around z in twelve convex pieces."""
    corners = trimesh.load_mesh(path).vertices
    around = np.arctan2(corners[:, 1], corners[:, 0])
    pieces = []
    for angle in np.arange(12) * math.tau / 12:
        ahead = (around - angle + 0.1) % math.tau
        hull = trimesh.PointCloud(corners[ahead < math.tau / 12 + 0.2]).convex_hull
        pieces.append((hull.vertices.astype(np.float32), hull.faces.astype(np.int32)))
    return pieces


def test_a_ring_lets_a_ball_through_where_it_can_be_cut(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "ring.stl"
    trimesh.creation.torus(0.3, 0.1, major_sections=12, minor_sections=6).export(file)
    ring = collision(f'<mesh filename="{file}"/>') + INERTIAL
    ball = collision('<sphere radius="0.05"/>') + INERTIAL.replace("0 0 0.25", "0 0 0")
    parts = (
        link("world", ""),
        link("ring", ring),
        joint("held", "world", "ring", kind="fixed", xyz="0 0 1"),
        link("ball", ball),
        joint("loose", "world", "ball", kind="floating", limit="", xyz="0 0 2"),
        '<gazebo reference="ring"><mu1>0.3</mu1></gazebo>',
    )

    monkeypatch.setattr("teleopctl.mujoco_model.assets.can_decompose", lambda: True)
    monkeypatch.setattr("teleopctl.mujoco_model.assets.decompose_files", lambda files: None)
    monkeypatch.setattr(convex, "_cut", sectors)
    cut = build_model(robot(*parts))
    monkeypatch.setattr(convex, "_cut", lambda path: pytest.fail("it was cut again"))
    again = build_model(robot(*parts))
    monkeypatch.setattr("teleopctl.mujoco_model.assets.can_decompose", lambda: False)
    whole = build_model(robot(*parts))

    assert any("is hollow: it collides as" in warning for warning in cut.warnings)
    assert again.warnings == cut.warnings
    of_ring = cut.mj_model.geom_bodyid == cut.mj_model.body("ring").id
    pieces = of_ring & (cut.mj_model.geom_contype > 0)
    assert set(cut.mj_model.geom_friction[pieces, 0]) == {0.3}
    heights = [float(after(one).link_pose("ball").position[2]) for one in (cut, whole)]
    assert heights[0] == pytest.approx(0.05, abs=0.01)
    assert heights[1] > 1.0


def test_programs_that_start_together_cut_a_mesh_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fcntl", reason="there are no file locks")
    file = tmp_path / "ring.stl"
    trimesh.creation.torus(0.3, 0.07, major_sections=12, minor_sections=6).export(file)
    begun, may_end, cuts = threading.Event(), threading.Event(), []

    def cut(path: Path) -> list[convex.Piece]:
        cuts.append(path)
        begun.set()
        assert may_end.wait(LONGEST_WAIT_S)
        return sectors(path)

    monkeypatch.setattr(convex, "_cut", cut)
    with ThreadPoolExecutor() as pool:
        first = pool.submit(convex.convex_pieces, file)
        assert begun.wait(LONGEST_WAIT_S)
        second = pool.submit(convex.convex_pieces, file)
        may_end.set()
        assert len(first.result()) == len(second.result()) == 12
    assert cuts == [file]


def test_a_mesh_that_touches_as_something_larger_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(convex, "can_decompose", lambda: False)
    monkeypatch.setattr("teleopctl.mujoco_model.assets.can_decompose", lambda: False)
    cube = trimesh.creation.box()
    meshes = {
        "ring": trimesh.creation.annulus(r_min=0.4, r_max=0.5, height=1.0),
        "box without a lid": trimesh.Trimesh(cube.vertices, cube.faces[:-2]),
        "sheet": trimesh.Trimesh(cube.vertices, [*cube.faces[:6], *cube.faces[:6, ::-1]]),
        "cube": cube,
        # As CAD leaves them: each face with corners of its own, which do not quite meet.
        "seams": trimesh.Trimesh(
            cube.triangles.reshape(-1, 3) + np.linspace(0.0, 1e-7, 36)[:, None],
            np.arange(36).reshape(-1, 3),
        ),
    }
    told = {}
    for name, mesh in meshes.items():
        file = tmp_path / f"{name.replace(' ', '_')}.stl"
        mesh.export(file)
        built = build_model(robot(link("a", collision(f'<mesh filename="{file}"/>') + INERTIAL)))
        told[name] = " ".join(built.warnings).removeprefix(f"Mesh '{file}' collides as its convex ")
    assert told == {
        "ring": "hull, which has 2.8 times its volume; install teleopctl[decomposition] for "
        "convex pieces",
        "box without a lid": "hull: it is not closed",
        "sheet": "hull: it is not closed",
        "cube": "",
        "seams": "",
    }


def test_a_link_that_does_not_touch_its_robot_goes_through_it() -> None:
    def touching(tag: str) -> int:
        cube = collision('<box size="0.4 0.4 0.4"/>') + INERTIAL
        built = build_model(
            robot(
                WORLD,
                *(link(name, cube) for name in ("base", "middle", "tip")),
                BASE,
                joint("down", "base", "middle", kind="prismatic", axis="0 0 1", xyz="0 0 0.9"),
                joint("up", "middle", "tip", kind="prismatic", axis="0 1 0", xyz="0 0.9 0"),
                f'<gazebo reference="tip"><selfCollide>{tag}</selfCollide></gazebo>',
            )
        )
        assert built.warnings == ()
        data = mujoco.MjData(built.mj_model)
        data.joint("down").qpos[0] = data.joint("up").qpos[0] = -0.9
        mujoco.mj_forward(built.mj_model, data)
        return int(data.ncon)

    assert touching("true") > 0
    assert touching("false") == 0


@pytest.mark.nightly
def test_coacd_cuts_an_angle_into_its_two_legs_and_leaves_a_box_whole(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coacd", reason="the extra 'decomposition' is not installed")
    legs = [trimesh.creation.box((1.0, 0.2, 0.2)), trimesh.creation.box((0.2, 0.2, 1.0))]
    legs[1].apply_translation((0.4, 0.0, 0.6))
    trimesh.util.concatenate(legs).export(tmp_path / "angle.stl")
    legs[0].export(tmp_path / "box.stl")

    with caplog.at_level(logging.WARNING):
        decompose_files([tmp_path / "angle.stl", tmp_path / "box.stl"])
    assert [record.message.partition(":")[0] for record in caplog.records] == [
        "Cutting hollow meshes into convex pieces, up to half a minute for each"
    ]
    assert "angle.stl" in caplog.text and "box.stl" not in caplog.text
    caplog.clear()
    decompose_files([tmp_path / "angle.stl", tmp_path / "box.stl"])
    assert not caplog.records
    monkeypatch.setattr(convex, "_cut", lambda path: pytest.fail("it was not cut ahead"))
    pieces = convex.convex_pieces(tmp_path / "angle.stl")

    hulls = [trimesh.PointCloud(vertices).convex_hull.volume for vertices, _ in pieces]
    # Its hull has 0.14 m^3, twice what it fills itself.
    assert len(pieces) >= 2
    assert 0.07 < sum(hulls) < 0.11
    assert convex.convex_pieces(tmp_path / "box.stl") == []


def test_a_mesh_that_git_lfs_has_not_fetched_is_told(tmp_path: Path) -> None:
    file = tmp_path / "arm.stl"
    file.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n")
    built = build_model(robot(link("a", collision(f'<mesh filename="{file}"/>') + INERTIAL)))
    why = f"{file} is only a Git LFS pointer: `git lfs pull` downloads it"
    assert f"Mesh '{file}' is left out: {why}" in built.warnings
