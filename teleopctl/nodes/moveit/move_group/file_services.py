"""Services about files: ``get_urdf``, ``save_geometry_to_file`` and so on."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lxml import etree

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service
from teleopctl.kinematics import JointGroup, MoveItErrorCode
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.scene_files import read_scene, write_scene
from teleopctl.robot import RobotDescription

# Any, here and below: message classes are generated at run time from definitions.


class FileServices:
    """Services that write and read the objects of the scene, and the URDF of a group.

    Args:
        context: Robot, state and scene.
        urdf: The robot's description.
    """

    def __init__(self, context: MoveGroupContext, urdf: str) -> None:
        self._context, self._urdf = context, urdf
        self._log = context.node.get_logger()
        for type_name, name, callback in (
            ("moveit_msgs/srv/GetGroupUrdf", "get_urdf", self._get_urdf),
            ("moveit_msgs/srv/SaveGeometryToFile", "save_geometry_to_file", self._save),
            ("moveit_msgs/srv/LoadGeometryFromFile", "load_geometry_from_file", self._load),
            ("std_srvs/srv/Empty", "clear_octomap", self._clear_octomap),
        ):
            context.node.create_service(get_service(type_name), name, callback)

    def _get_urdf(self, request: Any, response: Any) -> Any:
        group = self._context.groups.groups.get(request.group_name)
        if group is None:
            known = ", ".join(self._context.groups.groups)
            text = (
                f"Cannot create URDF because planning group '{request.group_name}' does not exist: "
                f"the groups are {known}"
            )
            self._log.error(text)
            response.error_code = messages.error_code(MoveItErrorCode.FAILURE, text)
            return response
        response.urdf_string = group_urdf(self._urdf, self._context.scene.model.description, group)
        response.error_code = messages.error_code(MoveItErrorCode.SUCCESS)
        return response

    def _save(self, request: Any, response: Any) -> Any:
        path = request.file_path_and_name
        with self._context.lock:
            text = write_scene(self._context.scene)
        try:
            Path(path).write_text(text, encoding="utf-8")
        except OSError as error:
            self._log.error(f"Unable to open file {path} for saving CollisionObjects: {error}")
            return response
        response.success = True
        return response

    def _load(self, request: Any, response: Any) -> Any:
        context = self._context
        try:
            name, objects = read_scene(Path(request.file_path_and_name))
            with context.lock:
                before = context.scene.copy()
                try:
                    for one, color in objects:
                        context.scene.add(one)
                        if color is not None:
                            context.scene.colors[one.name] = color
                    context.scene.name = name
                    context.scene.compiled()
                except TeleopctlError:
                    context.scene.restore(before)
                    raise
        except TeleopctlError as error:
            self._log.error(f"load_geometry_from_file: {error.message}")
            return response
        context.scene_changed()
        response.success = True
        return response

    def _clear_octomap(self, request: Any, response: Any) -> Any:
        del request
        self._log.info("clear_octomap: there is no octomap")
        return response


def group_urdf(urdf: str, description: RobotDescription, group: JointGroup) -> str:
    """Return the links and joints of a group as a URDF of their own, each sorted by name.

    A parent link that is not of the group is there without content.

    Args:
        urdf: Description of the robot.
        description: The same, read.
        group: The group.
    """
    joints = set(_joints_of(description, group))
    links = {description.joints[name].child for name in joints}
    root = etree.fromstring(urdf.encode())
    made = etree.Element("robot", name=group.name)
    for kind, names in (("link", links), ("joint", joints)):
        elements = [element for element in root.findall(kind) if element.get("name") in names]
        for element in sorted(elements, key=lambda each: str(each.get("name"))):
            one = copy.deepcopy(element)
            one.tail = None
            made.append(one)
    parents = {description.joints[name].parent for name in joints} - links
    for name in sorted(parents):
        etree.SubElement(made, "link", name=name)
    return f'<?xml version="1.0" ?>{etree.tostring(made, encoding="unicode")}'


def _joints_of(description: RobotDescription, group: JointGroup) -> Iterator[str]:
    """Yield the joints of a group, with the fixed ones between them and up to its tip."""
    yield from group.joints
    above = {joint.child: (name, joint.parent) for name, joint in description.joints.items()}
    ends = [group.tip] if group.tip else [description.joints[name].child for name in group.joints]
    for link in ends:
        passed = []
        while link in above:
            name, link = above[link]
            passed.append(name)
            if name in group.joints:
                yield from passed
                passed.clear()
