"""Every kind of shape, in the picture and in simulation, with a broken and an absurd file each."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model.model import build_model
from teleopctl.robot import RobotDescription
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN
from tests.samples import sample
from tests.viewer.absurd.mesh_samples import KINDS, TRIANGLES, Files, binary_stl
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import Draw, Picture, look, put_frame

WHOLE, PART, NOTHING = "whole", "part", "nothing"

INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


@dataclass
class Seen:
    """What became of a mesh.

    Attributes:
        shown: Whether it is there.
        told: What is said of it, each time that something is.
        neighbour: Whether the shape beside it is there.
    """

    shown: bool
    told: list[str]
    neighbour: bool

    @property
    def outcome(self) -> str:
        """Whether the whole of it is there, or a part, or nothing."""
        if not self.shown:
            return NOTHING
        return PART if self.told else WHOLE


def urdf(shape: str, tag: str = "visual") -> str:
    """A shape on a link, and a box beside it."""
    box = '<box size="1 1 1"/>'
    content = "".join(f"<{tag}><geometry>{one}</geometry></{tag}>" for one in (shape, box))
    return f'<robot name="r"><link name="a">{INERTIAL}{content}</link></robot>'


def mesh_tag(uri: str, scale: str) -> str:
    escaped_html = uri.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return f'<mesh filename="{escaped_html}" scale="{scale}"/>'


Place = Callable[[str, str], Seen]


@pytest.fixture
def robot_model(draw: Draw, stage: FakePage, picture: Picture) -> Callable[[str], Seen]:
    """Draws a description with the display RobotModel."""
    put_frame(stage, "a", "map", Transform())

    def see(description: str) -> Seen:
        display = draw("RobotModel", **{"Description Topic": {"Value": "/it"}})
        stage.frames.update()
        stage.publish("/it", get_message("std_msgs/msg/String")(data=description))
        told = list(stage.node.warnings)
        # The display says the same as the log.
        assert display.status == ((WARN, "; ".join(told)) if told else (OK, ""))
        names = picture.nodes("/frames/a")
        page_remove(stage, display)
        shown, neighbour = "visual0", "visual1"
        return Seen(
            any(name.endswith(shown) for name in names),
            told,
            any(name.endswith(neighbour) for name in names),
        )

    return see


def page_remove(page: FakePage, display: Any) -> None:
    page.remove_display(display)
    page.node.warnings.clear()


@pytest.fixture
def marker(draw: Draw, stage: FakePage, picture: Picture) -> Callable[..., Seen]:
    """Draws a mesh with the display MarkerArray."""
    kind = get_message("visualization_msgs/msg/Marker")

    def see(uri: str, scale: str, *, own_materials: bool = False) -> Seen:
        display = draw("MarkerArray")
        shape, box = (kind(type=each, id=each) for each in (kind.MESH_RESOURCE, kind.CUBE))
        for one in (shape, box):
            one.header.frame_id = "map"
            one.color.r = one.color.a = 1.0
            one.scale.x = one.scale.y = one.scale.z = 1.0
        shape.mesh_resource, shape.mesh_use_embedded_materials = uri, own_materials
        if own_materials:
            shape.color.r = shape.color.a = 0.0
        shape.scale.x, shape.scale.y, shape.scale.z = map(float, scale.split())
        stage.publish(
            "/it", get_message("visualization_msgs/msg/MarkerArray")(markers=[shape, box])
        )
        look(stage)
        assert not stage.node.warnings
        level, text = display.status
        assert (level == OK) == (not text)
        nodes = picture.nodes(display.root)
        page_remove(stage, display)
        box = nodes.pop("box", None)
        shown = any(node.batched_scales.all() for node in nodes.values())
        return Seen(shown, [text] if text else [], box is not None)

    return see


def simulated(description: str) -> Seen:
    """Builds the model that is simulated."""
    built = build_model(RobotDescription.from_urdf(description))
    count = built.mj_model.ngeom - 1  # without the ground
    return Seen(count == 2, list(built.warnings), count >= 1)


# Markers read their files by the function that the robot's display reads them with.
MARKERS = ("marker", "marker in its own materials")


@pytest.fixture(
    params=["robot", "simulation", *(pytest.param(m, marks=pytest.mark.nightly) for m in MARKERS)]
)
def place(
    request: pytest.FixtureRequest, robot_model: Callable[[str], Seen], marker: Callable[..., Seen]
) -> Place:
    """Where a mesh is to be seen."""

    def in_simulation(uri: str, scale: str) -> Seen:
        return simulated(urdf(mesh_tag(uri, scale)))

    places: dict[str, Place] = {
        "robot": lambda uri, scale: robot_model(urdf(mesh_tag(uri, scale))),
        "marker": marker,
        "marker in its own materials": lambda uri, scale: marker(uri, scale, own_materials=True),
        "simulation": in_simulation,
    }
    return places[request.param]


def is_simulation(request: pytest.FixtureRequest) -> bool:
    return "simulation" in request.node.callspec.params.values()


def store(folder: Path, files: Files) -> Path:
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder / next(iter(files))


def check(seen: Seen, outcome: str, name: str) -> None:
    assert seen.neighbour
    assert seen.outcome == outcome, seen.told
    assert len(seen.told) == (outcome != WHOLE)
    assert all(name in text for text in seen.told)


# --- what a file holds -------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_of_each_kind_is_shown_whole(place: Place, tmp_path: Path, kind: str) -> None:
    path = store(tmp_path, KINDS[kind].good())
    check(place(str(path), "1 1 1"), WHOLE, path.name)


@pytest.mark.parametrize(
    "content", [b"", b"nonsense " * 30, b"\0" * 300], ids=["", "text", "zeros"]
)
@pytest.mark.parametrize("kind", sample(KINDS, 3))
def test_of_a_file_that_is_none_the_name_is_told(
    place: Place, tmp_path: Path, kind: str, content: bytes
) -> None:
    path = store(tmp_path, KINDS[kind].good())
    path.write_bytes(content)
    check(place(str(path), "1 1 1"), NOTHING, path.name)


@pytest.mark.parametrize("kind", KINDS)
def test_of_half_a_file_whole_triangles_are_drawn_and_none_simulated(
    place: Place, tmp_path: Path, kind: str, request: pytest.FixtureRequest
) -> None:
    path = store(tmp_path, KINDS[kind].good())
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    outcome = NOTHING
    if kind in ("text STL", "binary STL"):
        outcome = PART
    elif is_simulation(request) and kind.startswith("OBJ"):
        # MuJoCo takes corners without faces for those of their hull.
        outcome = WHOLE
    check(place(str(path), "1 1 1"), outcome, path.name)


# Of the others trimesh reads no file with such a number, but for COLLADA's, of which it makes 0.
READ_WITHOUT_CORNER = ("text STL", "binary STL", "OBJ with a texture", "GLB", "binary PLY")


@pytest.mark.parametrize("kind", KINDS)
def test_a_corner_that_is_no_number_costs_its_triangles(
    place: Place, tmp_path: Path, kind: str
) -> None:
    path = store(tmp_path, KINDS[kind].good())
    path.write_bytes(KINDS[kind].spoil(path.read_bytes()))
    outcome = NOTHING
    if kind.startswith("COLLADA"):
        outcome = WHOLE
    elif kind in READ_WITHOUT_CORNER:
        outcome = PART
    check(place(str(path), "1 1 1"), outcome, path.name)


@pytest.mark.parametrize("kind", ["OBJ with a texture", "COLLADA with a texture"])
@pytest.mark.parametrize("picture_file", [None, b"", b"nonsense"], ids=["gone", "empty", "text"])
def test_a_texture_that_is_none_costs_the_texture(
    robot_model: Callable[[str], Seen], tmp_path: Path, kind: str, picture_file: bytes | None
) -> None:
    path = store(tmp_path, KINDS[kind].good())
    if picture_file is None:
        (tmp_path / "skin.png").unlink()
    else:
        (tmp_path / "skin.png").write_bytes(picture_file)
    description = urdf(mesh_tag(str(path), "1 1 1"))
    seen = robot_model(description)
    check(seen, PART, path.name)
    assert "skin.png" in seen.told[0]
    check(simulated(description), PART, path.name)


@pytest.mark.parametrize(
    ("kind", "gone", "outcome"),
    [("OBJ with a texture", "paint.mtl", PART), ("glTF", "numbers.bin", NOTHING)],
)
def test_a_file_beside_the_mesh_that_is_gone_is_named(
    robot_model: Callable[[str], Seen], tmp_path: Path, kind: str, gone: str, outcome: str
) -> None:
    path = store(tmp_path, KINDS[kind].good())
    (tmp_path / gone).unlink()
    seen = robot_model(urdf(mesh_tag(str(path), "1 1 1")))
    check(seen, outcome, path.name)
    assert gone in seen.told[0]


def test_triangles_that_are_claimed_take_no_memory(place: Place, tmp_path: Path) -> None:
    path = tmp_path / "claims.stl"
    path.write_bytes(binary_stl(TRIANGLES[:0], claimed=5_000_000) + b"\0" * 16)
    check(place(str(path), "1 1 1"), NOTHING, path.name)


def test_an_obj_whose_faces_name_no_corner_is_told(place: Place, tmp_path: Path) -> None:
    path = tmp_path / "faces.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n")
    check(place(str(path), "1 1 1"), NOTHING, path.name)


# --- scale -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scale", "drawn", "is_simulated"),
    [
        ("0 0 0", NOTHING, NOTHING),
        ("-1 1 1", WHOLE, WHOLE),
        ("0.001 -0.001 0.001", WHOLE, WHOLE),
        ("1e30 1e30 1e30", NOTHING, WHOLE),
    ],
)
@pytest.mark.parametrize("kind", sample(KINDS, 3))
def test_a_scale_may_mirror_a_mesh_and_not_lose_it_unsaid(
    place: Place,
    tmp_path: Path,
    kind: str,
    scale: str,
    drawn: str,
    is_simulated: str,
    request: pytest.FixtureRequest,
) -> None:
    path = store(tmp_path, KINDS[kind].good())
    seen = place(str(path), scale)
    assert seen.neighbour
    assert seen.outcome == (is_simulated if is_simulation(request) else drawn), seen.told
    assert len(seen.told) == (seen.outcome != WHOLE)


# --- where a file is ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a b.stl", "100%.stl", "50%41.stl", "Körper—机.stl", "a#b?c.stl"])
@pytest.mark.parametrize("as_uri", [False, True])
def test_a_file_may_have_any_name(place: Place, tmp_path: Path, name: str, as_uri: bool) -> None:
    path = store(tmp_path, {name: binary_stl(TRIANGLES)})
    check(place(path.as_uri() if as_uri else str(path), "1 1 1"), WHOLE, name)


def a_directory(path: Path) -> None:
    path.mkdir()


def a_loop(path: Path) -> None:
    path.symlink_to(path)


def unreadable(path: Path) -> None:
    path.write_bytes(binary_stl(TRIANGLES))
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("everything is readable for this user")


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


def nothing(path: Path) -> None:
    del path


@pytest.mark.parametrize("put", [nothing, a_directory, a_loop, unreadable, a_pipe])
@pytest.mark.parametrize("suffix", sample(["stl", "obj", "dae", "glb", "gltf", "ply"], 3))
def test_what_is_no_file_is_named(
    place: Place, tmp_path: Path, suffix: str, put: Callable[[Path], None]
) -> None:
    path = tmp_path / f"odd.{suffix}"
    put(path)
    check(place(f"file://{path}", "1 1 1"), NOTHING, path.name)


@pytest.mark.parametrize(
    "uri",
    [
        "http://somewhere.example/odd.stl",
        "model://robot/odd.stl",
        "package://nobody_has_this/odd.stl",
        "package:///odd.stl",
        "://odd.stl",
        "~nobody_of_that_name/odd.stl",
        "odd.stl/" + "x" * 300,
        "odd.stl/" * 2000,
        "file://odd.stl\t",
        "odd.xyz",
    ],
)
def test_an_address_that_leads_nowhere_is_named(place: Place, uri: str) -> None:
    check(place(uri, "1 1 1"), NOTHING, "odd.")


# --- shapes without a file ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("good", "absurd"),
    [
        ('<box size="1 2 3"/>', '<box size="{0} 2 3"/>'),
        ('<sphere radius="1"/>', '<sphere radius="{0}"/>'),
        ('<cylinder radius="1" length="2"/>', '<cylinder radius="{0}" length="2"/>'),
        ('<cylinder radius="1" length="2"/>', '<cylinder radius="1" length="{0}"/>'),
        ('<capsule radius="1" length="2"/>', '<capsule radius="{0}" length="2"/>'),
    ],
)
@pytest.mark.parametrize("size", ["0", "-1", "-0.0"])
def test_a_shape_of_an_impossible_size_is_left_out_and_its_link_named(
    robot_model: Callable[[str], Seen], good: str, absurd: str, size: str
) -> None:
    for see in (robot_model, simulated):
        check(see(urdf(good)), WHOLE, "")
        check(see(urdf(absurd.format(size))), NOTHING, "link 'a'")


@pytest.mark.parametrize(
    "shape",
    [
        '<box size="nan 1 1"/>',
        '<sphere radius="inf"/>',
        "<box/>",
        "<cone/>",
        '<mesh scale="x"/>',
        "",
    ],
)
def test_a_shape_that_says_nothing_is_left_out_and_its_link_named(
    robot_model: Callable[[str], Seen], shape: str
) -> None:
    for see in (robot_model, simulated):
        (text,) = see(urdf(shape)).told
        assert text.startswith("<visual> of link 'a' is left out: ")
