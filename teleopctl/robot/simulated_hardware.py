"""A robot description as a simulator takes it: the simulator is the hardware of all of its joints.

Descriptions name the hardware that their authors have: a vendor's driver, a mock, another
simulator. In simulation all of that is this one, whatever it was; a robot without any
``<ros2_control>`` has a system that holds each joint.
"""

from __future__ import annotations

from typing import NamedTuple

from lxml import etree

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.elements import parse
from teleopctl.robot.joints import Joints

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
    """A description whose hardware is the simulator.

    Attributes:
        urdf: The description; the text as it was where nothing had to be changed.
        remarks: What was changed, one sentence each.
    """

    urdf: str
    remarks: tuple[str, ...]


def simulated(urdf: str) -> SimulatedDescription:
    """Make the simulator the hardware of a robot.

    Args:
        urdf: The expanded description.

    Raises:
        InvalidDescriptionError: When it is no robot.
    """
    robot: etree._Element = parse(urdf)
    systems = robot.findall("ros2_control")
    if systems:
        remarks = _take_over(systems)
    else:
        remarks = _add_system(robot, RobotDescription.from_urdf(urdf))
    if not remarks:
        return SimulatedDescription(urdf, ())
    return SimulatedDescription(etree.tostring(robot, encoding="unicode"), tuple(remarks))


def _take_over(systems: list[etree._Element]) -> list[str]:
    """Let the simulator be the hardware of every system."""
    foreign = []
    for system in systems:
        plugin = system.findtext("hardware/plugin", "").strip()
        if plugin in _SIMULATORS:
            continue
        foreign.append(f"'{system.get('name')}' ({plugin})")
        for hardware in system.findall("hardware"):
            system.remove(hardware)
        hardware = etree.Element("hardware")
        etree.SubElement(hardware, "plugin").text = SIMULATOR
        system.insert(0, hardware)
        # The simulator's are of this kind, whatever they drive.
        system.set("type", "system")
    remarks = [f"The simulator is the hardware of {', '.join(foreign)}"] if foreign else []
    return remarks + _plain_commands(systems)


def _plain_commands(systems: list[etree._Element]) -> list[str]:
    """Name commands by what they command, which Gazebo's ``position_pid`` does not."""
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


def _add_system(robot: etree._Element, description: RobotDescription) -> list[str]:
    """Add a system that holds each joint where it is, and turns each that goes round and round."""
    system = etree.Element("ros2_control", name=_NEW_SYSTEM, type="system")
    etree.SubElement(etree.SubElement(system, "hardware"), "plugin").text = SIMULATOR
    found: dict[str, list[str]] = {"position": [], "velocity": []}
    for name, model in Joints.of(description).items():
        joint = etree.SubElement(system, "joint", name=name)
        if model.mimic is None:
            endless = description.joints[name].type == "continuous"
            command = "velocity" if endless else "position"
            found[command].append(name)
            etree.SubElement(joint, "command_interface", name=command)
        for state in _STATES:
            etree.SubElement(joint, "state_interface", name=state)
    if not len(system) > 1:
        return []
    robot.append(system)
    parts = [f"{what} of {', '.join(names)}" for what, names in found.items() if names]
    return [f"No <ros2_control> in the description; commanded are {' and '.join(parts)}"]
