"""RobotModel: the links on their frames, in their colours, and what cannot be shown of them."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from teleopctl.interfaces import get_message
from teleopctl.robot import RobotDescription, gazebo_colour
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, OK, WARN
from teleopctl.viewer.displays.robot_model import RobotAssets, load_assets
from tests.viewer.displays.conftest import look, put_frame

STRING = get_message("std_msgs/msg/String")
TOPIC = {"Value": "/robot_description"}


def link(name: str, *visuals: str, collision: str = "") -> str:
    return f'<link name="{name}">{"".join(visuals)}{collision}</link>'


def visual(shape: str, material: str = "", tag: str = "visual", origin: str = "") -> str:
    return f"<{tag}>{origin}<geometry>{shape}</geometry>{material}</{tag}>"


def robot(*links: str, materials: str = "") -> str:
    return f'<robot name="r">{materials}{"".join(links)}</robot>'


def box(material: str = "") -> str:
    return visual('<box size="1 2 3"/>', material)


def stl(folder: Path, name: str = "part.stl") -> Path:
    path = folder / name
    trimesh.creation.box().export(path)
    return path


@pytest.fixture
def model(draw, stage):
    """Draws a robot, and gives the display."""

    def make(urdf: str, **given):
        display = draw("RobotModel", **{"Description Topic": TOPIC, "Topic": None, **given})
        put_frame(stage, "a", "map", Transform())
        stage.frames.update()
        stage.publish("/robot_description", STRING(data=urdf))
        return display

    return make


def nodes(stage, frame: str = "a") -> dict:
    found = stage.scene._handle_from_node_name
    return {
        path.rpartition("/")[2]: node
        for path, node in found.items()
        if path.startswith(f"/frames/{frame}/display") and path.count("/") == 4
    }


def color(node) -> tuple[int, ...]:
    return tuple(int(part) for part in node.color)


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        ('<box size="1 2 3"/>', (1, 2, 3)),
        ('<cylinder radius="1" length="3"/>', (2, 2, 3)),
        ('<capsule radius="1" length="3"/>', (2, 2, 5)),
        ('<sphere radius="1"/>', (2, 2, 2)),
    ],
)
def test_shapes_stand_around_their_origin(model, stage, shape, size):
    model(robot(link("a", visual(shape, origin='<origin xyz="0 0 1" rpy="0 0 0"/>'))))
    (node,) = nodes(stage).values()
    assert tuple(node.position) == (0, 0, 1)
    if hasattr(node, "vertices"):
        low, high = node.vertices.min(axis=0), node.vertices.max(axis=0)
        assert high - low == pytest.approx(size, rel=0.05)
        assert low + high == pytest.approx((0, 0, 0), abs=0.01)
    elif hasattr(node, "dimensions"):
        assert tuple(node.dimensions) == size
    else:
        assert 2 * node.radius == size[0]


def test_a_material_is_what_its_name_says_wherever_it_was_defined(model, stage):
    blue = '<material name="blue"><color rgba="0 0 1 1"/></material>'
    other_red = '<material name="red"><color rgba="0 1 0 1"/></material>'
    model(
        robot(
            link("a", box(other_red), box(blue), box('<material name="blue"/>'), box()),
            materials='<material name="red"><color rgba="1 0 0 0.5"/></material>',
        )
    )
    shown = nodes(stage)
    assert color(shown["visual0"]) == (255, 0, 0)
    assert shown["visual0"].opacity == 0.5
    assert color(shown["visual1"]) == color(shown["visual2"]) == (0, 0, 255)
    assert shown["visual1"].opacity is None


def test_a_shape_without_a_colour_has_that_of_its_gazebo_tag_as_in_the_simulation(model, stage):
    blue = '<material name="blue"><color rgba="0 0 1 1"/></material>'
    gazebo = '<gazebo reference="a"><material>Gazebo/Orange</material></gazebo>'
    model(robot(link("a", box(), box(blue)), gazebo))
    shown = nodes(stage)
    orange = gazebo_colour("Gazebo/Orange")
    assert orange is not None
    assert color(shown["visual0"]) == tuple(round(255 * part) for part in orange)
    assert color(shown["visual1"]) == (0, 0, 255)


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        ('<box size="1 2 3"/>', (1, 2, 3)),
        ('<cylinder radius="1" length="3"/>', (2, 2, 3)),
        ('<sphere radius="2"/>', (4, 4, 4)),
    ],
)
def test_a_shape_has_its_texture_as_large_as_it_is(model, stage, tmp_path, shape, size):
    Image.new("RGB", (8, 8), (10, 20, 30)).save(tmp_path / "skin.png")
    skin = f'<texture filename="{tmp_path}/skin.png"/>'
    # RViz has the texture where there is a colour too
    material = f'<material name=""><color rgba="1 0 0 1"/>{skin}</material>'
    model(robot(link("a", visual(shape, material))), Alpha=0.5)
    node = nodes(stage)["visual0"]
    assert (tmp_path / "skin.png").read_bytes() in node.glb_data
    scene = trimesh.load_scene(trimesh.util.wrap_as_stream(node.glb_data), file_type="glb")
    np.testing.assert_allclose(scene.extents * node.scale, size, rtol=5e-3)
    (mesh,) = scene.geometry.values()
    assert mesh.visual.material.alphaMode == "BLEND"
    assert mesh.visual.material.baseColorFactor.tolist() == [255, 255, 255, 128]


def test_what_has_no_place_for_a_texture_has_its_mean_colour(model, stage, tmp_path):
    Image.new("RGB", (8, 8), (10, 20, 30)).save(tmp_path / "skin.png")
    material = f'<material name=""><texture filename="{tmp_path}/skin.png"/></material>'
    part = f'<mesh filename="{stl(tmp_path)}"/>'
    capsule = '<capsule radius="1" length="3"/>'
    model(robot(link("a", visual(part, material), visual(capsule, material))))
    shown = nodes(stage)
    assert color(shown["visual0"]) == color(shown["visual1"]) == (10, 20, 30)


def test_a_texture_that_is_not_there_leaves_the_colour(model, stage):
    material = (
        '<material name=""><color rgba="1 0 0 1"/><texture filename="/no/such.png"/></material>'
    )
    display = model(robot(link("a", box(material))))
    assert color(nodes(stage)["visual0"]) == (255, 0, 0)
    assert "/no/such.png" in display.status[1]


def test_collision_geometry_is_shown_when_asked_for(model, stage):
    shape = visual('<sphere radius="1"/>', tag="collision")
    display = model(robot(link("a", box(), collision=shape)))
    assert set(nodes(stage)) == {"visual0"}
    display.set("Collision Enabled", True)
    display.set("Visual Enabled", False)
    assert set(nodes(stage)) == {"collision0"}


def test_alpha_of_the_robot_and_of_a_link_multiply(model, stage):
    links = {"a": {"Alpha": 0.5, "Value": True}}
    model(robot(link("a", box())), Alpha=0.5, Links=links)
    assert nodes(stage)["visual0"].opacity == 0.25


def test_a_link_that_a_file_hides_is_not_drawn(model, stage):
    model(robot(link("a", box())), Links={"a": {"Value": False}, "b": 3})
    assert nodes(stage) == {}


def test_a_mesh_is_scaled_and_mirrored(model, stage, tmp_path):
    mesh = f'<mesh filename="{stl(tmp_path)}" scale="0.001 -0.001 0.001"/>'
    display = model(robot(link("a", visual(mesh))))
    node = nodes(stage)["visual0"]
    assert tuple(node.scale) == (0.001, -0.001, 0.001)
    # turned inside out, its faces are still seen
    assert node.side == "double"
    assert display.status == (OK, "")


def test_faults_are_in_the_status_and_once_in_the_log(model, stage, tmp_path):
    (tmp_path / "bad.dae").write_text("no XML")
    urdf = robot(
        link(
            "a",
            visual(f'<mesh filename="{tmp_path}/gone.stl"/>'),
            visual(f'<mesh filename="{tmp_path}/bad.dae"/>'),
            visual('<box size="1 0 1"/>'),
            box(),
        )
    )
    display = model(urdf)
    stage.publish("/robot_description", STRING(data=urdf))
    stage.publish("/robot_description", STRING(data=urdf + " "))
    level, text = display.status
    assert level == WARN
    for word in ("gone.stl", "bad.dae", "Shapes of link 'a' are not drawn"):
        assert word in text
        assert sum(word in line for line in stage.node.warnings) == 1
    assert set(nodes(stage)) == {"visual3"}


def test_a_description_that_is_none_leaves_the_robot_that_is_there(model, stage):
    display = model(robot(link("a", box())))
    stage.publish("/robot_description", STRING(data="<robot"))
    assert display.status[0] == ERROR
    assert "not used" in display.status[1]
    assert set(nodes(stage)) == {"visual0"}
    for _ in range(20):
        look(stage)
    assert display.status[0] == ERROR
    stage.publish("/robot_description", STRING(data=robot(link("a", box()))))
    assert display.status[0] == OK


def test_a_link_that_stands_nowhere_is_named_as_rviz_does(model, stage):
    urdf = '<robot name="r"><link name="a"/>' + "".join(
        link(name, box()) + f'<joint name="to_{name}" type="fixed"><parent link="a"/>'
        f'<child link="{name}"/></joint>'
        for name in "bcd"
    )
    display = model(urdf + "</robot>")
    assert display.status == (WARN, "No transform from [b] to [map], and from 2 more links")
    for name in "bcd":
        put_frame(stage, name, "a", Transform())
    for _ in range(20):
        look(stage)
    assert display.status == (OK, "")


def test_the_same_robot_again_is_not_drawn_again(model, stage, tmp_path):
    urdf = robot(link("a", visual(f'<mesh filename="{stl(tmp_path)}"/>')))
    model(urdf)
    before = nodes(stage)["visual0"]
    stage.publish("/robot_description", STRING(data=urdf))
    assert nodes(stage)["visual0"] is before


def test_only_a_mesh_that_has_changed_is_read_again(tmp_path):
    one, two = stl(tmp_path, "one.stl"), stl(tmp_path, "two.stl")
    meshes = [visual(f'<mesh filename="{path}"/>') for path in (one, two, one)]
    description = RobotDescription.from_urdf(robot(link("a", *meshes)))
    first = load_assets(description, RobotAssets())
    assert load_assets(description, first) == first
    trimesh.creation.box((2.0, 2.0, 2.0)).export(tmp_path / "new.stl")
    two.write_bytes(b"x" + (tmp_path / "new.stl").read_bytes()[1:])
    second = load_assets(description, first)
    assert second.meshes[str(one)] is first.meshes[str(one)]
    vertices = second.meshes[str(two)].vertices
    assert vertices is not None
    assert np.ptp(vertices) == pytest.approx(2.0)
    assert second != first


def test_links_that_share_a_mesh_share_its_bytes(model, stage, tmp_path):
    path = tmp_path / "part.obj"
    trimesh.creation.box().export(path)
    model(robot(link("a", *[visual(f'<mesh filename="{path}"/>')] * 3)))
    assert len({id(node.glb_data) for node in nodes(stage).values()}) == 1


def test_a_robot_can_come_from_a_file(model, stage, tmp_path):
    path = tmp_path / "it.urdf"
    path.write_text(robot(link("a", box())))
    display = model(
        robot(link("a", box(), box())),
        **{"Description Source": "File", "Description File": str(path)},
    )
    assert set(nodes(stage)) == {"visual0"}
    display.set("Description Source", "Topic")
    stage.publish("/robot_description", STRING(data=robot(link("a", box(), box()))))
    assert set(nodes(stage)) == {"visual0", "visual1"}


def test_a_mesh_of_many_links_is_one_that_compresses_to_itself(model, stage, tmp_path):
    few, many = stl(tmp_path, "few.stl"), stl(tmp_path, "many.stl")
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    meshes = [visual(f'<mesh filename="{path}"/>', red) for path in [few] + [many] * 4]
    model(robot(link("a", *meshes)))
    shown = nodes(stage)
    assert color(shown["visual0"]) == (255, 0, 0)
    sent = {shown[f"visual{number}"].glb_data for number in (1, 2, 3, 4)}
    assert len(sent) == 1
    assert b'"baseColorFactor":[1.0,0.0,0.0,1.0]' in sent.pop()
    # without normals a browser shades each triangle by itself, as it does those of STL
    assert b"NORMAL" not in shown["visual1"].glb_data
