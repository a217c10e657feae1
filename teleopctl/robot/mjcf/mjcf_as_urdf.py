"""An MJCF file as URDF: its links and joints, for frames, pictures and controllers.

Physics does not come from this text but from the file, which the text names. So what URDF has no
words for, such as tendons, contact pairs and springs, is lost to nobody.

A body of MuJoCo's may hang on several joints, each with its own place in it: each but the last
gets a link of its own, and where the last does not turn about the body's origin, so does that.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
from lxml import etree

from teleopctl.robot.mjcf.actuators import (
    SINGLE_AXIS,
    JointActuator,
    file_mimics,
    joint_actuators,
)
from teleopctl.robot.mjcf.mjcf_file import WORLD, Mjcf, free_joint, joints_of, load_mjcf
from teleopctl.robot.mjcf.sensors import sensor_tags
from teleopctl.robot.mjcf.shapes import add_shapes
from teleopctl.robot.repair import REMARK
from teleopctl.robot.simulated_hardware import SIMULATOR
from teleopctl.robot.urdf import Mimic
from teleopctl.robot.urdf_text import add_origin, numbers, transform
from teleopctl.robot.xacro.expansion import ExpandedXacro
from teleopctl.tf import Transform, quaternion_from_axis_angle

_SYSTEM = "MjcfSystem"
# What MuJoCo calls a model that has no name.
_UNNAMED = "MuJoCo Model"

_SLIDE, _BALL = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_BALL
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_NOWHERE = Transform()


def mjcf_as_urdf(path: Path) -> ExpandedXacro:
    """Read an MJCF file as URDF.

    Raises:
        InvalidDescriptionError: See `load_mjcf`.
    """
    mjcf = load_mjcf(path)
    m, name = mjcf.model, mjcf.spec.modelname
    robot = etree.Element("robot", name=path.stem if name in ("", _UNNAMED) else name)
    # The element in which URDF speaks to MuJoCo, which has no such attribute itself.
    etree.SubElement(robot, "mujoco", file=mjcf.path.as_uri())
    actuators, _ = joint_actuators(m)
    for remark in _add_links(robot, mjcf):
        etree.SubElement(robot, REMARK).text = remark
    _add_joints(robot, mjcf, actuators)
    if robot.find("joint[axis]") is not None:
        _add_control(robot, mjcf, actuators)
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
    """The files that an MJCF file includes, which are there: MuJoCo has read them."""
    found = []
    # MuJoCo reads what XML forbids, such as two hyphens in a comment.
    parser = etree.XMLParser(recover=True, resolve_entities=False)
    for element in etree.parse(str(path), parser).iter("include"):
        file = (path.parent / (element.get("file") or "")).resolve()
        if file.is_file():
            found += [file, *_included(file)]
    return found


def _add_links(robot: etree._Element, mjcf: Mjcf) -> list[str]:
    """Add the links; returns what of them URDF has no form for."""
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


def _add_joints(robot: etree._Element, mjcf: Mjcf, actuators: list[JointActuator]) -> None:
    m, start = mjcf.model, mjcf.start()
    commanded = {actuator.joint for actuator in actuators}
    mimics = {name: mimic for name, mimic in file_mimics(m).items() if name not in commanded}
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
    for turn, axis in zip(ball_turns(name), _AXES.values(), strict=True):
        link = child if axis[2] else f"{turn}_link"
        if link != child:
            etree.SubElement(robot, "link", name=link)
        element = _add_joint(robot, turn, "continuous", parent, link, place)
        etree.SubElement(element, "axis", xyz=numbers(*axis))
        parent, place = link, _NOWHERE


def ball_turns(name: str) -> tuple[str, ...]:
    """Return the names of the three joints that replace a ball joint in URDF."""
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
    # MuJoCo's file shows the robot at the joint's `ref`, URDF's at its zero.
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
        # What its actuators give together is cut to this; 0 is no limit.
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


def _add_control(robot: etree._Element, mjcf: Mjcf, actuators: list[JointActuator]) -> None:
    """Add a system whose commands are those that the file's actuators take."""
    m, start = mjcf.model, mjcf.start()
    system = etree.SubElement(robot, "ros2_control", name=_SYSTEM, type="system")
    etree.SubElement(etree.SubElement(system, "hardware"), "plugin").text = SIMULATOR
    for number in range(m.njnt):
        name = m.joint(number).name
        if m.jnt_type[number] == _BALL:
            for turn in ball_turns(name):
                joint = etree.SubElement(system, "joint", name=turn)
                for state in ("position", "velocity"):
                    etree.SubElement(joint, "state_interface", name=state)
        if int(m.jnt_type[number]) not in SINGLE_AXIS:
            continue
        joint = etree.SubElement(system, "joint", name=name)
        commands = [actuator.interface for actuator in actuators if actuator.joint == name]
        for command in commands:
            etree.SubElement(joint, "command_interface", name=command)
        position = etree.SubElement(joint, "state_interface", name="position")
        value = numbers(float(start.qpos[m.jnt_qposadr[number]]))
        etree.SubElement(position, "param", name="initial_value").text = value
        for state in ("velocity", "effort"):
            etree.SubElement(joint, "state_interface", name=state)
