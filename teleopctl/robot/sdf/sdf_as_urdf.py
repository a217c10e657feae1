"""Conversion of an SDF model, a robot described for Gazebo only, to URDF.

In URDF the frame of a link is that of its joint; in SDF the two may differ. So each link gets the
frame of its joint, as in ROS's own SDF parser, and the content of the link keeps its place.
URDF has no ball joints: a ball that carries no link, such as a caster, slides instead of rolling.
Ellipsoids become meshes; planes and heightmaps are left out, with a remark. Gazebo's additions to
URDF, such as springs, are written to ``<gazebo>``.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from lxml import etree

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.meshes import unit_sphere_stl
from teleopctl.robot.repair import REMARK
from teleopctl.robot.scene.loops import add_loop, loop_of, tree_and_loops
from teleopctl.robot.scene.scene import (
    SceneBody,
    SceneJoint,
    SceneModel,
    SceneSensor,
    SceneShape,
)
from teleopctl.robot.scene.surface import Across, add_surface
from teleopctl.robot.sdf.sdf_file import read_sdf
from teleopctl.robot.urdf import UNLIMITED
from teleopctl.robot.urdf_text import add_origin, numbers, pose_text
from teleopctl.robot.xacro.expansion import ExpandedXacro
from teleopctl.robot.xacro.source_lines import source_places
from teleopctl.tf import Transform, rotate

_NO_FORM = frozenset({"plane", "heightmap"})
# Attribute with the source file of an element, until the text is written.
_FILE = "teleopctl-file"
_TYPES = {"revolute": "revolute", "prismatic": "prismatic", "fixed": "fixed"}
# Limit of a range that is open on one side, rad or m: URDF has only ranges with two ends.
_FAR = 1e6


def sdf_as_urdf(path: Path) -> ExpandedXacro:
    """Convert an SDF file with one model to URDF; return text, files and source lines.

    Raises:
        InvalidDescriptionError: The file cannot be read, or is no robot; the message names the
            file.
    """
    scene = read_sdf(path)
    if not scene.is_model:
        raise InvalidDescriptionError(
            f"{path}: it is a world with {len(scene.models)} models, and no robot",
            hint="Load a world with world:=FILE.",
        )
    (model,) = scene.models
    robot = etree.Element("robot", name=model.name or path.stem)
    tree, closing = tree_and_loops(map(_held, model.joints), model.bodies)
    model = replace(model, joints=tuple(tree))
    for remark in (*scene.remarks, *_without_form(scene.models[0]), *_divided(model)):
        # `repair_urdf` reports these remarks.
        etree.SubElement(robot, REMARK).text = remark
    parents = {joint.parent for joint in model.joints}
    parents |= {end for joint in closing for end in (joint.parent, joint.child)}
    casters = {j.child for j in model.joints if j.kind == "ball" and j.child not in parents}
    moved_by = {joint.child: joint for joint in model.joints}
    frames = {
        name: moved_by[name].pose if name in moved_by else body.pose
        for name, body in model.bodies.items()
    }
    for body in model.bodies.values():
        _add_link(robot, body, frames[body.name].inverse() @ body.pose)
    # Joints to the world start at the world's origin.
    frames["world"] = model.pose.inverse()
    _add_world(robot, model, frames)
    for joint in model.joints:
        rolls = joint.kind == "ball" and joint.child in casters
        if joint.kind == "ball":
            etree.SubElement(robot, REMARK).text = _of_ball(joint, rolls=rolls)
        _add_joint(robot, replace(joint, kind="fixed") if rolls else joint, frames)
    for joint in closing:
        # The child of a joint that closes a loop may be the world.
        loop = loop_of(joint, frames.get(joint.child, Transform()))
        if loop is None:
            remark = f"{joint.place}: joint '{joint.name}' is left out: it slides and closes a loop"
            etree.SubElement(robot, REMARK).text = remark
        else:
            add_loop(robot, loop)
    _add_gazebo(robot, model, frames, casters)
    etree.indent(robot)
    # New elements have no source.
    written = [
        (Path(e.attrib.pop(_FILE)), e.sourceline) if _FILE in e.attrib else None
        for e in robot.iter("*")
    ]
    text: str = etree.tostring(robot, encoding="unicode")
    return ExpandedXacro(text, scene.files, source_places(text, written))


def _without_form(model: SceneModel) -> Iterator[str]:
    """Yield a sentence for each part of the model that URDF cannot express."""
    for body in model.bodies.values():
        for shape in body.shapes:
            if shape.kind in _NO_FORM:
                yield (
                    f"{shape.place}: the {shape.kind} of link '{body.name}' is left out: "
                    "a robot has none, a world may"
                )
            if shape.density is not None and body.inertial is None:
                yield f"{shape.place}: the <density> in link '{body.name}' is read as that of water"
    for joint in model.joints:
        if _is_held(joint):
            yield f"{joint.place}: joint '{joint.name}' is a fixed one: its range is one point, 0"


def _divided(model: SceneModel) -> Iterator[str]:
    """Yield a sentence for each joint of the file that became two joints."""
    parts: dict[tuple[str, str], list[SceneJoint]] = {}
    for joint in model.joints:
        if joint.part_of:
            parts.setdefault((joint.part_of, joint.place), []).append(joint)
    for (what, place), (first, second) in parts.items():
        if first.mimic is not None:
            yield (
                f"{place}: the {what} becomes two joints: '{second.name}' turns, "
                f"'{first.name}' slides with it"
            )
        else:
            yield (
                f"{place}: the {what} becomes two joints: '{first.name}' turns about its first "
                f"axis, '{second.name}' about its second"
            )


def _is_held(joint: SceneJoint) -> bool:
    """Return whether a joint's range is 0 to 0, which in URDF would mean no limits."""
    return joint.kind in ("revolute", "prismatic") and joint.lower == joint.upper == 0.0


def _held(joint: SceneJoint) -> SceneJoint:
    return replace(joint, kind="fixed") if _is_held(joint) else joint


def _of_ball(joint: SceneJoint, *, rolls: bool) -> str:
    """Return a sentence about the conversion of a ball joint."""
    became = (
        f"is a fixed one: '{joint.child}' slides without friction instead of rolling"
        if rolls
        else "is a floating one, which is shown and not simulated"
    )
    return f"{joint.place}: the ball joint '{joint.name}' {became}"


def _add_link(robot: etree._Element, body: SceneBody, place: Transform) -> None:
    link = etree.SubElement(robot, "link", name=body.name)
    if body.inertial is not None:
        inertial = etree.SubElement(link, "inertial")
        add_origin(inertial, place @ body.inertial.pose)
        etree.SubElement(inertial, "mass", value=numbers(body.inertial.mass))
        axes = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        moments = zip(axes, map(numbers, body.inertial.moments), strict=True)
        etree.SubElement(inertial, "inertia", dict(moments))
    for shape in body.shapes:
        written = _geometry(shape)
        if written is None:
            continue
        element = etree.SubElement(link, "collision" if shape.touches else "visual")
        add_origin(element, place @ shape.pose)
        etree.SubElement(etree.SubElement(element, "geometry"), written[0], written[1])
        if shape.rgba is not None:
            material = etree.SubElement(element, "material", name=f"rgba {numbers(*shape.rgba)}")
            etree.SubElement(material, "color", rgba=numbers(*shape.rgba))


def _geometry(shape: SceneShape) -> tuple[str, dict[str, str]] | None:
    a, b, _ = shape.size
    match shape.kind:
        case "box":
            return "box", {"size": numbers(*shape.size)}
        case "sphere":
            return "sphere", {"radius": numbers(a)}
        case "cylinder" | "capsule":
            return shape.kind, {"radius": numbers(a), "length": numbers(b)}
        case "ellipsoid":
            return "mesh", {"filename": unit_sphere_stl().as_uri(), "scale": numbers(*shape.size)}
        case "mesh" if shape.file is not None:
            return "mesh", {"filename": shape.file.as_uri(), "scale": numbers(*shape.size)}
    return None


def _add_world(robot: etree._Element, model: SceneModel, frames: dict[str, Transform]) -> None:
    """Add the world as a link, if the model is static or has a joint to the world."""
    starts = {joint.parent for joint in model.joints} - set(model.bodies)
    if model.static and "world" not in starts:
        roots = set(model.bodies) - {joint.child for joint in model.joints}
        for name in sorted(roots):
            joint = SceneJoint(f"world_to_{name}", "fixed", "world", name, frames[name])
            _add_joint(robot, joint, frames)
        starts.add("world")
    if "world" in starts:
        etree.SubElement(robot, "link", name="world")


def _add_joint(robot: etree._Element, joint: SceneJoint, frames: dict[str, Transform]) -> None:
    kind = _TYPES.get(joint.kind, "floating")
    is_endless = math.isinf(joint.lower) and math.isinf(joint.upper)
    if kind == "revolute" and is_endless:
        kind = "continuous"
    element = etree.SubElement(robot, "joint", name=joint.name, type=kind)
    parent = frames.get(joint.parent, Transform())
    add_origin(element, parent.inverse() @ frames.get(joint.child, Transform()))
    etree.SubElement(element, "parent", link=joint.parent)
    etree.SubElement(element, "child", link=joint.child)
    if kind in ("fixed", "floating"):
        return
    etree.SubElement(element, "axis", xyz=numbers(*joint.axis))
    # Zero means no limit for effort and speed, and a range from 0 to 0 no limits of the position.
    limit = {
        "effort": numbers(joint.effort if math.isfinite(joint.effort) else 0.0),
        "velocity": numbers(joint.velocity if math.isfinite(joint.velocity) else 0.0),
        "lower": numbers(0.0 if is_endless else max(joint.lower, -_FAR)),
        "upper": numbers(0.0 if is_endless else min(joint.upper, _FAR)),
    }
    if math.isinf(joint.effort):
        limit[UNLIMITED] = "effort"
    etree.SubElement(element, "limit", limit)
    if joint.mimic is not None:
        etree.SubElement(
            element,
            "mimic",
            joint=joint.mimic.joint,
            multiplier=numbers(joint.mimic.multiplier),
            offset=numbers(joint.mimic.offset),
        )
    etree.SubElement(
        element, "dynamics", damping=numbers(joint.damping), friction=numbers(joint.friction)
    )


# Any, here and below: lxml elements, whose class has no types.
def _add_gazebo(
    robot: Any, model: SceneModel, frames: dict[str, Transform], casters: set[str]
) -> None:
    """Add ``<gazebo>`` elements, which only simulators read: sensors, friction, plug-ins."""
    for body in model.bodies.values():
        place = frames[body.name].inverse() @ body.pose
        rough = [s.friction for s in body.shapes if s.friction is not None]
        if body.name in casters:
            rough = [0.0]
        ways = [s.across for s in body.shapes if s.across is not None]
        surfaces = [s.surface for s in body.shapes if s.surface is not None]
        if not (body.sensors or rough or surfaces or ways) and body.gravity and body.self_collides:
            continue
        element = etree.SubElement(robot, "gazebo", reference=body.name)
        for sensor in body.sensors:
            element.append(_sensor(sensor, place))
        if rough:
            for tag in ("mu1", "mu2"):
                etree.SubElement(element, tag).text = numbers(min(rough))
        if ways and body.name not in casters:
            _add_way(element, ways[0], body, model, frames)
        if surfaces:
            # A link in <gazebo> has one surface for all its shapes.
            add_surface(etree.SubElement(element, "collision"), surfaces[0])
        if not body.gravity:
            etree.SubElement(element, "gravity").text = "false"
        if not body.self_collides:
            etree.SubElement(element, "selfCollide").text = "false"
    for joint in model.joints:
        if joint.sensors or joint.stiffness:
            element = etree.SubElement(robot, "gazebo", reference=joint.name)
            if joint.stiffness:
                etree.SubElement(element, "springStiffness").text = numbers(joint.stiffness)
                etree.SubElement(element, "springReference").text = numbers(joint.relaxed)
            for sensor in joint.sensors:
                element.append(_sensor(sensor, Transform()))
    if model.plugins:
        element = etree.SubElement(robot, "gazebo")
        for plugin in model.plugins:
            element.append(_noted(plugin))


def _add_way(
    element: Any, way: Across, body: SceneBody, model: SceneModel, frames: dict[str, Transform]
) -> None:
    """Write ``<fdir1>`` in the link's URDF frame, and the friction across it as ``<mu2>``."""
    for tag in element.findall("mu2"):
        element.remove(tag)
    etree.SubElement(element, "mu2").text = numbers(way.coefficient)
    link = way.link if way.link in model.bodies else body.name
    turn = (frames[link].inverse() @ model.bodies[link].pose).rotation
    direction = etree.SubElement(element, "fdir1", expressed_in=way.link or link)
    direction.text = numbers(*rotate(turn, way.along))


def _noted(element: Any) -> Any:
    """Return a copy of an element in which every element has its source file as an attribute."""
    made = copy.deepcopy(element)
    for part in made.iter("*"):
        part.set(_FILE, element.base)
    return made


def _sensor(sensor: SceneSensor, place: Transform) -> Any:
    """Return a ``<sensor>`` element with its pose in the link's URDF frame."""
    made = _noted(sensor.element)
    for pose in made.findall("pose"):
        made.remove(pose)
    etree.SubElement(made, "pose").text = pose_text(place @ sensor.pose)
    return made
