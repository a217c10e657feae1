"""What can be told of anybody's description: its arguments, its meshes, and what may move it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.gazebo_plugins.table import MotionPlugins

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_ARGUMENT = re.compile(r"<xacro:arg\s([^>]*)>")
_ATTRIBUTE = re.compile(r"(\w+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
_MESH = re.compile(r"(<mesh\s[^>]*?filename\s*=\s*[\"'])([^\"']*)")
_RATE_HZ = 100
_USE = re.compile(r"\$\(arg\s+(\w+)\s*\)")


class ChosenControllers(NamedTuple):
    """Chosen controllers of a robot, with their parameters.

    Attributes:
        file: Parameters of the controller manager and of them.
        namespace: Where they run; empty for the root.
        names: In the order in which they are activated.
        own: Whether a file or the description has any of them, and not all are made for it.
    """

    file: Path
    namespace: str
    names: tuple[str, ...]
    own: bool


def xacro_arguments(files: Iterable[Path]) -> dict[str, str | None]:
    """Return the xacro arguments of a description, with their defaults.

    Args:
        files: The description's file and those that it includes; what cannot be read has none.
    """
    declared: dict[str, str | None] = {}
    used: dict[str, None] = {}
    for file in files:
        try:
            text = _COMMENT.sub("", file.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError):
            continue
        for tag in _ARGUMENT.findall(text):
            attributes = {name: first or second for name, first, second in _ATTRIBUTE.findall(tag)}
            if "name" in attributes:
                declared.setdefault(attributes["name"], attributes.get("default"))
        used.update(dict.fromkeys(_USE.findall(text)))
    # What is used and nowhere declared has to be given.
    return {**{name: None for name in used if name not in declared}, **declared}


def in_words(arguments: dict[str, str | None]) -> str:
    """Return arguments and defaults in words, required ones first."""
    ordered = sorted(arguments.items(), key=lambda item: item[1] is not None)
    return ", ".join(
        name if default is None else f"{name} ({default})" for name, default in ordered
    )


def with_mesh_paths(urdf: str, folder: Path) -> str:
    """Return a description with relative mesh paths made absolute.

    Whoever reads the description from a topic does not know where its file was.

    Args:
        urdf: The description.
        folder: Where its file is.
    """

    def whole(match: re.Match[str]) -> str:
        before, name = match.groups()
        if not name or "://" in name or name.startswith("/"):
            return match[0]
        try:
            is_there = (folder / name).is_file()
        except OSError:  # too long for a file's name
            is_there = False
        return f"{before}{(folder / name).resolve().as_uri()}" if is_there else match[0]

    return _MESH.sub(whole, urdf)


def described_controllers(description: RobotDescription) -> list[str]:
    """Return the controllers' parameter files that a description names, as written there.

    They stand at Gazebo's plug-in of ros2_control.
    """
    return _said_by_plugin(description, "parameters")


def described_namespace(description: RobotDescription) -> str:
    """Return the namespace of a description's controller manager, such as ``/arm``.

    It stands at Gazebo's plug-in of ros2_control; empty where that is not, or the root's.
    """
    for plugin in description.gazebo.plugins:
        if plugin.runs_controllers:
            namespace = plugin.parameter("ros/namespace").strip().strip("/")
            return f"/{namespace}" if namespace else ""
    return ""


def described_remappings(description: RobotDescription) -> list[str]:
    """Return the remappings that a description's controllers ask for.

    They stand at Gazebo's plug-in of ros2_control.
    """
    return _said_by_plugin(description, "ros/remapping")


def _said_by_plugin(description: RobotDescription, parameter: str) -> list[str]:
    """What a parameter of Gazebo's plug-in of ros2_control says, each time that it stands there."""
    return [
        text
        for plugin in description.gazebo.plugins
        if plugin.runs_controllers
        for text in plugin.parameters.get(parameter, ())
        if text
    ]


# Any: parameters as they stand in YAML.
def controllers_for(
    description: RobotDescription, plugins: MotionPlugins | None = None
) -> dict[str, Any]:
    """Return parameters of controllers that move every joint of ``<ros2_control>``.

    Joints that take positions follow trajectories; of the others each group takes its values.

    Args:
        description: The robot.
        plugins: What moves some of them already, and perhaps tells of all.
    """
    moved = {} if plugins is None else plugins.commands
    joints = [
        joint
        for system in description.ros2_control
        for joint in system.joints
        if joint.name not in moved
    ]
    states = [{interface.name for interface in joint.state_interfaces} for joint in joints]
    read = [name for name in ("position", "velocity") if all(name in known for known in states)]
    of_kind: dict[str, list[str]] = {"position": [], "velocity": [], "effort": []}
    for joint in joints:
        commands = {interface.name for interface in joint.command_interfaces}
        for kind, names in of_kind.items():
            if kind in commands:
                names.append(joint.name)
                break
    types = {}
    if plugins is None or not plugins.publish_joint_states:
        types["joint_state_broadcaster"] = "joint_state_broadcaster/JointStateBroadcaster"
    parameters: dict[str, dict[str, Any]] = {}
    if positions := of_kind["position"]:
        types["joint_trajectory_controller"] = (
            "joint_trajectory_controller/JointTrajectoryController"
        )
        parameters["joint_trajectory_controller"] = {
            "joints": positions,
            "command_interfaces": ["position"],
            "state_interfaces": read,
        }
    for kind in ("velocity", "effort"):
        if of_kind[kind]:
            types[f"{kind}_controller"] = f"{kind}_controllers/JointGroup{kind.title()}Controller"
            parameters[f"{kind}_controller"] = {"joints": of_kind[kind]}
    manager = {"update_rate": _RATE_HZ, **{name: {"type": type_} for name, type_ in types.items()}}
    return {
        name: {"ros__parameters": values}
        for name, values in {"controller_manager": manager, **parameters}.items()
    }
