"""Every tag and attribute that descriptions may have has its fate: it acts, or it is named.

What the tables say is held against what is built: of each entry that is to have its effect, one
small file with it and one without it differ, and of each other entry a line names it. What no table
has is named wherever it stands.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh
from hypothesis import given, strategies as st
from lxml import etree

from teleopctl.errors import TeleopctlError
from teleopctl.mujoco_model import build_model, gazebo_only_tags, unsupported_tags
from teleopctl.mujoco_model.surroundings.scene_spec import scene_spec
from teleopctl.robot import RobotDescription, read_world, unknown_tags
from teleopctl.robot.sensor_tag import read_sensor
from teleopctl.robot.tags import gazebo, sdf
from teleopctl.robot.tags.table import Table, TagEntry, is_default

# What a tag says where a number alone makes no sense; by the last two parts of its path, or one.
VALUES = {
    "pose": "0.1 0.2 0.3 0 0 0.5",
    "gravity": "0 0 -3",
    "magnetic_field": "1 2 3",
    "link/gravity": "false",
    "static": "true",
    "self_collide": "false",
    "diffuse": "0.9 0.2 0.1 1",
    "ambient": "0.9 0.2 0.1 1",
    "specular": "0.9 0.2 0.1 1",
    "direction": "1 0 -1",
    "size": "0.3 0.3 0.3",
    "plane/size": "3 3",
    "radii": "0.1 0.2 0.3",
    "normal": "1 0 1",
    "scale": "2 2 2",
    "pos": "1 1 1",
    "xyz": "0 1 1",
    "rpy": "0.1 0.2 0.3",
    "rgba": "0.9 0.2 0.1 1",
    "script/name": "Gazebo/Red",
    "albedo_map": "wood.png",
    "uri": "box.stl",
    "cast_shadows": "true",
    "visual/cast_shadows": "false",
    "light_on": "false",
    "frame": "parent",
    "measure_direction": "parent_to_child",
    "enable_orientation": "false",
    "selfCollide": "false",
    "turnGravityOff": "true",
    "material": "Gazebo/Red",
    "degrees": "true",
    "rotation_format": "quat_xyzw",
    "width": "16",
    "height": "16",
    "horizontal/samples": "3",
    "vertical/samples": "3",
    "far": "50",
    "max": "3",
}
BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
MASS = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
WORLD = f"""<sdf version="1.10"><world name="w">
<model name="m"><pose>0 0 2 0 0 0</pose>
<link name="a">{MASS}<collision name="c">{BOX}</collision><visual name="v">{BOX}</visual></link>
<link name="b">{MASS}</link>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>
</joint>
<link name="d">{MASS}</link><link name="e">{MASS}</link><link name="f">{MASS}</link>
<joint name="k" type="revolute"><parent>a</parent><child>d</child><axis><xyz>0 0 1</xyz></axis>
</joint>
<joint name="g" type="gearbox"><parent>b</parent><child>d</child>
<gearbox_reference_body>a</gearbox_reference_body></joint>
<joint name="u" type="universal"><parent>d</parent><child>e</child><axis/><axis2/></joint>
<joint name="s" type="screw"><parent>d</parent><child>f</child></joint></model>
<light name="l" type="spot"><pose>0 0 3 0.3 0 0</pose><attenuation/></light>
</world></sdf>"""
# Where each table of SDF begins in that.
HOLDERS = {
    "world": (sdf.WORLD, "world"),
    "model": (sdf.MODEL, "world/model"),
    "link": (sdf.LINK, "world/model/link"),
    "visual": (sdf.VISUAL, "world/model/link/visual"),
    "collision": (sdf.COLLISION, "world/model/link/collision"),
    "geometry": (sdf.GEOMETRY, "world/model/link/collision/geometry"),
    "joint": (sdf.JOINT, "world/model/joint"),
    "universal": (
        {path: entry for path, entry in sdf.JOINT_OF_TWO.items() if path.startswith("axis2")},
        "world/model/joint[@type='universal']",
    ),
    "screw": (
        {path: entry for path, entry in sdf.SCREW.items() if "thread" in path},
        "world/model/joint[@type='screw']",
    ),
    "gearbox": (
        {path: entry for path, entry in sdf.GEARBOX.items() if "gearbox" in path},
        "world/model/joint[@type='gearbox']",
    ),
    "light": (sdf.LIGHT, "world/light"),
}
# What acts together with something else alone, is a name, or says by a line what it lacks.
APART = {
    "model/self_collide": "of models with several links",
    "link/self_collide": "likewise",
    "geometry/mesh/submesh/name": "told by who reads meshes",
    "visual/material/pbr/metal/albedo_map": "told by who reads materials",
    "visual/material/pbr/specular/albedo_map": "likewise",
    "visual/material/ambient": "told where there is a <diffuse>",
    "world/spherical_coordinates/surface_model": "told where it is another one",
    "world/spherical_coordinates/world_frame_orientation": "likewise",
    "world/spherical_coordinates/heading_deg": "likewise",
    "joint/axis/use_parent_model_frame": "of joints that are turned",
    "joint/axis/dynamics/spring_reference": "of springs",
    "joint/axis/limit/effort": "of drives, which things in worlds have not",
    "joint/axis/limit/velocity": "likewise",
    "model/frame/pose": "of those that are relative to it",
    "geometry/heightmap/pos": "of pictures",
    "geometry/heightmap/size": "likewise",
    "geometry/heightmap/uri": "likewise",
    "world/frame/pose": "of those with a name",
    "collision/density": "where the mass is computed, as in Gazebo",
    "collision/surface/friction/ode/mu2": "told where it is another one than <mu>",
    "geometry/plane/size": "of what stands",
    "geometry/plane/normal": "likewise",
    "geometry/mesh/scale": "of meshes with a file",
    "gearbox/gearbox_reference_body": "there is one already",
    "joint/axis/mimic/multiplier": "of a joint that is there",
    "joint/axis/mimic/offset": "likewise",
    "joint/axis/mimic/reference": "likewise",
    "world/physics/gravity": "where the world has none, as in old files",
    "world/state/model/pose": "of the model that it names",
    "world/state/model/frame/pose": "nothing is relative to it",
    "world/state/model/link/pose": "told where there are several",
}  # fmt: skip
APART |= {path.replace("joint/axis/", "universal/axis2/"): why for path, why in APART.items()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a mesh."""
    found = tmp_path_factory.mktemp("tags")
    trimesh.creation.box().export(found / "box.stl")
    return found


def put(holder: Any, path: str, text: str, attribute: str = "") -> None:
    """Put a tag at a path below an element, with what is above it."""
    element = holder
    for name in filter(None, path.split("/")):
        if element.tag == "geometry" and element.find(name) is None:
            for shape in list(element):
                element.remove(shape)
        found = element.find(name)
        element = etree.SubElement(element, name) if found is None else found
    if attribute:
        element.set(attribute, text)
    elif path:
        element.text = text


def value(path: str) -> str:
    parts = path.replace("@", "/").split("/")
    for key in ("/".join(parts[-2:]), parts[-1]):
        if key in VALUES:
            return VALUES[key]
    return "0.37"


def leaves(table: Mapping[str, TagEntry]) -> Iterator[tuple[str, str, str]]:
    """The paths, attributes and fates of what holds a value."""
    inner = {path.rpartition("/")[0] for path in table if "@" not in path}
    for path, entry in table.items():
        tag, _, attribute = path.partition("@")
        if attribute or path not in inner:
            yield tag, attribute, entry.fate


def built(file: Path, root: Any) -> tuple[object, tuple[str, ...]]:
    """What is built of a world, and what is told of it."""
    file.write_bytes(etree.tostring(root))
    try:
        scene = read_world(file).scene
        assert scene is not None
        spec, warnings = scene_spec(scene)
        return (_bytes(spec.compile()), repr(scene.poses), scene.origin), (
            *scene.remarks,
            *warnings,
        )
    except TeleopctlError as error:
        return error.message, (error.message,)


def _bytes(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


OF_SDF = [
    (name, tag, attribute, fate)
    for name, (table, _) in HOLDERS.items()
    for tag, attribute, fate in leaves(table)
]


def test_what_sdf_has_acts_or_is_named(folder: Path) -> None:
    lost = []
    as_usual: dict[bytes, object] = {}
    for name, tag, attribute, fate in OF_SDF:
        where = f"{name}/{tag}".rstrip("/")
        if fate == "read by others" or attribute or where in APART or ":" in where:
            continue
        root, usual = etree.fromstring(WORLD), etree.fromstring(WORLD)
        below = HOLDERS[name][1]
        put(root.find(below), tag, value(where))
        put(usual.find(below), tag.rpartition("/")[0], "")
        after, told = built(folder / "w.sdf", root)
        text = etree.tostring(usual)
        if text not in as_usual:
            as_usual[text], _ = built(folder / "w.sdf", usual)
        before = as_usual[text]
        last = tag.rpartition("/")[2]
        above = [f"<{part}>" in line for line in told for part in tag.split("/")]
        named = any(above) or any(f"/{last}>" in line for line in told)
        placed = all(f"{folder / 'w.sdf'}:" in line for line in told)
        fine = (after != before and not named) if fate == "works" else (named and placed)
        if not fine:
            lost.append((where, fate, told))
    assert lost == [], "\n".join(map(str, lost))


SPOTS = {
    kind: f'<sensor name="s" type="{kind}">{{}}</sensor>'
    for kind in ("imu", "ray", "camera", "force_torque", "sonar", "contact", "magnetometer",
                 "altimeter", "air_pressure", "navsat")
}  # fmt: skip
PICTURE = (
    "<camera><horizontal_fov>1</horizontal_fov><image><width>8</width><height>8</height></image>"
    "</camera>"
)


def robot(*parts: str) -> str:
    link = (
        '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial><collision><geometry><sphere radius="0.1"/></geometry>'
        "</collision></link>"
    )
    joint = (
        '<joint name="j" type="revolute"><parent link="base"/><child link="tip"/>'
        '<origin xyz="0 0 1"/><limit effort="1" velocity="1" lower="-1" upper="1"/></joint>'
    )
    return (
        f'<robot name="r">{link.format("base")}{link.format("tip")}{joint}{"".join(parts)}</robot>'
    )


def told_of(urdf: str) -> list[str]:
    return [*unsupported_tags(urdf), *gazebo_only_tags(urdf), *unknown_tags(urdf)]


@pytest.mark.parametrize("kind", SPOTS)
def test_what_a_sensor_has_acts_or_is_named(kind: str) -> None:
    lost = []
    for tag, attribute, fate in leaves(gazebo.of_sensors(kind)):
        if fate == "read by others" or attribute:
            continue
        element = etree.fromstring(SPOTS[kind].format(PICTURE if kind == "camera" else ""))
        before = read_sensor(copy.deepcopy(element), "tip")
        if "/noise/" in tag:
            put(element, f"{tag.rpartition('/')[0]}/type", "gaussian")
            before = read_sensor(copy.deepcopy(element), "tip")
        # What a camera has of its lens counts together.
        for part in ("fx", "fy", "cx", "cy") if "intrinsics" in tag else ():
            put(element, f"camera/lens/intrinsics/{part}", "1")
        for part in ("p_fx", "p_fy") if "projection" in tag else ():
            put(element, f"camera/lens/projection/{part}", "1")
        put(element, tag, value(tag) if "noise/type" not in tag else "uniform")
        text = etree.tostring(element, encoding="unicode")
        told = told_of(robot(f'<gazebo reference="tip">{text}</gazebo>'))
        named = any(f"<{tag.rpartition('/')[2]}>" in line and "line 1" in line for line in told)
        acts = read_sensor(element, "tip") != before
        if named == (fate == "works") or (fate == "works" and not acts):
            lost.append((tag, fate, told))
    assert lost == [], "\n".join(map(str, lost))


CLOSING = (
    '<joint name="l" type="revolute"><parent>base</parent><child>tip</child>'
    "<pose>0 0.2 0 0 0 0</pose></joint>"
)


@pytest.mark.parametrize(
    ("reference", "table"),
    [("tip", gazebo.OF_LINKS), ("j", gazebo.OF_JOINTS), ("", gazebo.OF_ROBOTS)],
)
def test_what_gazebo_tags_have_acts_or_is_named(reference: str, table: Table) -> None:
    lost = []
    plain = built_robot(robot())
    for tag, attribute, fate in leaves(table):
        if (
            fate == "read by others"
            or attribute
            or tag.rpartition("/")[2] in ("mu2", "self_collide")
        ):
            continue
        element = etree.fromstring("<gazebo/>")
        if reference:
            element.set("reference", reference)
        if tag in ("joint/parent", "joint/child"):
            continue  # without them it is none
        if tag.startswith("joint/"):
            element.append(etree.fromstring(CLOSING))
            plain = built_robot(robot(etree.tostring(element, encoding="unicode")))
        if tag == "springReference":
            put(element, "springStiffness", "3")
            plain = built_robot(robot(etree.tostring(element, encoding="unicode")))
        # This robot is fixed unless it says otherwise.
        off = tag == "gravity" or (tag == "static" and not reference)
        put(element, tag, "false" if off else value(tag))
        urdf = robot(etree.tostring(element, encoding="unicode"))
        told = told_of(urdf)
        named = any(f"<{tag.rpartition('/')[2]}>" in line and "line 1" in line for line in told)
        fine = (built_robot(urdf) != plain and not told) if fate == "works" else named
        if not fine:
            lost.append((tag, fate, told))
    assert lost == [], "\n".join(map(str, lost))


def built_robot(urdf: str) -> tuple[object, ...]:
    model = build_model(RobotDescription.from_urdf(urdf))
    return _bytes(model.mj_model), model.weightless


FULL = robot(
    '<material name="red"><color rgba="1 0 0 1"/></material>',
    '<gazebo reference="tip"><mu1>0.3</mu1><mu2>0.3</mu2><sensor name="s" type="camera">'
    f"{PICTURE}<update_rate>3</update_rate></sensor><sensor name='i' type='imu'><imu>"
    "<angular_velocity><x><noise><stddev>1</stddev></noise></x></angular_velocity></imu></sensor>"
    '</gazebo><gazebo reference="j"><springStiffness>1</springStiffness></gazebo>',
    '<ros2_control name="h" type="system"><hardware><plugin>mock_components/GenericSystem</plugin>'
    '<param name="a">1</param></hardware><joint name="j"><command_interface name="position">'
    '<param name="min">-1</param></command_interface><state_interface name="position"/></joint>'
    '<transmission name="t"><plugin>x</plugin><joint name="j" role="r"/></transmission>'
    "</ros2_control>",
)
# Where others than the tables find out: these raise, or have any tag that their plug-in likes.
ODD = {"ros2_control", "hardware", "plugin", "param"}
NAMES = st.from_regex(r"[a-z]{3}_[a-z]{2,8}", fullmatch=True)


@given(st.data(), NAMES, st.booleans())
def test_what_no_description_has_is_named_wherever_it_stands(
    data: st.DataObject, name: str, is_attribute: bool
) -> None:
    assert told_of(FULL) == []
    root = etree.fromstring(FULL)
    places = [e for e in root.iter("*") if is_attribute or e.tag not in ODD]
    holder = data.draw(st.sampled_from(places))
    if is_attribute:
        holder.set(name, "7")
    else:
        holder.insert(data.draw(st.integers(0, len(holder))), etree.Element(name))
    told = told_of(etree.tostring(root, encoding="unicode"))
    assert any(name in line and "line 1" in line for line in told) or holder.tag == "geometry"


@given(st.data(), NAMES, st.booleans())
def test_what_no_world_has_is_named_wherever_it_stands(
    folder: Path, data: st.DataObject, name: str, is_attribute: bool
) -> None:
    file = folder / "full.sdf"
    assert built(file, etree.fromstring(WORLD))[1] == ()
    root = etree.fromstring(WORLD)
    holder = data.draw(st.sampled_from(list(root.iter("*"))))
    if is_attribute:
        holder.set(name, "7")
    else:
        holder.append(etree.Element(name))
    told = built(file, root)[1]
    assert any(name in line and line.startswith(f"{file}:") for line in told)


@pytest.mark.parametrize(
    ("tag", "is_repeated"),
    [
        ("<a>0.0e0</a>", True),
        ("<a>0 -0 0.0</a>", True),
        ("<a>False</a>", True),
        ("<a value='0'/>", True),
        ("<a>true</a>", False),
        ("<a>1e-9</a>", False),
        ("<a/>", False),
        ("<a><!-- none --><type>gaussian</type><mean>0</mean><stddev>0.0</stddev></a>", True),
        ("<a><shadows>false</shadows></a>", False),
    ],
)
def test_zero_and_false_are_the_default_of_a_tag_that_says_no_other(
    tag: str, is_repeated: bool
) -> None:
    assert is_default(etree.fromstring(tag)) == is_repeated
