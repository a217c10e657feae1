"""Plug-ins by the names that URDFs and parameter files use.

Ours are in a table; others come from the entry-point groups ``teleopctl.hardware`` and
``teleopctl.controllers``, where the entry's name is the plug-in's and its value the class. A class
can also be named directly: ``my_package.my_module:MyController``.
"""

from __future__ import annotations

import importlib
from importlib.metadata import entry_points
from typing import Any

from teleopctl.errors import UnknownPluginError

HARDWARE_GROUP = "teleopctl.hardware"
CONTROLLER_GROUP = "teleopctl.controllers"

_TOPIC = "teleopctl.control.hardware.topic:TopicSystem"
_CONTROLLERS = "teleopctl.control.controllers"

BUILT_IN: dict[str, dict[str, str]] = {
    HARDWARE_GROUP: {
        "mock_components/GenericSystem": "teleopctl.control.hardware.mock:GenericSystem",
        "gazebo_ros2_control/GazeboSystem": _TOPIC,
        "gz_ros2_control/GazeboSimSystem": _TOPIC,
        "ign_ros2_control/IgnitionSystem": _TOPIC,
        "mujoco_ros2_control/MujocoSystemInterface": _TOPIC,
        "topic_based_ros2_control/TopicBasedSystem": _TOPIC,
        "topic_based_hardware_interfaces/TopicBasedSystem": _TOPIC,
        "joint_state_topic_hardware_interface/JointStateTopicSystem": _TOPIC,
    },
    CONTROLLER_GROUP: {
        "joint_state_broadcaster/JointStateBroadcaster": (
            f"{_CONTROLLERS}.joint_state_broadcaster:JointStateBroadcaster"
        ),
        "joint_trajectory_controller/JointTrajectoryController": (
            f"{_CONTROLLERS}.joint_trajectory.controller:JointTrajectoryController"
        ),
        "forward_command_controller/ForwardCommandController": (
            f"{_CONTROLLERS}.forward_command_controller:ForwardCommandController"
        ),
        "forward_command_controller/MultiInterfaceForwardCommandController": (
            f"{_CONTROLLERS}.forward_command_controller:MultiInterfaceForwardCommandController"
        ),
        "position_controllers/JointGroupPositionController": (
            f"{_CONTROLLERS}.forward_command_controller:JointGroupPositionController"
        ),
        "velocity_controllers/JointGroupVelocityController": (
            f"{_CONTROLLERS}.forward_command_controller:JointGroupVelocityController"
        ),
        "effort_controllers/JointGroupEffortController": (
            f"{_CONTROLLERS}.forward_command_controller:JointGroupEffortController"
        ),
    },
}


def available(group: str) -> dict[str, str]:
    """Names of a group's plug-ins, sorted, with the class that each one stands for."""
    found = dict(BUILT_IN[group])
    for entry in entry_points(group=group):
        found.setdefault(entry.name, entry.value)
    return dict(sorted(found.items()))


def load(group: str, name: str) -> type[Any]:
    """The class of a plug-in.

    Args:
        group: ``teleopctl.hardware`` or ``teleopctl.controllers``.
        name: The plug-in's name, or ``module:Class``.

    Raises:
        UnknownPluginError: There is none of that name, or it cannot be imported.
    """
    target = BUILT_IN[group].get(name) or available(group).get(name)
    if target is None and ":" in name and "/" not in name:
        target = name
    if target is None:
        known = "\n".join(f"  {known}" for known in available(group))
        raise UnknownPluginError(f"Available classes:\n{known}")
    module, _, attribute = target.partition(":")
    try:
        found: type[Any] = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise UnknownPluginError(f"{target} cannot be imported: {error}") from error
    return found
