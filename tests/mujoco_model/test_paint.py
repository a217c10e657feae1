"""Meshes are drawn in the colours and with the pictures of their files."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from teleopctl.mujoco_model import RobotModel
from teleopctl.mujoco_model.paint import MeshTexture, add_textures
from tests.samples import sample
from tests.sim.robots import INERTIAL, box, link, model

RED, GREEN = (255, 0, 0, 255), (0, 255, 0, 255)


def two_boxes(path: Path) -> None:
    """A red box below a green one, of 1 m each."""
    scene = trimesh.Scene()
    for height, colour in ((0.0, RED), (1.0, GREEN)):
        part = trimesh.creation.box((1.0, 1.0, 1.0))
        part.apply_translation((0.0, 0.0, height))
        material = (
            PBRMaterial(baseColorFactor=colour)
            if path.suffix != ".obj"
            else SimpleMaterial(diffuse=colour, ambient=colour, specular=colour)
        )
        # OBJ keeps a material only with places in a picture.
        part.visual = TextureVisuals(uv=np.zeros((len(part.vertices), 2)), material=material)
        scene.add_geometry(part)
    if path.suffix == ".dae":
        parts = list(scene.geometry.values())
        path.write_bytes(trimesh.exchange.dae.export_collada(parts))
    else:
        scene.export(path)


def shape(kind: str, path: Path) -> str:
    return f'<{kind}><geometry><mesh filename="file://{path}"/></geometry></{kind}>'


def colours(robot: RobotModel) -> list[tuple[float, ...]]:
    m = robot.mj_model
    drawn = [n for n in range(m.ngeom) if m.geom_bodyid[n] == m.body("a").id]
    return sorted(tuple(m.geom_rgba[n].tolist()) for n in drawn if m.geom_group[n] < 3)


@pytest.mark.parametrize("kind", ["dae", "glb", "obj"])
def test_each_part_has_the_colour_of_its_material(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"two.{kind}"
    two_boxes(path)
    built = model(link("a", INERTIAL + shape("visual", path) + shape("collision", path)))
    assert built.warnings == ()
    assert colours(built) == [(0.0, 1.0, 0.0, 1.0), (1.0, 0.0, 0.0, 1.0)]
    assert int((built.mj_model.geom_contype > 0).sum()) == 2, "the ground and the whole mesh"


def test_a_mesh_that_gives_a_link_its_mass_weighs_once(tmp_path: Path) -> None:
    path = tmp_path / "two.glb"
    two_boxes(path)
    hinge = '<joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint>'
    built = model(link("base", ""), link("a", shape("visual", path)), hinge)
    assert "'a' has no mass" in built.warnings[0]
    assert built.mj_model.body("a").mass[0] == pytest.approx(2000.0, rel=1e-3)
    assert len(colours(built)) == 2


def test_a_mesh_without_materials_has_the_colour_of_the_urdf(tmp_path: Path) -> None:
    path = tmp_path / "one.glb"
    trimesh.creation.box((1.0, 1.0, 1.0)).export(path)
    blue = '<material name="b"><color rgba="0 0 1 1"/></material></visual>'
    built = model(link("a", shape("visual", path).replace("</visual>", blue)))
    assert colours(built) == [(0.0, 0.0, 1.0, 1.0)]


@pytest.mark.parametrize("kind", sample(["glb", "obj"], 2))
def test_a_picture_is_the_right_way_up(tmp_path: Path, kind: str) -> None:
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:4, :, 0], pixels[4:, :, 1] = 255, 255  # red above, green below
    corners = [[0, -1, 0], [0, 1, 0], [0, 1, 2], [0, -1, 2]]
    sheet = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    material = SimpleMaterial(image=Image.fromarray(pixels))
    sheet.visual = TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], material=material)
    path = tmp_path / f"sheet.{kind}"
    sheet.export(path)
    built = model(link("a", box("collision", "0.1 0.1 0.1") + INERTIAL + shape("visual", path)))
    eye = mujoco.MjvCamera()
    eye.lookat[:], eye.distance, eye.azimuth, eye.elevation = (0.0, 0.0, 1.0), 4.0, 180.0, 0.0
    renderer = mujoco.Renderer(built.mj_model, 100, 100)
    data = mujoco.MjData(built.mj_model)
    mujoco.mj_forward(built.mj_model, data)
    renderer.update_scene(data, eye)
    picture = renderer.render().astype(int)
    renderer.close()
    above, below = picture[40, 50], picture[60, 50]
    assert above[0] > above[1] + 50
    assert below[1] > below[0] + 50


@pytest.mark.parametrize("named", ["{}", "../materials/textures/{}", "C:\\art\\{}"])
def test_pictures_are_found_where_gazebos_models_have_them(tmp_path: Path, named: str) -> None:
    corners = [[0, -1, 0], [0, 1, 0], [0, 1, 2], [0, -1, 2]]
    sheet = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    material = SimpleMaterial(image=Image.new("RGB", (8, 8), (250, 10, 10)))
    sheet.visual = TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], material=material)
    meshes, textures = tmp_path / "meshes", tmp_path / "materials" / "textures"
    meshes.mkdir()
    textures.mkdir(parents=True)
    sheet.export(meshes / "sheet.obj")
    (picture,) = meshes.glob("*.png")
    (library,) = meshes.glob("*.mtl")
    library.write_text(library.read_text().replace(picture.name, named.format("paint.png")))
    picture.rename(textures / "paint.png")
    built = model(
        link(
            "a", box("collision", "0.1 0.1 0.1") + INERTIAL + shape("visual", meshes / "sheet.obj")
        )
    )
    m = built.mj_model
    drawn = [
        n for n in range(m.ngeom) if m.geom_bodyid[n] == m.body("a").id and m.geom_group[n] < 3
    ]
    (texture,) = {
        int(m.mat_texid[m.geom_matid[n]][mujoco.mjtTextureRole.mjTEXROLE_RGB]) for n in drawn
    }
    first = int(m.tex_adr[texture])
    assert m.tex_data[first : first + 3].tolist() == [250, 10, 10]


@pytest.mark.nightly
def test_many_pictures_are_smaller_ones() -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(size=[1.0, 0.0, 0.0])
    pixels = np.full((1024, 512, 3), 7, np.uint8)
    add_textures(spec, [MeshTexture(f"p{n}", pixels, (1.0, 1.0, 1.0, 1.0)) for n in range(60)])
    m = spec.compile()
    assert m.ntex == 60
    assert m.ntexdata < 64_000_000
    assert (set(m.tex_height.tolist()), set(m.tex_width.tolist())) == ({512}, {256})
    assert set(m.tex_data[:100].tolist()) == {7}
