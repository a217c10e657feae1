"""Markers: what browsers are sent is what RViz shows."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, quaternion_from_rpy
from teleopctl.viewer import OK, WARN
from teleopctl.viewer.panels.scene import _Row
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import SECOND, Draw, Picture, look, put_frame
from tests.viewer.displays.test_geometry import point, pose

Marker = get_message("visualization_msgs/msg/Marker")
MarkerArray = get_message("visualization_msgs/msg/MarkerArray")
ColorRGBA = get_message("std_msgs/msg/ColorRGBA")
RED = (1.0, 0.0, 0.0, 1.0)
TETRAHEDRON = """
solid t
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid t
"""


def rgba(r: float, g: float, b: float, a: float) -> Any:
    return ColorRGBA(r=r, g=g, b=b, a=a)


def marker(kind: int, number: int = 0, **fields: Any) -> Any:
    """A red marker of size 1 in the frame map."""
    made = Marker(type=kind, id=number, ns=fields.pop("ns", ""))
    made.header.frame_id = fields.pop("frame", "map")
    made.header.stamp.sec, made.header.stamp.nanosec = divmod(fields.pop("stamp", 0), SECOND)
    made.scale.x, made.scale.y, made.scale.z = fields.pop("scale", (1.0, 1.0, 1.0))
    made.color = rgba(*fields.pop("color", RED))
    for name, value in fields.items():
        setattr(made, name, value)
    return made


def points(*places: tuple[float, float]) -> list[Any]:
    return [point(x, y) for x, y in places]


def show(page: FakePage, *markers: Any) -> None:
    page.publish("/it", MarkerArray(markers=list(markers)))
    look(page)


def test_solids_of_a_shape_are_one_batch_however_many(page: FakePage, draw: Draw, picture: Picture):
    display = draw("MarkerArray")
    quarter = quaternion_from_rpy(0.0, 0.0, math.pi / 2)
    cubes = [
        marker(Marker.CUBE, i, pose=pose(i, 0.0, turn=quarter), scale=(0.1, 0.2, 0.3))
        for i in range(1000)
    ]
    show(page, *cubes, marker(Marker.SPHERE, 2000), marker(Marker.CYLINDER, 2001))
    nodes = picture.nodes("/display1")
    assert set(nodes) == {"box", "sphere", "cylinder"}
    box = nodes["box"]
    assert box.batched_positions[:, 0].tolist() == list(range(1000))
    np.testing.assert_allclose(box.batched_scales[7], [0.1, 0.2, 0.3], rtol=1e-6)
    np.testing.assert_allclose(box.batched_wxyzs[7], [0.5**0.5, 0, 0, 0.5**0.5], rtol=1e-6)
    assert box.batched_colors[7].tolist() == [255, 0, 0]
    assert display.status == (OK, "")


def test_an_arrow_is_as_long_as_its_scale_or_joins_its_points(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("MarkerArray")
    show(page, marker(Marker.ARROW, 0, scale=(2.0, 0.1, 0.2)))
    nodes = picture.nodes("/display1")
    shaft, head = nodes["cylinder"], nodes["cone"]
    np.testing.assert_allclose(shaft.batched_positions, [[0.77, 0.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose(shaft.batched_scales, [[0.2, 0.1, 1.54]], rtol=1e-6)
    np.testing.assert_allclose(head.batched_positions, [[1.77, 0.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose(head.batched_scales, [[0.4, 0.2, 0.46]], rtol=1e-6)
    two = points((1.0, 1.0), (1.0, 3.0))
    show(page, marker(Marker.ARROW, 0, points=two, scale=(0.1, 0.3, 0.5), pose=pose(10.0, 0.0)))
    nodes = picture.nodes("/display1")
    np.testing.assert_allclose(nodes["cylinder"].batched_positions, [[11.0, 1.75, 0]], atol=1e-6)
    np.testing.assert_allclose(nodes["cylinder"].batched_scales, [[0.1, 0.1, 1.5]], rtol=1e-6)
    np.testing.assert_allclose(nodes["cone"].batched_scales, [[0.3, 0.3, 0.5]], rtol=1e-6)
    strip = points((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
    show(page, marker(Marker.ARROW_STRIP, 0, points=strip, scale=(0.1, 0.2, 0.0)))
    assert len(picture.nodes("/display1")["cone"].batched_positions) == 2


def test_lists_have_a_colour_for_each_point_if_as_many_are_given(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Marker")
    green = rgba(0.0, 1.0, 0.0, 0.5)
    said = marker(Marker.CUBE_LIST, 0, points=points((0, 0), (1, 0)), scale=(0.5, 0.5, 0.5))
    said.colors = [rgba(0.0, 0.0, 1.0, 1.0), green]
    page.publish("/it", said)
    look(page)
    nodes = picture.nodes("/display1")
    assert nodes["box"].batched_colors.tolist() == [[0, 0, 255]]
    assert nodes["box_clear"].batched_colors.tolist() == [[0, 255, 0]]
    assert nodes["box_clear"].batched_opacities.tolist() == [0.5]
    said.colors = [green]
    page.publish("/it", said)
    look(page)
    assert picture.nodes("/display1")["box"].batched_colors.tolist() == [[255, 0, 0]] * 2
    assert display.status == (WARN, "Marker 0 has 1 colours for 2 points: they are not used")


def test_lines_points_and_texts_have_their_widths_and_heights(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("MarkerArray")
    four = points((0, 0), (1, 0), (1, 1), (0, 1))
    show(
        page,
        marker(Marker.LINE_STRIP, 0, points=four, scale=(0.02, 0.0, 0.0)),
        marker(Marker.LINE_LIST, 1, points=four, scale=(0.05, 0.0, 0.0)),
        marker(Marker.POINTS, 2, points=four, scale=(0.1, 0.1, 0.0), pose=pose(5.0, 0.0)),
        marker(Marker.SPHERE_LIST, 3, points=four, scale=(0.1, 0.1, 0.1)),
        marker(Marker.TEXT_VIEW_FACING, 4, text="<b>hello</b>", scale=(0.0, 0.0, 0.3)),
    )
    nodes = picture.nodes("/display1")
    assert nodes["lines0"].points.shape == (3, 2, 3)
    assert nodes["lines0"].thickness == 0.02
    assert nodes["lines1"].points.tolist() == [[[0, 0, 0], [1, 0, 0]], [[1, 1, 0], [0, 1, 0]]]
    assert nodes["points0"].points[0].tolist() == [5, 0, 0]
    assert nodes["points0"].point_size == pytest.approx(0.1)
    assert len(nodes["sphere"].batched_positions) == 4
    assert (nodes["text0"].text, nodes["text0"].font_scene_height) == ("<b>hello</b>", 0.3)


def test_triangles_have_one_colour_or_one_for_each_corner(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("MarkerArray")
    six = points((0, 0), (1, 0), (0, 1), (1, 0), (1, 1), (0, 1))
    show(page, marker(Marker.TRIANGLE_LIST, 0, points=six, color=(0.0, 1.0, 0.0, 0.5)))
    plain = picture.nodes("/display1")["surface0"]
    assert plain.vertices.shape == (6, 3)
    assert (plain.color, plain.opacity, plain.side) == ((0, 255, 0), 0.5, "double")
    said = marker(Marker.TRIANGLE_LIST, 0, points=six)
    said.colors = [rgba(1.0, 0.0, 0.0, 1.0), rgba(0.0, 0.0, 1.0, 1.0)]
    show(page, said)
    glb = picture.nodes("/display1")["surface0"].glb_data
    assert struct.unpack("<4sII", glb[:12]) == (b"glTF", 2, len(glb))
    (length,) = struct.unpack("<I", glb[12:16])
    described = json.loads(glb[20 : 20 + length])
    numbers = glb[28 + length :]
    assert len(numbers) == described["buffers"][0]["byteLength"]
    corners, colors = (
        numbers[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        for view in described["bufferViews"]
    )
    assert np.frombuffer(corners, np.float32).reshape(-1, 3)[4].tolist() == [1, 1, 0]
    assert np.frombuffer(colors, np.uint16).reshape(-1, 4)[:, 0].tolist() == [65535] * 3 + [0] * 3


def test_add_modify_delete_and_delete_all(page: FakePage, draw: Draw, picture: Picture):
    draw("MarkerArray")
    show(
        page,
        *[marker(Marker.CUBE, i, ns=ns, pose=pose(i, 0.0)) for ns in "ab" for i in range(3)],
    )

    def places() -> list[float]:
        nodes = picture.nodes("/display1")
        return sorted(nodes["box"].batched_positions[:, 0].tolist()) if nodes else []

    assert places() == [0, 0, 1, 1, 2, 2]
    show(page, marker(Marker.CUBE, 1, ns="a", pose=pose(9.0, 0.0)))
    assert places() == [0, 0, 1, 2, 2, 9]
    show(page, marker(0, 2, ns="b", action=Marker.DELETE))
    assert places() == [0, 0, 1, 2, 9]
    show(page, marker(Marker.SPHERE, 0, ns="b"))
    assert set(picture.nodes("/display1")) == {"box", "sphere"}
    show(page, marker(0, 0, ns="a", action=Marker.DELETEALL))
    assert places() == [1]
    show(page, marker(0, 0, action=Marker.DELETEALL))
    assert not picture.nodes("/display1")


def test_a_lifetime_counts_from_receipt(page: FakePage, draw: Draw, picture: Picture):
    draw("MarkerArray")
    page.node.now_ns = 100 * SECOND
    mortal = marker(Marker.CUBE, 0, stamp=0)
    mortal.lifetime.sec = 2
    show(page, mortal, marker(Marker.SPHERE, 1))
    page.node.now_ns = 101 * SECOND
    look(page)
    assert set(picture.nodes("/display1")) == {"box", "sphere"}
    page.node.now_ns = 102 * SECOND
    look(page)
    assert set(picture.nodes("/display1")) == {"sphere"}


def test_frame_locked_markers_move_with_their_frame_and_others_stay(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("MarkerArray")
    put_frame(page, "tool", "map", Transform((1.0, 0.0, 0.0)), SECOND)
    show(
        page,
        marker(Marker.CUBE, 0, frame="tool", frame_locked=True, pose=pose(0.5, 0.0)),
        marker(Marker.SPHERE, 1, frame="tool", pose=pose(0.5, 0.0)),
    )
    assert picture.nodes("/frames/tool")["display1/box"].batched_positions[0][0] == 0.5
    assert picture.nodes("/display1")["sphere"].batched_positions[0][0] == 1.5
    put_frame(page, "tool", "map", Transform((7.0, 0.0, 0.0)), 2 * SECOND)
    look(page)
    assert picture.nodes("/display1")["sphere"].batched_positions[0][0] == 1.5
    page.frames.set_fixed_frame("tool")
    look(page)
    look(page)
    # what stands still is placed again, where its frame stands now
    assert picture.nodes("/display1")["sphere"].batched_positions[0][0] == 0.5


def test_a_marker_waits_for_its_transform(page: FakePage, draw: Draw, picture: Picture):
    display = draw("MarkerArray")
    show(page, marker(Marker.CUBE, 0, frame="ghost", stamp=SECOND))
    assert display.status == (WARN, "No transform from [ghost] to [map]")
    assert not picture.nodes("/display1")
    put_frame(page, "ghost", "map", Transform((3.0, 0.0, 0.0)), SECOND)
    look(page)
    assert display.status == (OK, "")
    assert picture.nodes("/display1")["box"].batched_positions[0][0] == 3.0


@pytest.mark.parametrize(
    ("said", "fault"),
    [
        (marker(Marker.CUBE, 7, ns="n", color=(1.0, 1.0, 1.0, 0.0)), "n/7 is invisible: its co"),
        (marker(Marker.CUBE, scale=(1.0, 0.0, 1.0)), "0 is invisible: its scale is 0"),
        (marker(Marker.CUBE, scale=(math.nan, 1.0, 1.0)), "0 has numbers that are not finite"),
        (marker(Marker.POINTS, points=points((math.inf, 0))), "0 has points that are not finite"),
        (marker(Marker.LINE_STRIP, points=points((0, 0))), "0 has 1 points and needs 2"),
        (marker(Marker.TEXT_VIEW_FACING), "0 has no text"),
        (marker(Marker.MESH_RESOURCE), "0 has no mesh_resource"),
        (marker(99), "0 is of type 99, which is unknown"),
        (marker(0, action=17), "0 has the unknown action 17"),
    ],
)
def test_the_status_says_why_a_marker_is_not_seen(
    page: FakePage, draw: Draw, picture: Picture, said: Any, fault: str
):
    display = draw("MarkerArray")
    show(page, marker(Marker.SPHERE, 1, ns="good"), said)
    assert display.status[0] == WARN
    assert display.status[1].startswith(f"Marker {fault}")
    assert "sphere" in picture.nodes("/display1")


def test_an_id_twice_in_a_message_is_told(page: FakePage, draw: Draw):
    display = draw("MarkerArray")
    show(page, marker(Marker.CUBE, 3), marker(Marker.SPHERE, 3))
    assert display.status == (WARN, "Marker 3 is in the message more than once")


def test_namespaces_are_switched_off_by_a_file_and_on_the_page(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("MarkerArray", Namespaces={"grasps": False, 7: True})
    cubes = [marker(Marker.CUBE, 0, ns=ns) for ns in ("grasps", "7", "")]
    show(page, *cubes)
    assert len(picture.nodes("/display1")["box"].batched_positions) == 2
    assert display.parts() == {"grasps": False, "7": True, "": True}
    row = _Row(page, display)
    row.show_status()
    page.choose(row._parts["grasps"], True)
    page.choose(row._parts["7"], False)
    page.choose(row._parts[""], False)
    look(page)
    assert len(picture.nodes("/display1")["box"].batched_positions) == 1
    assert display.values.given["Namespaces"] == {"grasps": True, 7: False, "": False}


def test_meshes_are_read_once_and_drawn_in_the_markers_colour(
    page: FakePage, draw: Draw, picture: Picture, tmp_path: Path
):
    display = draw("MarkerArray")
    file = tmp_path / "part.stl"
    file.write_text(TETRAHEDRON)
    uri = f"file://{file}"
    show(page, *[marker(Marker.MESH_RESOURCE, i, mesh_resource=uri) for i in range(3)])
    (node,) = picture.nodes("/display1").values()
    assert len(node.batched_positions) == 3
    assert node.vertices.shape == (3, 3)
    assert display.status == (OK, "")
    show(page, marker(Marker.MESH_RESOURCE, 9, mesh_resource="file:///nowhere/at/all.dae"))
    assert display.status[0] == WARN
    assert "/nowhere/at/all.dae" in display.status[1]


def test_a_mesh_in_the_message_is_drawn(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Marker")
    said = marker(Marker.MESH_RESOURCE, 0, mesh_resource="embedded://part.stl")
    said.mesh_file.filename = "part.stl"
    said.mesh_file.data = TETRAHEDRON.encode()
    page.publish("/it", said)
    look(page)
    assert display.status == (OK, "")
    assert len(picture.nodes("/display1")) == 1


def test_a_mesh_with_its_own_materials_is_sent_as_it_is(
    page: FakePage, draw: Draw, picture: Picture, tmp_path: Path
):
    draw("MarkerArray")
    (tmp_path / "part.mtl").write_text("newmtl blue\nKd 0 0 1\n")
    file = tmp_path / "part.obj"
    file.write_text("mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\n")
    said = marker(Marker.MESH_RESOURCE, 0, mesh_resource=str(file), color=(0.0, 0.0, 0.0, 0.0))
    said.mesh_use_embedded_materials = True
    show(page, said)
    (node,) = picture.nodes("/display1").values()
    assert node.glb_data[:4] == b"glTF"
    said.mesh_use_embedded_materials, said.color = False, rgba(*RED)
    show(page, said)
    (node,) = picture.nodes("/display1").values()
    assert node.batched_colors.tolist() == [[255, 0, 0]]


def base_colors(node: Any) -> list[list[float]]:
    (length,) = struct.unpack("<I", node.glb_data[12:16])
    materials = json.loads(node.glb_data[20 : 20 + length])["materials"]
    return [one["pbrMetallicRoughness"]["baseColorFactor"] for one in materials]


def screen_shade(light: float) -> float:
    return light * 12.92 if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055


def test_a_black_marker_darkens_a_mesh_with_its_own_materials_by_half(
    page: FakePage, draw: Draw, picture: Picture, tmp_path: Path
):
    draw("Marker")
    (tmp_path / "part.mtl").write_text("newmtl a\nKd 1 1 0\n")
    file = tmp_path / "part.obj"
    file.write_text("mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    # What a program sends that sets nothing of its colour but the opacity.
    said = marker(Marker.MESH_RESOURCE, 0, mesh_resource=str(file), color=(0.0, 0.0, 0.0, 1.0))
    said.mesh_use_embedded_materials = True
    page.publish("/it", said)
    look(page)
    (node,) = picture.nodes("/display1").values()
    (color,) = base_colors(node)
    assert [round(screen_shade(part), 3) for part in color[:3]] == [0.5, 0.5, 0]


def test_a_colour_tints_a_mesh_with_its_own_materials(
    page: FakePage, draw: Draw, picture: Picture, tmp_path: Path
):
    draw("MarkerArray")
    (tmp_path / "part.mtl").write_text("newmtl a\nKd 1 1 0\n")
    file = tmp_path / "part.obj"
    file.write_text("mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    colors = [
        (0.0, 0.0, 0.0, 0.0),
        (1.0, 0.0, 1.0, 0.2),
        (1.0, 0.0, 1.0, 0.2),
        (0.0, 1.0, 0.0, 1.0),
    ]
    marked = [
        marker(Marker.MESH_RESOURCE, number, mesh_resource=str(file), color=color)
        for number, color in enumerate(colors)
    ]
    for one in marked:
        one.mesh_use_embedded_materials = True
    show(page, *marked)
    nodes = picture.nodes("/display1")
    shown = {tuple(base_colors(node)[0]): len(node.batched_positions) for node in nodes.values()}
    # A fifth of the way from yellow to magenta, and half the way to green, as screens count.
    assert {
        (*(round(screen_shade(part), 3) for part in color[:3]), color[3]): count
        for color, count in shown.items()
    } == {(1, 1, 0, 1): 1, (1, 0.8, 0.2, 0.2): 2, (0.5, 1, 0, 1): 1}
    marked[0].color = rgba(1.0, 0.0, 0.0, 1.0)
    show(page, marked[0])
    assert len(picture.nodes("/display1")) == 3


def test_of_a_mesh_in_more_colours_than_are_sent_none_is_missing(
    page: FakePage, draw: Draw, picture: Picture, tmp_path: Path
):
    draw("MarkerArray")
    file = tmp_path / "part.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    marked = [
        marker(Marker.MESH_RESOURCE, n, mesh_resource=str(file), color=(n / 60, 0.5, 0.5, 1.0))
        for n in range(60)
    ]
    for one in marked:
        one.mesh_use_embedded_materials = True
    show(page, *marked)
    counts = [len(node.batched_positions) for node in picture.nodes("/display1").values()]
    assert (len(counts), sum(counts)) == (20, 60)


def test_ids_without_end_do_not_fill_the_memory(
    page: FakePage, draw: Draw, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("teleopctl.viewer.displays.markers.markers.MOST_MARKERS", 50)
    display: Any = draw("Marker")
    for number in range(80):
        page.publish("/it", marker(Marker.CUBE, number))
    look(page)
    assert len(display.markers) == 50
    assert display.status[0] == WARN


def test_nothing_is_sent_while_nothing_changes(
    page: FakePage, draw: Draw, monkeypatch: pytest.MonkeyPatch
):
    draw("MarkerArray")
    cubes = [marker(Marker.CUBE, i, pose=pose(i, 0.0)) for i in range(10)]
    corners = points((0, 0), (1, 0), (0, 1))
    cubes.append(marker(Marker.TRIANGLE_LIST, 20, points=corners))
    cubes.append(marker(Marker.LINE_STRIP, 21, points=corners))
    cubes.append(marker(Marker.TEXT_VIEW_FACING, 22, text="same"))
    show(page, *cubes)
    sent: list[object] = []
    monkeypatch.setattr(page.scene, "_queue_scene_message", sent.append)
    show(page, *cubes)
    look(page)
    assert not sent
    show(page, marker(Marker.CUBE, 3, pose=pose(50.0, 0.0)))
    assert len(sent) == 1
