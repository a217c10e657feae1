"""Tags of URDF and of ``<ros2_control>``, and warnings about other tags in a description.

The content of ``<gazebo>`` is checked by other code; MuJoCo reads the content of ``<mujoco>``.
"""

from __future__ import annotations

from collections.abc import Mapping

from lxml import etree

from teleopctl.robot.elements import parse
from teleopctl.robot.repair import REMARK
from teleopctl.robot.tags.table import Table, TagFinding

_LISTED_LINES = 3
_JOINTS = "commands and states are those of joints, not of actuators"
_DRIVEN = "joints are driven as <ros2_control> says"

# Tags that should appear only once have a * as well: `repair_urdf` reports repeated ones.
URDF = Table(f"""
    + .: @name @version link*@name joint*@name@type material*@name
    > .: mujoco {REMARK}
    > .: gazebo@reference
    - .: transmission* | {_DRIVEN}
    - link: @type
    + link/inertial*: origin*@xyz@rpy mass*@value inertia*@ixx@ixy@ixz@iyy@iyz@izz
    + link: visual*@name collision*@name
    + link/visual: origin*@xyz@rpy material*@name
    + link/visual/geometry*: box*@size cylinder*@radius@length capsule*@radius@length
    + link/visual/geometry: sphere*@radius mesh*@filename@scale
    + link/visual/material: color*@rgba texture*@filename
    + link/collision: origin*@xyz@rpy
    + link/collision/geometry*: box*@size cylinder*@radius@length capsule*@radius@length
    + link/collision/geometry: sphere*@radius mesh*@filename@scale
    - link/collision: verbose
    + material: color*@rgba texture*@filename
    + joint: origin*@xyz@rpy parent*@link child*@link axis*@xyz
    + joint: limit*@lower@upper@effort@velocity mimic*@joint@multiplier@offset
    + joint: dynamics*@damping@friction safety_controller@soft_lower_limit@soft_upper_limit
    + joint/safety_controller: @k_position @k_velocity
    - joint: calibration | joints know where they are
    + .: ros2_control*@name@type@rw_rate@is_async@thread_priority
    + ros2_control/hardware: plugin group param*@name
    - ros2_control/hardware: async | its place is in <properties>
    + ros2_control/properties/async: @thread_priority @affinity @scheduling_policy @print_warnings
    + ros2_control: joint*@name@mimic sensor*@name gpio*@name transmission*@name
    + ros2_control/joint: param*@name limits@enable
    + ros2_control/sensor: param*@name
    + ros2_control/gpio: param*@name
    + ros2_control/joint: command_interface*@name@data_type@size state_interface*@name
    + ros2_control/joint/state_interface: @data_type @size param*@name
    + ros2_control/joint/command_interface: param*@name limits@enable
    + ros2_control/sensor: state_interface*@name@data_type@size
    + ros2_control/sensor/state_interface: param*@name
    + ros2_control/gpio: command_interface*@name@data_type@size state_interface*@name
    + ros2_control/gpio/command_interface: param*@name limits@enable
    + ros2_control/gpio/state_interface: @data_type @size param*@name
    + ros2_control/transmission: plugin param*@name joint*@name@role actuator*@name@role
    - ros2_control/transmission/joint: mechanical_reduction=1 offset | {_JOINTS}
    - ros2_control/transmission/actuator: mechanical_reduction=1 offset | {_JOINTS}
    - ros2_control/transmission/joint: @read_only=false
    - ros2_control/transmission/actuator: @read_only=false
""")


def unknown_tags(urdf: str) -> list[str]:
    """Return a warning for each kind of unknown or ineffective tag or attribute in a URDF.

    Args:
        urdf: Expanded robot description, which is well-formed XML.
    """
    robot: etree._Element = parse(urdf)
    lines: dict[str, list[int]] = {}
    for found in URDF.findings(robot):
        parent = found.path.rpartition("/")[0]
        if found.entry is None and parent.endswith("/geometry") and "@" not in found.path:
            continue  # the reader of shapes raises an error that names the link
        lines.setdefault(_sentence(found), []).append(found.element.sourceline or 0)
    return in_lines(lines)


def in_lines(lines: Mapping[str, list[int]]) -> list[str]:
    """Return warnings as text, each followed by the URDF line numbers where it applies.

    Args:
        lines: Line numbers by sentence.
    """
    return [f"{sentence} ({_lines(numbers)})" for sentence, numbers in lines.items()]


def _sentence(found: TagFinding) -> str:
    """Return a finding's sentence with the tag instead of its path, for all places of the tag."""
    if found.entry is None or "@" in found.path:
        return found.sentence
    return found.sentence.replace(f"<{found.path}>", f"<{found.path.rpartition('/')[2]}>")


def _lines(numbers: list[int]) -> str:
    different = list(dict.fromkeys(numbers))
    listed = ", ".join(map(str, different[:_LISTED_LINES]))
    more = len(different) - _LISTED_LINES
    return f"line {listed}" + (f" and {more} more" if more > 0 else "")
