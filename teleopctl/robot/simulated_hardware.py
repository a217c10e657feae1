"""A description for simulation: the simulator is the hardware of all joints.

Descriptions name the hardware that their authors use: a vendor's driver, a mock, another
simulator. In simulation the simulator replaces all of them; a robot without any
``<ros2_control>`` gets a system that holds each joint. Joints that Gazebo's own plug-ins move take
the commands of the controllers that replace those plug-ins.

The state of a planar joint is three numbers, which ``sensor_msgs/JointState`` and ros2_control
cannot hold. So the joint is split into three, two that slide in the plane and one that rotates in
it, named as MoveIt names the variables, with two links of negligible mass between them.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

from lxml import etree

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.elements import parse, to_number
from teleopctl.robot.gazebo_plugins.table import MotionPlugins, motion_plugins
from teleopctl.robot.joints import Joints
from teleopctl.robot.scene.loops import loops_path
from teleopctl.robot.urdf import Joint
from teleopctl.robot.urdf_text import numbers, rotation_from_z
from teleopctl.tf import rotate

STATES_TOPIC = "/robot_joint_states"
COMMANDS_TOPIC = "/robot_joint_commands"

RESET_FRAME = "reset"
"""``frame_id`` of the first state after the robot was moved by a reset; empty in other states.

The mark is part of the state itself, so that it cannot arrive too early or too late.
"""


# Negligible, but not zero for MuJoCo.
_NO_MASS, _NO_MOMENT = "1e-9", "1e-12"


def split_planar_joints(
    robot: etree._Element, joints: Mapping[str, Joint]
) -> tuple[list[str], list[str]]:
    """Split planar joints into two prismatic and one continuous; return new names and remarks.

    Args:
        robot: Root element of the URDF, which is changed.
        joints: Joints of the robot by name.

    Returns:
        The names of the new joints, and a sentence about each planar joint.
    """
    names: list[str] = []
    remarks = []
    for element in robot.findall("joint"):
        joint = joints[element.get("name") or ""]
        if joint.type != "planar":
            continue
        parts = _parts(element, joint)
        for part in reversed(parts):
            element.addnext(part)
        robot.remove(element)
        x, y, theta = (str(part.get("name")) for part in parts if part.tag == "joint")
        names += [x, y, theta]
        remarks.append(
            f"The planar joint '{joint.name}' becomes three joints: '{x}' and '{y}' slide, "
            f"'{theta}' turns{_without(robot, element)}"
        )
    return names, remarks


def _parts(element: etree._Element, joint: Joint) -> list[etree._Element]:
    """Return the three joints that replace a planar one, and the links between them."""
    turn = rotation_from_z(joint.axis).rotation
    along = [rotate(turn, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]
    motions = [
        ("x", "prismatic", along[0]),
        ("y", "prismatic", along[1]),
        ("theta", "continuous", joint.axis),
    ]
    parts: list[etree._Element] = []
    parent = joint.parent
    for suffix, kind, axis in motions:
        name = f"{joint.name}_{suffix}"
        child = joint.child if suffix == "theta" else f"{name}_link"
        if child != joint.child:
            parts.append(_link(child))
        part = etree.Element("joint", name=name, type=kind)
        origin = element.find("origin")
        if parent == joint.parent and origin is not None:
            part.append(copy.deepcopy(origin))
        etree.SubElement(part, "parent", link=parent)
        etree.SubElement(part, "child", link=child)
        etree.SubElement(part, "axis", xyz=numbers(*axis))
        effort, velocity = (joint.limit.effort, joint.limit.velocity) if joint.limit else (0, 0)
        etree.SubElement(part, "limit", effort=numbers(effort), velocity=numbers(velocity))
        dynamics = element.find("dynamics")
        if dynamics is not None:
            part.append(copy.deepcopy(dynamics))
        parts.append(part)
        parent = child
    return parts


def _link(name: str) -> etree._Element:
    link = etree.Element("link", name=name)
    inertial = etree.SubElement(link, "inertial")
    etree.SubElement(inertial, "mass", value=_NO_MASS)
    etree.SubElement(inertial, "inertia", ixx=_NO_MOMENT, iyy=_NO_MOMENT, izz=_NO_MOMENT)
    return link


def _without(robot: etree._Element, planar: etree._Element) -> str:
    """Remove a split planar joint from ``<ros2_control>``; return text about all lost settings."""
    limit = planar.find("limit")
    lost = [
        f"the {end} limit"
        for end in ("lower", "upper")
        if limit is not None and limit.get(end, "0").strip("0. -+")
    ]
    lost += ["<mimic>" for _ in planar.findall("mimic")]
    for part in robot.xpath("ros2_control/joint[@name=$name]", name=planar.get("name")):
        part.getparent().remove(part)
        lost.append("its interfaces in <ros2_control>")
    return f", without {', '.join(lost)}" if lost else ""


SIMULATOR = "gz_ros2_control/GazeboSimSystem"
_SIMULATORS = (
    SIMULATOR,
    "gazebo_ros2_control/GazeboSystem",
    "ign_ros2_control/IgnitionSystem",
    "mujoco_ros2_control/MujocoSystemInterface",
)
_NEW_SYSTEM = "SimulatedSystem"
_COMMANDS = ("position", "velocity", "effort")
_STATES = ("position", "velocity")


class SimulatedDescription(NamedTuple):
    """URDF in which the simulator is the ros2_control hardware, with what was changed.

    Attributes:
        urdf: Description as URDF; the unchanged text if no change was necessary.
        remarks: Sentences about the changes.
    """

    urdf: str
    remarks: tuple[str, ...]


@lru_cache(maxsize=2)
def simulated(urdf: str) -> SimulatedDescription:
    """Return a URDF with the simulator as ros2_control hardware, added if missing; and remarks.

    Args:
        urdf: Expanded description.

    Raises:
        InvalidDescriptionError: When the text is no valid robot description.
    """
    robot: etree._Element = parse(urdf)
    description = RobotDescription.from_urdf(urdf)
    planar, remarks = split_planar_joints(robot, description.joints)
    if planar:
        description = RobotDescription.from_urdf(etree.tostring(robot, encoding="unicode"))
    plugins = motion_plugins(description)
    systems = robot.findall("ros2_control")
    remarks += _take_over(systems) if systems else _add_system(robot, description, plugins)
    changed = _add_plugin_interfaces(robot, plugins)
    if not (_add_remaining_joints(robot, description) or changed or remarks):
        return SimulatedDescription(urdf, ())
    return SimulatedDescription(etree.tostring(robot, encoding="unicode"), tuple(remarks))


def with_plugin_joints(urdf: str) -> str:
    """Return a URDF with the ``<ros2_control>`` interfaces that Gazebo plug-ins command added.

    Args:
        urdf: Expanded description; returned unchanged if no joint is missing.

    Raises:
        InvalidDescriptionError: When the text is no valid robot description.
    """
    robot: etree._Element = parse(urdf)
    changed = _add_plugin_interfaces(robot, motion_plugins(RobotDescription.from_urdf(urdf)))
    return etree.tostring(robot, encoding="unicode") if changed else urdf


def with_ros2_control_of(urdf: str, other: str) -> str:
    """Return a URDF with the ``<ros2_control>`` tags of another one.

    Gazebo's plug-in reads them from ``robot_state_publisher``: a model in SDF has none.

    Raises:
        InvalidDescriptionError: When one of the texts is no valid robot description.
    """
    robot: etree._Element = parse(urdf)
    for system in parse(other).findall("ros2_control"):
        robot.append(system)
    text: str = etree.tostring(robot, encoding="unicode")
    return text


def _take_over(systems: list[etree._Element]) -> list[str]:
    """Make the simulator the hardware of every system; return sentences about the changes."""
    foreign, remarks = [], []
    for system in systems:
        plugin = system.findtext("hardware/plugin", "").strip()
        if plugin in _SIMULATORS:
            file = system.findtext("hardware/param[@name='mujoco_model']", "").strip()
            if file:
                remarks.append(
                    f"The physics of '{system.get('name')}' is that of this description, not of "
                    f"its mujoco_model: model:={file} simulates that file"
                )
            continue
        names = [tag.get("name") for tag in system.iterfind("hardware/param")]
        without = f", without its {', '.join(map(str, names))}" if names else ""
        foreign.append(f"'{system.get('name')}' ({plugin}{without})")
        for hardware in system.findall("hardware"):
            system.remove(hardware)
        hardware = etree.Element("hardware")
        etree.SubElement(hardware, "plugin").text = SIMULATOR
        system.insert(0, hardware)
        # The simulator has only components of type system.
        system.set("type", "system")
    if foreign:
        remarks.insert(0, f"The simulator is the hardware of {', '.join(foreign)}")
    return remarks + _plain_commands(systems)


def _plain_commands(systems: list[etree._Element]) -> list[str]:
    """Rename Gazebo's command interfaces such as ``position_pid``; return a sentence about them."""
    renamed = []
    for joint in (joint for system in systems for joint in system.findall("joint")):
        plain = {command.get("name"): command for command in joint.findall("command_interface")}
        for name, command in plain.items():
            what = (name or "").removesuffix("_pid")
            if what == name or what not in _COMMANDS:
                continue
            renamed.append(f"{joint.get('name')}/{name}")
            if what in plain:
                joint.remove(command)
            else:
                command.set("name", what)
    if not renamed:
        return []
    return [f"Without '_pid', since the simulator's drives follow exactly: {', '.join(renamed)}"]


def usual_command(kind: str) -> str:
    """Return the default command of a URDF joint type: position, or velocity if continuous."""
    return "velocity" if kind == "continuous" else "position"


def _new_system() -> etree._Element:
    system = etree.Element("ros2_control", name=_NEW_SYSTEM, type="system")
    etree.SubElement(etree.SubElement(system, "hardware"), "plugin").text = SIMULATOR
    return system


def _add_plugin_interfaces(robot: etree._Element, plugins: MotionPlugins) -> bool:
    """Add missing interfaces of the joints that plug-ins move; return whether any was missing."""
    known = {joint.get("name"): joint for joint in robot.iterfind("ros2_control/joint")}
    system, changed = _new_system(), False
    for name, command in plugins.commands.items():
        joint = known.get(name)
        if joint is None:
            joint = etree.SubElement(system, "joint", name=name)
        for tag, wanted in (("command_interface", (command,)), ("state_interface", _STATES)):
            there = {interface.get("name") for interface in joint.findall(tag)}
            for interface in wanted:
                if interface not in there:
                    etree.SubElement(joint, tag, name=interface)
                    changed = True
    if system.find("joint") is not None:
        robot.append(system)
    return _limit_efforts(robot, plugins) or changed


def _add_remaining_joints(robot: etree._Element, description: RobotDescription) -> bool:
    """Add state interfaces for joints in no ``<ros2_control>`` tag; return whether any was added.

    No controller commands these joints, but without their states tf would lack their links.
    """
    known = {joint.get("name") for joint in robot.iterfind("ros2_control/joint")}
    joints = Joints.of(description)
    others = [name for name in joints if name not in known and joints[name].mimic is None]
    if not known or not others:
        return False
    system = robot.find(f"ros2_control[@name='{_NEW_SYSTEM}']")
    if system is None:
        system = _new_system()
        robot.append(system)
    for name in others:
        joint = etree.SubElement(system, "joint", name=name)
        for state in _STATES:
            etree.SubElement(joint, "state_interface", name=state)
    return True


def _limit_efforts(robot: etree._Element, plugins: MotionPlugins) -> bool:
    """Lower joints' effort limits to those of the plug-ins; return whether any changed."""
    efforts = {name: most for one in plugins.controllers for name, most in one.efforts.items()}
    changed = False
    for joint in robot.iterfind("joint"):
        most = efforts.get(joint.get("name") or "", 0.0)
        limit = joint.find("limit")
        if most <= 0.0:
            continue
        if limit is None:
            limit = etree.SubElement(joint, "limit", velocity="0")
        own = to_number(limit.get("effort") or "")
        if not own or own > most:
            limit.set("effort", f"{most:g}")
            changed = True
    return changed


def _carried(description: RobotDescription) -> set[str]:
    """Return the continuous joints that the other joints of a closed loop move."""
    ends = {name: (joint.parent, joint.child) for name, joint in description.joints.items()}
    carried: set[str] = set()
    for loop in description.gazebo.loops:
        path = loops_path(loop, ends)
        kinds = {name: joint.type for name, joint in description.joints.items() if name in path}
        endless = [name for name, kind in kinds.items() if kind == "continuous"]
        # If all joints of the loop are continuous, the first one is the driven joint.
        others = [kind for kind in kinds.values() if kind not in ("continuous", "fixed")]
        carried.update(endless if others else endless[1:])
    return carried


def _add_system(
    robot: etree._Element, description: RobotDescription, plugins: MotionPlugins
) -> list[str]:
    """Add a system with a position command per joint, or velocity for continuous ones.

    Joints that a closed loop moves get no command interface. If plug-ins drive the robot's base,
    continuous joints that no plug-in moves are casters and get none either.
    """
    system, moved, carried = _new_system(), plugins.commands, _carried(description)
    found: dict[str, list[str]] = {"position": [], "velocity": []}
    for name, model in Joints.of(description).items():
        joint = etree.SubElement(system, "joint", name=name)
        endless = description.joints[name].type == "continuous"
        passive = name in carried or (plugins.drive_the_base and endless)
        if model.mimic is None and (name in moved or not passive):
            command = moved.get(name) or usual_command(description.joints[name].type)
            found[command].append(name)
            etree.SubElement(joint, "command_interface", name=command)
        for state in _STATES:
            etree.SubElement(joint, "state_interface", name=state)
    if not len(system) > 1:
        return []
    robot.append(system)
    parts = [f"{what} of {', '.join(names)}" for what, names in found.items() if names]
    commands = (
        f"commanded are {' and '.join(parts)}" if parts else "none of its joints is commanded"
    )
    return [f"No <ros2_control> in the description; {commands}"]
