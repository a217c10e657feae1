"""Conversion of an MJCF file to URDF: links and joints for tf, display and controllers.

Physics uses the MJCF file itself, which the URDF names, so that tendons, contact pairs and other
elements that URDF cannot express are not lost.

A MuJoCo body may have several joints: each joint but the last gets a link of its own, and so does
the last one if its axis does not pass through the body's origin.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from lxml import etree

from teleopctl.robot.meshes import cached_stl, unit_sphere_stl
from teleopctl.robot.mjcf.actuators import (
    SINGLE_AXIS,
    ActuatorPair,
    JointActuator,
    actuator_pairs,
    equality_mimics,
    joint_actuators,
)
from teleopctl.robot.mjcf.mjcf_file import WORLD, Mjcf, free_joint, joints_of, load_mjcf
from teleopctl.robot.mjcf.sensors import sensor_tags
from teleopctl.robot.repair import REMARK
from teleopctl.robot.simulated_hardware import SIMULATOR
from teleopctl.robot.urdf import Mimic
from teleopctl.robot.urdf_text import add_origin, numbers, transform
from teleopctl.robot.xacro.expansion import ExpandedXacro
from teleopctl.tf import Transform, quaternion_from_axis_angle

_Kind = mujoco.mjtGeom
# Geom groups from here on are hidden in MuJoCo's own viewer: mostly collision shapes.
_FIRST_HIDDEN_GROUP = 3
# MuJoCo's colour of a geom whose file gives none; then the colour of its material is used.
_UNSET_RGBA = np.array([0.5, 0.5, 0.5, 1.0], np.float32)
_READ_BY_ALL = (".stl", ".obj")


def add_shapes(link: etree._Element, mjcf: Mjcf, body: int) -> list[str]:
    """Add a MuJoCo body's geometry to its URDF link; return sentences on geoms left out.

    Returns:
        A sentence for each geom that URDF cannot express.
    """
    m = mjcf.model
    remarks = []
    first = int(m.body_geomadr[body])
    for geom in range(first, first + int(m.body_geomnum[body])):
        touches = bool(m.geom_contype[geom] or m.geom_conaffinity[geom])
        drawn = int(m.geom_group[geom]) < _FIRST_HIDDEN_GROUP and _color(m, geom)[3] > 0.0
        shape = _shape(mjcf, geom) if drawn or touches else None
        if shape is None:
            if drawn or touches:
                kind = _Kind(int(m.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
                remarks.append(f"A {kind} of link '{link.get('name')}' is simulated, not shown")
            continue
        for tag, wanted in (("visual", drawn), ("collision", touches)):
            if not wanted:
                continue
            element = etree.SubElement(link, tag)
            place, attributes = shape
            add_origin(element, place)
            geometry = etree.SubElement(element, "geometry")
            etree.SubElement(geometry, attributes[0], attributes[1])
            if tag == "visual":
                rgba = _color(m, geom)
                # One name for one colour, since a name means one material.
                material = etree.SubElement(element, "material", name=f"rgba {numbers(*rgba)}")
                etree.SubElement(material, "color", rgba=numbers(*rgba))
    return remarks


_Shape = tuple[Transform, tuple[str, dict[str, str]]]


def _shape(mjcf: Mjcf, geom: int) -> _Shape | None:
    """Return a geom's pose, and tag and attributes of its URDF geometry; None if URDF has none."""
    m = mjcf.model
    place = transform(m.geom_pos[geom], m.geom_quat[geom])
    a, b, c = (float(size) for size in m.geom_size[geom])
    match m.geom_type[geom]:
        case _Kind.mjGEOM_BOX:
            return place, ("box", {"size": numbers(2 * a, 2 * b, 2 * c)})
        case _Kind.mjGEOM_SPHERE:
            return place, ("sphere", {"radius": numbers(a)})
        case _Kind.mjGEOM_CYLINDER:
            return place, ("cylinder", {"radius": numbers(a), "length": numbers(2 * b)})
        case _Kind.mjGEOM_CAPSULE:
            return place, ("capsule", {"radius": numbers(a), "length": numbers(2 * b)})
        case _Kind.mjGEOM_ELLIPSOID:
            return place, (
                "mesh",
                {"filename": unit_sphere_stl().as_uri(), "scale": numbers(a, b, c)},
            )
        case _Kind.mjGEOM_MESH | _Kind.mjGEOM_SDF if m.geom_dataid[geom] >= 0:
            return _mesh(mjcf, int(m.geom_dataid[geom]), place)
        case _:
            return None


def _mesh(mjcf: Mjcf, mesh: int, place: Transform) -> _Shape:
    """Return a mesh geometry with the mesh's own file, or with a converted STL if needed."""
    m = mjcf.model
    element = mjcf.spec.mesh(m.mesh(mesh).name)
    file = _file_of(mjcf, element)
    if file is not None and _is_plain(element):
        # MuJoCo moves a mesh into the frame of its inertia, and the geom by the inverse.
        own = transform(m.mesh_pos[mesh], m.mesh_quat[mesh])
        scale = numbers(*(float(value) for value in element.scale))
        return place @ own.inverse(), ("mesh", {"filename": file.as_uri(), "scale": scale})
    first, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
    start, faces = int(m.mesh_faceadr[mesh]), int(m.mesh_facenum[mesh])
    made = cached_stl(m.mesh_vert[first : first + count], m.mesh_face[start : start + faces])
    return place, ("mesh", {"filename": made.as_uri()})


def _file_of(mjcf: Mjcf, mesh: Any) -> Path | None:
    """Return the path of a mesh's file, or None if it has none or the file is missing."""
    if not mesh.file:
        return None
    spec = mjcf.spec
    name = Path(mesh.file).name if spec.strippath else mesh.file
    file = mjcf.path.parent / (spec.meshdir or "") / name
    return file.resolve() if file.is_file() else None


def _is_plain(mesh: Any) -> bool:
    """Return whether a mesh is its file's content, scaled only, in a format that all read."""
    still = not np.any(mesh.refpos) and np.allclose(mesh.refquat, [1.0, 0.0, 0.0, 0.0])
    return still and Path(mesh.file).suffix.lower() in _READ_BY_ALL


def _color(m: Any, geom: int) -> tuple[float, ...]:
    rgba, material = m.geom_rgba[geom], int(m.geom_matid[geom])
    if material >= 0 and np.array_equal(rgba, _UNSET_RGBA):
        rgba = m.mat_rgba[material]
    return tuple(round(float(part), 4) for part in rgba)


_SYSTEM = "MjcfSystem"
# MuJoCo's default model name.
_UNNAMED = "MuJoCo Model"

_SLIDE, _BALL = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_BALL
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_NOWHERE = Transform()


def mjcf_as_urdf(path: Path) -> ExpandedXacro:
    """Convert an MJCF file to URDF; return text and files read as an `ExpandedXacro`.

    Raises:
        InvalidDescriptionError: See `load_mjcf`.
    """
    mjcf = load_mjcf(path)
    m, name = mjcf.model, mjcf.spec.modelname
    robot = etree.Element("robot", name=path.stem if name in ("", _UNNAMED) else name)
    # <mujoco> is the URDF element for MuJoCo's settings; the attribute `file` is an extension.
    etree.SubElement(robot, "mujoco", file=mjcf.path.as_uri())
    pairs = actuator_pairs(m)
    actuators, _ = joint_actuators(m, {name for pair in pairs for name in pair.actuators})
    for remark in _add_links(robot, mjcf):
        etree.SubElement(robot, REMARK).text = remark
    _add_joints(robot, mjcf, actuators, pairs)
    if robot.find("joint[axis]") is not None:
        _add_control(robot, mjcf, actuators, pairs)
        if not m.nu:
            etree.SubElement(
                robot, REMARK
            ).text = (
                f"{path.name} has no <actuator>: nothing drives its joints, which take no commands"
            )
    robot.extend(sensor_tags(mjcf)[0])
    etree.indent(robot)
    files = dict.fromkeys((mjcf.path, *_included(mjcf.path)))
    return ExpandedXacro(etree.tostring(robot, encoding="unicode"), tuple(files))


def _included(path: Path) -> list[Path]:
    """Return the files that an MJCF file includes, also indirectly."""
    found = []
    # MuJoCo accepts what XML forbids, such as two hyphens in a comment.
    parser = etree.XMLParser(recover=True, resolve_entities=False)
    for element in etree.parse(str(path), parser).iter("include"):
        file = (path.parent / (element.get("file") or "")).resolve()
        if file.is_file():
            found += [file, *_included(file)]
    return found


def _add_links(robot: etree._Element, mjcf: Mjcf) -> list[str]:
    """Add the links; return sentences about geoms that URDF cannot express."""
    m, remarks = mjcf.model, list[str]()
    if mjcf.root == WORLD:
        etree.SubElement(robot, "link", name=WORLD)
    for body in mjcf.bodies():
        link = etree.SubElement(robot, "link", name=m.body(body).name)
        mass = float(m.body_mass[body])
        if mass > 0.0:
            inertial = etree.SubElement(link, "inertial")
            add_origin(inertial, transform(m.body_ipos[body], m.body_iquat[body]))
            etree.SubElement(inertial, "mass", value=numbers(mass))
            xx, yy, zz = (numbers(float(moment)) for moment in m.body_inertia[body])
            zero = {"ixy": "0", "ixz": "0", "iyz": "0"}
            etree.SubElement(inertial, "inertia", {"ixx": xx, "iyy": yy, "izz": zz, **zero})
        remarks += add_shapes(link, mjcf, body)
    return remarks


def _add_joints(
    robot: etree._Element, mjcf: Mjcf, actuators: list[JointActuator], pairs: list[ActuatorPair]
) -> None:
    m, start = mjcf.model, mjcf.start()
    commanded = {actuator.joint for actuator in actuators}
    commanded.update(joint for pair in pairs for joint in pair.joints)
    mimics = {name: mimic for name, mimic in equality_mimics(m).items() if name not in commanded}
    for body in mjcf.bodies():
        name, parent = m.body(body).name, m.body(int(m.body_parentid[body])).name
        place = transform(m.body_pos[body], m.body_quat[body])
        free = free_joint(m, body)
        if free is not None:
            if name != mjcf.root:
                first = int(m.jnt_qposadr[free])
                place = transform(start.qpos[first : first + 3], start.qpos[first + 3 : first + 7])
                _add_joint(robot, m.joint(free).name, "floating", parent, name, place)
            continue
        for number, joint in enumerate(joints_of(m, body)):
            link = f"{m.joint(joint).name}_link"
            place = place @ Transform(tuple(m.jnt_pos[joint].tolist()))
            last = number == int(m.body_jntnum[body]) - 1
            if last and not m.jnt_pos[joint].any():
                link = name
            else:
                etree.SubElement(robot, "link", name=link)
            if m.jnt_type[joint] == _BALL:
                _add_ball(robot, m.joint(joint).name, (parent, link), place)
            else:
                _add_moving(robot, m, joint, (parent, link), place, mimics, actuators)
            place = Transform(tuple((-m.jnt_pos[joint]).tolist()))
            parent = link
        if parent != name:
            _add_joint(robot, f"{parent}_to_{name}", "fixed", parent, name, place)


def _add_joint(
    robot: etree._Element, name: str, kind: str, parent: str, child: str, place: Transform
) -> etree._Element:
    joint = etree.SubElement(robot, "joint", name=name, type=kind)
    add_origin(joint, place)
    etree.SubElement(joint, "parent", link=parent)
    etree.SubElement(joint, "child", link=child)
    return joint


def _add_ball(robot: etree._Element, name: str, links: tuple[str, str], place: Transform) -> None:
    """Add a ball joint, which URDF does not have, as turns about x, then y, then z."""
    parent, child = links
    for turn, axis in zip(ball_joint_names(name), _AXES.values(), strict=True):
        link = child if axis[2] else f"{turn}_link"
        if link != child:
            etree.SubElement(robot, "link", name=link)
        element = _add_joint(robot, turn, "continuous", parent, link, place)
        etree.SubElement(element, "axis", xyz=numbers(*axis))
        parent, place = link, _NOWHERE


def ball_joint_names(name: str) -> tuple[str, ...]:
    """Return the names of the three URDF joints that replace a ball joint, about x, y and z."""
    return tuple(f"{name}_{axis}" for axis in _AXES)


# Any: MuJoCo's model.
def _add_moving(
    robot: etree._Element,
    m: Any,
    joint: int,
    links: tuple[str, str],
    place: Transform,
    mimics: dict[str, Mimic],
    actuators: list[JointActuator],
) -> None:
    """Add a joint along or about one axis."""
    name = m.joint(joint).name
    axis = tuple(m.jnt_axis[joint].tolist())
    # An MJCF file has the robot at the joint's `ref`, a URDF at the joint's zero.
    ref = float(m.qpos0[m.jnt_qposadr[joint]])
    slides = m.jnt_type[joint] == _SLIDE
    if slides:
        place = place @ Transform(tuple(-ref * value for value in axis))
    else:
        place = place @ Transform(rotation=quaternion_from_axis_angle(axis, -ref))
    limited = bool(m.jnt_limited[joint])
    kind = "prismatic" if slides else "revolute" if limited else "continuous"
    element = _add_joint(robot, name, kind, *links, place)
    etree.SubElement(element, "axis", xyz=numbers(*axis))
    lower, upper = m.jnt_range[joint].tolist() if limited else (0.0, 0.0)
    own = [actuator for actuator in actuators if actuator.joint == name]
    effort = max((actuator.effort for actuator in own), default=0.0)
    if m.jnt_actfrclimited[joint]:
        # MuJoCo clamps the sum of the actuators' forces to this range; an effort of 0 is no limit.
        most = max(map(abs, m.jnt_actfrcrange[joint].tolist()))
        effort = min(effort or most, most)
    speed = max((a.most for a in own if a.interface == "velocity"), default=0.0)
    etree.SubElement(
        element,
        "limit",
        lower=numbers(lower),
        upper=numbers(upper),
        effort=numbers(effort),
        velocity=numbers(speed),
    )
    dof = int(m.jnt_dofadr[joint])
    damping, friction = float(m.dof_damping[dof]), float(m.dof_frictionloss[dof])
    if damping or friction:
        etree.SubElement(element, "dynamics", damping=numbers(damping), friction=numbers(friction))
    if name in mimics:
        mimic = mimics[name]
        etree.SubElement(
            element,
            "mimic",
            joint=mimic.joint,
            multiplier=numbers(mimic.multiplier),
            offset=numbers(mimic.offset),
        )


def _add_control(
    robot: etree._Element, mjcf: Mjcf, actuators: list[JointActuator], pairs: list[ActuatorPair]
) -> None:
    """Add a ``<ros2_control>`` system with command interfaces for the file's actuators."""
    m, start = mjcf.model, mjcf.start()
    system = etree.SubElement(robot, "ros2_control", name=_SYSTEM, type="system")
    etree.SubElement(etree.SubElement(system, "hardware"), "plugin").text = SIMULATOR
    for number in range(m.njnt):
        name = m.joint(number).name
        if m.jnt_type[number] == _BALL:
            for turn in ball_joint_names(name):
                joint = etree.SubElement(system, "joint", name=turn)
                for state in ("position", "velocity"):
                    etree.SubElement(joint, "state_interface", name=state)
        if int(m.jnt_type[number]) not in SINGLE_AXIS:
            continue
        joint = etree.SubElement(system, "joint", name=name)
        commands = [actuator.interface for actuator in actuators if actuator.joint == name]
        commands += [pair.interface for pair in pairs if name in pair.joints]
        for command in commands:
            etree.SubElement(joint, "command_interface", name=command)
        position = etree.SubElement(joint, "state_interface", name="position")
        value = numbers(float(start.qpos[m.jnt_qposadr[number]]))
        etree.SubElement(position, "param", name="initial_value").text = value
        for state in ("velocity", "effort"):
            etree.SubElement(joint, "state_interface", name=state)
    for pair in pairs:
        _add_transmission(system, pair)


def _add_transmission(system: etree._Element, pair: ActuatorPair) -> None:
    """Add the ``<transmission>`` through which two actuators move two joints together."""
    element = etree.SubElement(system, "transmission", name="_".join(pair.actuators))
    etree.SubElement(element, "plugin").text = f"transmission_interface/{pair.kind}"
    for tag, names, reductions in (
        ("actuator", pair.actuators, pair.actuator_reductions),
        ("joint", pair.joints, pair.joint_reductions),
    ):
        for number, (name, reduction) in enumerate(zip(names, reductions, strict=True), 1):
            end = etree.SubElement(element, tag, name=name, role=f"{tag}{number}")
            etree.SubElement(end, "mechanical_reduction").text = numbers(reduction)
