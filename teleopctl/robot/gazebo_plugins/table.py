"""Which plug-ins are controllers here, and those of a robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.gazebo_plugins import diff_drive
from teleopctl.robot.gazebo_plugins.reading import PluginController, PluginReader, kind_of

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription


class _Kind(NamedTuple):
    """How a kind of plug-in is read, and which of its tags have their effect."""

    read: Callable[[PluginReader], PluginController]
    tags: frozenset[str]


_KINDS = {
    "gazebo_ros_diff_drive": _Kind(diff_drive.classic_diff_drive, diff_drive.CLASSIC_TAGS),
    "gz-sim-diff-drive-system": _Kind(diff_drive.diff_drive, diff_drive.TAGS),
}


class PluginControllers(NamedTuple):
    """What the plug-ins of a robot become.

    Attributes:
        controllers: Controllers, in the order of the plug-ins.
        remarks: One sentence for each plug-in.
    """

    controllers: tuple[PluginController, ...] = ()
    remarks: tuple[str, ...] = ()

    # Any: parameters have one of nine types.
    def as_parameters(self, manager: str = "controller_manager") -> dict[str, Any]:
        """A parameter file's content: for the controller manager, and for each controller.

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
        """The joints that they move, and the interface of each that they command."""
        return {name: kind for one in self.controllers for name, kind in one.joints.items()}


def tags_of_plugin(filename: str) -> frozenset[str] | None:
    """The tags of a plug-in that have their effect, or None where it is no controller here.

    Args:
        filename: Of the plug-in, as the description has it.
    """
    kind = _KINDS.get(kind_of(filename))
    return kind and kind.tags


def plugin_controllers(description: RobotDescription) -> PluginControllers:
    """Return the controllers that do what a robot's plug-ins of Gazebo do.

    Args:
        description: The robot.
    """
    controllers: list[PluginController] = []
    remarks: list[str] = []
    for plugin in description.gazebo.plugins:
        kind = _KINDS.get(kind_of(plugin.filename))
        if kind is None:
            continue
        who = f"Plug-in '{plugin.name}' ({plugin.filename}, line {plugin.line})"
        try:
            made = kind.read(PluginReader(plugin, description.name, description.joints))
        except InvalidDescriptionError as error:
            remarks.append(f"{who} is left out: {error.message}")
            continue
        names = {controller.name for controller in controllers}
        number = 1
        name = made.name
        while name in names:
            number += 1
            name = f"{made.name}_{number}"
        controllers.append(replace(made, name=name))
        remarks.append(f"{who} is the controller '{name}' ({made.type}): it {made.says}")
    return PluginControllers(tuple(controllers), tuple(remarks))
