"""The supported Gazebo plug-ins that move a robot or publish its state, and a robot's ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.errors import InvalidDescriptionError, TeleopctlError
from teleopctl.packages import resolve_uri
from teleopctl.robot.gazebo_plugins import controllers, odometry
from teleopctl.robot.gazebo_plugins.controllers import BROADCASTER
from teleopctl.robot.gazebo_plugins.plugin_reader import (
    GroundTruth,
    PluginController,
    PluginEffect,
    PluginReader,
    plugin_kind,
)

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription


class _Kind(NamedTuple):
    """Converter of a kind of plug-in, and its supported tags."""

    read: Callable[[PluginReader], PluginEffect]
    tags: frozenset[str]


_KINDS = {
    "gazebo_ros_diff_drive": _Kind(
        controllers.classic_diff_drive, controllers.CLASSIC_DIFF_DRIVE_TAGS
    ),
    "gazebo_ros_joint_pose_trajectory": _Kind(
        controllers.joint_pose_trajectory, controllers.TRAJECTORY_TAGS
    ),
    "gazebo_ros_joint_state_publisher": _Kind(
        controllers.joint_states, controllers.JOINT_STATE_TAGS
    ),
    "gazebo_ros_p3d": _Kind(odometry.p3d, odometry.P3D_TAGS),
    "gazebo_ros_planar_move": _Kind(odometry.planar_move, odometry.PLANAR_MOVE_TAGS),
    "gz-sim-ackermann-steering-system": _Kind(controllers.ackermann, controllers.ACKERMANN_TAGS),
    "gz-sim-diff-drive-system": _Kind(controllers.diff_drive, controllers.DIFF_DRIVE_TAGS),
    "gz-sim-joint-state-publisher-system": _Kind(
        controllers.gz_joint_states, controllers.JOINT_STATE_TAGS
    ),
    "gz-sim-joint-trajectory-controller-system": _Kind(
        controllers.gz_joint_trajectory, controllers.GZ_TRAJECTORY_TAGS
    ),
    "gz-sim-mecanum-drive-system": _Kind(controllers.mecanum, controllers.MECANUM_TAGS),
    "gz-sim-odometry-publisher-system": _Kind(odometry.odometry_publisher, odometry.ODOMETRY_TAGS),
}


class MotionPlugins(NamedTuple):
    """Equivalents of a robot's Gazebo plug-ins: controllers, odometry and topics.

    Attributes:
        controllers: Controllers, in the order of the plug-ins.
        truths: Odometry for the simulator to publish.
        planar_topics: Topics of velocities by which the simulator moves the base.
        remarks: A sentence for each plug-in.
    """

    controllers: tuple[PluginController, ...] = ()
    truths: tuple[GroundTruth, ...] = ()
    planar_topics: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    # Any: parameters have one of nine types.
    def as_parameters(self, manager: str = "controller_manager") -> dict[str, Any]:
        """Return a parameter file's content for the controller manager and the controllers.

        Args:
            manager: Node name of the controller manager, in any namespace.
        """
        of_manager = {
            controller.name: {
                "type": controller.type,
                "node_options_args": [
                    word for rule in controller.remappings for word in ("--remap", rule)
                ],
            }
            for controller in self.controllers
        }
        nodes = {controller.name: dict(controller.parameters) for controller in self.controllers}
        return {
            f"/**/{name}": {"ros__parameters": values}
            for name, values in {manager: of_manager, **nodes}.items()
        }

    @property
    def commands(self) -> dict[str, str]:
        """Command interface of each joint that the plug-ins' controllers move, by joint name."""
        return {name: kind for one in self.controllers for name, kind in one.joints.items()}

    @property
    def drive_the_base(self) -> bool:
        """Whether a plug-in drives the base, so that other wheels are casters."""
        return bool(self.planar_topics) or "velocity" in self.commands.values()

    @property
    def publish_joint_states(self) -> bool:
        """Whether a plug-in publishes joint states."""
        return any(controller.type == BROADCASTER for controller in self.controllers)


def tags_of_plugin(filename: str) -> frozenset[str] | None:
    """Return the supported tags of a plug-in; None for an unsupported plug-in.

    Args:
        filename: File name of the plug-in in the description.
    """
    kind = _KINDS.get(plugin_kind(filename))
    return kind and kind.tags


def _is_doubled(controller: PluginController, description: RobotDescription) -> bool:
    """Return whether the ros2_control plug-in's parameters have a broadcaster for the same topic.

    A topic of Gazebo's plug-in is not one of ROS, unless it is bridged.
    """
    if controller.type != BROADCASTER or controller.remappings:
        return False
    for plugin in description.gazebo.plugins:
        for file in plugin.parameters.get("parameters", ()) if plugin.runs_controllers else ():
            try:
                text = resolve_uri(file).read_text("utf-8")
            except (OSError, UnicodeDecodeError, TeleopctlError):
                continue  # the controller manager reports it
            if BROADCASTER in text:
                return True
    return False


def motion_plugins(description: RobotDescription) -> MotionPlugins:
    """Return the equivalents of a description's supported Gazebo plug-ins, without faulty ones.

    Args:
        description: Description of the robot.
    """
    controllers: dict[str, PluginController] = {}
    truths: list[GroundTruth] = []
    planar_topics: list[str] = []
    remarks: list[str] = []
    for plugin in description.gazebo.plugins:
        kind = _KINDS.get(plugin_kind(plugin.filename))
        if kind is None:
            continue
        who = f"Plug-in '{plugin.name}' ({plugin.filename}, line {plugin.line})"
        try:
            effect = kind.read(PluginReader(plugin, description))
        except InvalidDescriptionError as error:
            remarks.append(f"{who} is left out: {error.message}")
            continue
        truths += effect.truths
        planar_topics += effect.planar_topics
        controller = effect.controller
        if controller is not None and _is_doubled(controller, description):
            remarks.append(
                f"{who} is left out: a joint_state_broadcaster of the ros2_control plug-in "
                "publishes /joint_states"
            )
            continue
        if controller is None:
            remarks.append(f"{who} {effect.says}")
            continue
        name, number = controller.name, 1
        while name in controllers:
            number += 1
            name = f"{controller.name}_{number}"
        controllers[name] = replace(controller, name=name)
        remarks.append(f"{who} is the controller '{name}' ({controller.type}): it {effect.says}")
    return MotionPlugins(
        tuple(controllers.values()), tuple(truths), tuple(planar_topics), tuple(remarks)
    )
