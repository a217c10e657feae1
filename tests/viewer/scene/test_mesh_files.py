"""Mesh files of every kind: as RViz shows them, and as far as they can be shown."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings, strategies
from PIL import Image

from teleopctl.robot import meshes as reader
from teleopctl.viewer.scene.assets import MeshError, load_embedded_mesh, load_mesh
from teleopctl.viewer.scene.gltf import colored_glb

KINDS = ("stl", "obj", "dae", "glb", "ply")
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
RED = (1.0, 0.0, 0.0, 1.0)


# Any: what JSON holds, and what trimesh makes of it.


def described(glb: bytes) -> Any:
    (length,) = struct.unpack_from("<I", glb, 12)
    return json.loads(glb[20 : 20 + length])


def materials(glb: bytes) -> Any:
    return described(glb)["materials"]


def size_of(mesh) -> Any:
    if mesh.vertices is not None:
        return np.ptp(mesh.vertices, axis=0).tolist()
    scene = trimesh.load_scene(trimesh.util.wrap_as_stream(mesh.glb), file_type="glb")
    return scene.extents.tolist()


def faces_of(mesh) -> int:
    return len(mesh.faces)


def exported(folder: Path, kind: str, box=None) -> Path:
    path = folder / f"box.{kind}"
    (box or trimesh.creation.box((1.0, 2.0, 3.0))).export(path)
    return path


def binary_stl(triangles, claimed=None) -> bytes:
    corners = np.asarray(triangles, np.float32).reshape(-1, 3, 3)
    rows = np.zeros(len(corners), reader._STL_TRIANGLE)
    rows["corners"] = corners
    count = len(corners) if claimed is None else claimed
    return b"solid made by CAD".ljust(80) + struct.pack("<I", count) + rows.tobytes()


@pytest.mark.parametrize("kind", KINDS)
def test_a_mesh_of_each_kind_has_the_size_of_its_file(tmp_path, kind):
    mesh = load_mesh(str(exported(tmp_path, kind)))
    assert size_of(mesh) == pytest.approx([1, 2, 3])
    assert np.array(mesh.box) == pytest.approx(np.array([(-0.5, -1, -1.5), (0.5, 1, 1.5)]))
    assert mesh.faults == ()
    bare = load_mesh(mesh.path.as_uri(), bare=True)
    assert not bare.glb
    assert size_of(bare) == pytest.approx([1, 2, 3])
    embedded = load_embedded_mesh(mesh.path.name, mesh.path.read_bytes())
    assert size_of(embedded) == pytest.approx([1, 2, 3])


def corner_color(glb: bytes) -> list[int]:
    said = described(glb)
    accessor = said["accessors"][said["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]]
    (length,) = struct.unpack_from("<I", glb, 12)
    start = 28 + length + said["bufferViews"][accessor["bufferView"]]["byteOffset"]
    return list(glb[start : start + 4])


def test_colours_of_a_file_are_those_that_a_screen_shows(tmp_path):
    half, light = 188, 0.5  # half of a screen's light, which glTF counts
    (tmp_path / "part.mtl").write_text(f"newmtl a\nKd {half / 255} 1 0\n")
    (tmp_path / "part.obj").write_text(f"mtllib part.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\n")
    (material,) = materials(load_mesh(str(tmp_path / "part.obj")).glb)
    color = material["pbrMetallicRoughness"]["baseColorFactor"]
    assert color == pytest.approx([light, 1, 0, 1], abs=0.01)
    painted = trimesh.creation.box()
    painted.visual = trimesh.visual.ColorVisuals(painted, vertex_colors=[half, 255, 0, 255])
    glb = load_mesh(str(exported(tmp_path, "ply", painted))).glb
    assert corner_color(glb) == pytest.approx([128, 255, 0, 255], abs=1)
    # whose own file has them so
    glb = load_mesh(str(exported(tmp_path, "glb", painted))).glb
    assert corner_color(glb) == [half, 255, 0, 255]


def test_a_text_stl_is_one_too(tmp_path):
    path = tmp_path / "text.stl"
    path.write_text(trimesh.creation.box().export(file_type="stl_ascii"))
    assert size_of(load_mesh(str(path))) == pytest.approx([1, 1, 1])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("content", [b"", b"nonsense", b"\0" * 300, b"<a>" * 40])
def test_a_broken_file_of_each_kind_is_named(tmp_path, kind, content):
    path = tmp_path / f"broken.{kind}"
    path.write_bytes(content)
    with pytest.raises(MeshError, match=r"broken\."):
        load_mesh(str(path))


@pytest.mark.parametrize("kind", [*KINDS, "gltf"])
def test_a_missing_file_of_each_kind_is_named(tmp_path, kind):
    with pytest.raises(MeshError, match=r"gone.*No such file"):
        load_mesh(f"file://{tmp_path}/gone.{kind}")


@pytest.mark.parametrize(
    "uri", ["package://nobody_has_this/a.stl", "http://somewhere/a.stl", "a\0.stl", "~nobody/a.stl"]
)
def test_an_address_that_leads_nowhere_is_named(uri):
    with pytest.raises(MeshError, match="Mesh"):
        load_mesh(uri)


def test_what_is_no_mesh_is_not_opened(tmp_path):
    path = tmp_path / "bomb.zae"
    path.write_bytes(b"PK")
    with pytest.raises(MeshError, match="unsupported format"):
        load_mesh(str(path))


def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setitem(reader._MOST_BYTES, ".stl", 100)
    with pytest.raises(MeshError, match="at most"):
        load_mesh(str(exported(tmp_path, "stl")))


@given(content=strategies.binary(max_size=200), kind=strategies.sampled_from([*KINDS, "gltf"]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_file_raises_anything_but_a_mesh_error(tmp_path, content, kind):
    path = tmp_path / f"any.{kind}"
    path.write_bytes(content)
    with pytest.raises(MeshError, match=r"any\."):
        load_mesh(str(path))


# --- STL ---------------------------------------------------------------------------------------


def test_a_binary_stl_may_begin_as_a_text_does(tmp_path):
    path = tmp_path / "cad.stl"
    path.write_bytes(binary_stl([[0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    assert faces_of(load_mesh(str(path))) == 1


def test_an_stl_that_ends_early_is_shown_as_far_as_it_goes(tmp_path):
    path = tmp_path / "cut.stl"
    path.write_bytes(binary_stl([[0, 0, 0], [1, 0, 0], [0, 1, 0]] * 3, claimed=4_000_000_000)[6:])
    path.write_bytes(b"x" * 6 + path.read_bytes())
    mesh = load_mesh(str(path))
    assert faces_of(mesh) == 3
    assert "cut.stl ends after 3 of the 4000000000 triangles" in mesh.faults[0]


def test_triangles_with_impossible_corners_are_left_out(tmp_path):
    path = tmp_path / "nan.stl"
    good = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    bad = [[0, 0, 0], [np.nan, 0, 0], [0, 1e30, 0]]
    path.write_bytes(binary_stl([good, bad]))
    mesh = load_mesh(str(path))
    assert faces_of(mesh) == 1
    assert "1 triangle is left out" in mesh.faults[0]
    path.write_bytes(binary_stl([bad]))
    with pytest.raises(MeshError, match=r"nan\.stl holds no triangles"):
        load_mesh(str(path))


@given(strategies.lists(strategies.integers(-3, 3), min_size=9, max_size=9 * 40))
def test_joined_corners_are_those_that_were_there(numbers):
    corners = np.array(numbers[: len(numbers) // 9 * 9], np.float32).reshape(-1, 3) * 0.1
    vertices, faces = reader._joined(corners)
    assert np.array_equal(vertices[faces.ravel()], corners)
    assert len(np.unique(vertices, axis=0)) == len(vertices)


# --- colours and textures ----------------------------------------------------------------------


def obj(folder: Path, *faces: str, mtl: str = "") -> Path:
    path = folder / "part.obj"
    path.write_text("mtllib part.mtl\n" + TRIANGLE + "\n".join(faces))
    (folder / "part.mtl").write_text(mtl)
    return path


def test_materials_of_an_obj_are_its_own(tmp_path):
    mtl = "newmtl red\nKd 1 0 0\nd 1\nnewmtl glass\nKd 0 0 1\nd 0.25\n"
    path = obj(tmp_path, "usemtl red", "f 1 2 3", "usemtl glass", "f 3 2 1", mtl=mtl)
    mesh = load_mesh(str(path))
    assert mesh.vertices is None
    for glb in (mesh.glb, colored_glb(mesh.glb, (0.0, 1.0, 0.0, 1.0))):
        colors = {tuple(one["pbrMetallicRoughness"]["baseColorFactor"]) for one in materials(glb)}
        assert (1.0, 0.0, 0.0, 1.0) in colors
        assert (0.0, 1.0, 0.0, 1.0) not in colors
    assert all(one["doubleSided"] for one in materials(mesh.glb))


def test_a_texture_is_sent_as_browsers_show_it(tmp_path):
    Image.new("RGB", (3000, 30), (10, 200, 30)).save(tmp_path / "skin of it.tif")
    path = obj(
        tmp_path,
        "usemtl skin",
        "f 1/1 2/2 3/3",
        mtl="newmtl skin\nKd 1 1 1\nmap_Kd skin of it.tif\n",
    )
    mesh = load_mesh(str(path))
    assert mesh.faults == ()
    (image,) = described(mesh.glb)["images"]
    assert image["mimeType"] == "image/png"
    scene = trimesh.load_scene(trimesh.util.wrap_as_stream(mesh.glb), file_type="glb")
    (part,) = scene.geometry.values()
    assert part.visual.material.baseColorTexture.size == (2048, 20)


def test_a_missing_texture_costs_the_texture_alone(tmp_path):
    path = obj(tmp_path, "usemtl a", "f 1/1 2/2 3/3", mtl="newmtl a\nKd 1 0 0\nmap_Kd gone.png\n")
    mesh = load_mesh(str(path))
    assert mesh.glb
    assert mesh.faults == (f"Mesh {path} names gone.png, which is not there",)


def test_a_texture_of_too_many_pixels_is_never_unpacked(tmp_path):
    # 400 megapixels in 50 kB
    Image.new("1", (20_000, 20_000)).save(tmp_path / "bomb.png")
    path = obj(tmp_path, "usemtl a", "f 1/1 2/2 3/3", mtl="newmtl a\nKd 1 0 0\nmap_Kd bomb.png\n")
    mesh = load_mesh(str(path))
    assert "images" not in described(mesh.glb)
    assert "bomb.png" in mesh.faults[0]


def test_what_names_no_material_has_the_colour_of_the_description(tmp_path):
    path = tmp_path / "bare.obj"
    path.write_text(TRIANGLE + "f 1/1 2/2 3/3\n")
    mesh = load_mesh(str(path))
    (material,) = materials(colored_glb(mesh.glb, RED, 0.5))
    assert material["pbrMetallicRoughness"]["baseColorFactor"] == [1.0, 0.0, 0.0, 0.5]
    assert material["alphaMode"] == "BLEND"


def test_alpha_makes_materials_of_the_file_be_seen_through(tmp_path):
    path = obj(tmp_path, "usemtl a", "f 1 2 3", mtl="newmtl a\nKd 1 0 0\n")
    (material, *_) = materials(colored_glb(load_mesh(str(path)).glb, RED, 0.25))
    assert material["pbrMetallicRoughness"]["baseColorFactor"][3] == pytest.approx(0.25)
    assert material["alphaMode"] == "BLEND"


# --- COLLADA and glTF --------------------------------------------------------------------------


def test_a_collada_files_unit_counts_and_its_upward_axis_does_not(tmp_path):
    path = exported(tmp_path, "dae")
    text = path.read_text()
    head, _, rest = text.partition("</asset>")
    head = head.partition("<up_axis>")[0].partition("<unit")[0]
    path.write_text(
        f'{head}<unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>{rest}'
    )
    assert size_of(load_mesh(str(path))) == pytest.approx([0.0254, 0.0508, 0.0762])


def test_a_gltf_that_claims_more_than_it_has_takes_no_memory(tmp_path):
    path = tmp_path / "claim.gltf"
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"componentType": 5126, "count": 2_000_000_000, "type": "VEC3"}],
    }
    path.write_text(json.dumps(document))
    with pytest.raises(MeshError, match=r"claim\.gltf claims 2000000000 numbers"):
        load_mesh(str(path))


def test_a_ply_that_claims_more_than_it_has_is_refused(tmp_path):
    path = tmp_path / "claim.ply"
    path.write_bytes(
        b"ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\n"
        b"property float y\nproperty float z\nelement face 1\n"
        b"property list uchar int vertex_indices\nend_header\n" + b"\0" * 64
    )
    with pytest.raises(MeshError, match=r"claim\.ply"):
        load_mesh(str(path))


def test_a_collada_file_of_entities_within_entities_is_refused(tmp_path):
    path = tmp_path / "laughs.dae"
    entities = '<!ENTITY a0 "ha">' + "".join(
        f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12)
    )
    path.write_text(f"<?xml version='1.0'?><!DOCTYPE COLLADA [{entities}]><COLLADA>&a11;</COLLADA>")
    with pytest.raises(MeshError, match=r"laughs\.dae"):
        load_mesh(str(path))
