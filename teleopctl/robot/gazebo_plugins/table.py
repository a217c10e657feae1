"""Which plug-ins of Gazebo move a robot or tell of it here, and those of a robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.gazebo_plugins import diff_drive, other_controllers as other, truth
from teleopctl.robot.gazebo_plugins.effects import GroundTruth, PluginController, PluginEffect
from teleopctl.robot.gazebo_plugins.reading import PluginReader, kind_of

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription


class _Kind(NamedTuple):
    """How a kind of plug-in is read, and which of its tags have their effect."""

    read: Callable[[PluginReader], PluginEffect]
    tags: frozenset[str]


_KINDS = {
    "gazebo_ros_diff_drive": _Kind(diff_drive.classic_diff_drive, diff_drive.CLASSIC_TAGS),
    "gazebo_ros_joint_pose_trajectory": _Kind(other.joint_pose_trajectory, other.TRAJECTORY_TAGS),
    "gazebo_ros_joint_state_publisher": _Kind(other.joint_states, other.JOINT_STATE_TAGS),
    "gazebo_ros_p3d": _Kind(truth.p3d, truth.P3D_TAGS),
    "gazebo_ros_planar_move": _Kind(truth.planar_move, truth.PLANAR_MOVE_TAGS),
    "gz-sim-ackermann-steering-system": _Kind(other.ackermann, other.ACKERMANN_TAGS),
    "gz-sim-diff-drive-system": _Kind(diff_drive.diff_drive, diff_drive.TAGS),
    "gz-sim-joint-state-publisher-system": _Kind(other.gz_joint_states, other.JOINT_STATE_TAGS),
    "gz-sim-joint-trajectory-controller-system": _Kind(
        other.gz_joint_trajectory, other.GZ_TRAJECTORY_TAGS
    ),
    "gz-sim-mecanum-drive-system": _Kind(other.mecanum, other.MECANUM_TAGS),
    "gz-sim-odometry-publisher-system": _Kind(truth.odometry_publisher, truth.ODOMETRY_TAGS),
}


class MotionPlugins(NamedTuple):
    """Controllers, odometry and topics that a robot's Gazebo plug-ins stand for.

    Attributes:
        controllers: Controllers, in the order of the plug-ins.
        truths: Odometry that the simulator publishes.
        planar_topics: Topics by whose velocities the simulator moves the base.
        remarks: One sentence for each plug-in.
    """

    controllers: tuple[PluginController, ...] = ()
    truths: tuple[GroundTruth, ...] = ()
    planar_topics: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    # Any: parameters have one of nine types.
    def as_parameters(self, manager: str = "controller_manager") -> dict[str, Any]:
        """Return the controllers as the content of a parameter file.

        Args:
            manager: The controller manager's node, which may be in any namespace.
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
        """Return the joints and the interface by which plug-ins command each."""
        return {name: kind for one in self.controllers for name, kind in one.joints.items()}

    @property
    def drive_the_base(self) -> bool:
        """Return whether a plug-in drives the base, so that other wheels are casters."""
        return bool(self.planar_topics) or "velocity" in self.commands.values()

    @property
    def publish_joint_states(self) -> bool:
        """Return whether a plug-in publishes joint states."""
        return any(controller.type == other.BROADCASTER for controller in self.controllers)


def tags_of_plugin(filename: str) -> frozenset[str] | None:
    """Return the tags of a plug-in that have an effect; None for an unknown plug-in.

    Args:
        filename: Of the plug-in, as the description has it.
    """
    kind = _KINDS.get(kind_of(filename))
    return kind and kind.tags


def motion_plugins(description: RobotDescription) -> MotionPlugins:
    """Return the controllers, odometry and topics that the robot's plug-ins stand for.

    Args:
        description: The robot.
    """
    controllers: dict[str, PluginController] = {}
    truths: list[GroundTruth] = []
    planar_topics: list[str] = []
    remarks: list[str] = []
    for plugin in description.gazebo.plugins:
        kind = _KINDS.get(kind_of(plugin.filename))
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
