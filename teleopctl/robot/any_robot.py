"""Facts about any description: xacro arguments, mesh paths, controllers and their parameters."""

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
    """The controllers that a launch file starts for a robot.

    Attributes:
        file: Parameter file of the controller manager and the controllers.
        namespace: Namespace of the controller manager; empty for the root.
        names: Names of the controllers in the order of their activation.
        own: Whether any controller is from the user's file or the description, not a default.
    """

    file: Path
    namespace: str
    names: tuple[str, ...]
    own: bool


def xacro_arguments(files: Iterable[Path]) -> dict[str, str | None]:
    """Return the xacro arguments of a description with their defaults; None for required ones.

    Args:
        files: Description file and the files that it includes; unreadable files are skipped.
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
    # Arguments that are used but not declared have no default.
    return {**{name: None for name in used if name not in declared}, **declared}


def arguments_text(arguments: dict[str, str | None]) -> str:
    """Return xacro arguments as text, required ones first: "model, prefix (left_)"."""
    ordered = sorted(arguments.items(), key=lambda item: item[1] is not None)
    return ", ".join(
        name if default is None else f"{name} ({default})" for name, default in ordered
    )


def with_absolute_mesh_paths(urdf: str, folder: Path) -> str:
    """Return a description whose relative mesh paths are file:// URIs, if the files exist.

    Nodes that receive the description by topic have no access to the folder of its file.

    Args:
        urdf: Description as URDF text.
        folder: Folder of the description file.
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


def controller_parameter_files(description: RobotDescription) -> list[str]:
    """Return the ``<parameters>`` paths of Gazebo's ros2_control plug-ins in a description."""
    return _plugin_parameters(description, "parameters")


def controller_namespace(description: RobotDescription) -> str:
    """Return the namespace of a description's controller manager, such as ``/arm``, or "".

    Read from ``<namespace>`` of Gazebo's ros2_control plug-in; empty for none or the root.
    """
    for plugin in description.gazebo.plugins:
        if plugin.runs_controllers:
            namespace = plugin.parameter("ros/namespace").strip().strip("/")
            return f"/{namespace}" if namespace else ""
    return ""


def controller_remappings(description: RobotDescription) -> list[str]:
    """Return the ``<remapping>`` texts of Gazebo's ros2_control plug-ins, as ``from:=to``."""
    return _plugin_parameters(description, "ros/remapping")


def _plugin_parameters(description: RobotDescription, parameter: str) -> list[str]:
    """Return all values of a parameter of Gazebo's ros2_control plug-ins."""
    return [
        text
        for plugin in description.gazebo.plugins
        if plugin.runs_controllers
        for text in plugin.parameters.get(parameter, ())
        if text
    ]


# Any: parameter values as in YAML.
# Messages of controller_manager_msgs have rates as uint16.
_HIGHEST_UPDATE_RATE = 65535


def update_rate_problem(rate: object) -> str | None:
    """Return why a value is no ``update_rate`` of a controller manager, in Hz; None if it is."""
    if isinstance(rate, int) and not isinstance(rate, bool) and 1 <= rate <= _HIGHEST_UPDATE_RATE:
        return None
    return f"is {rate}, expected an integer from 1 to {_HIGHEST_UPDATE_RATE} (Hz)"


def default_controllers(
    description: RobotDescription, plugins: MotionPlugins | None = None
) -> dict[str, Any]:
    """Return parameters, by node name, of a controller manager and default controllers for a robot.

    Joints with a position interface get a joint trajectory controller, the others a group
    controller for velocities or efforts.

    Args:
        description: Description of the robot.
        plugins: Gazebo plug-ins, whose joints are left out.
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
