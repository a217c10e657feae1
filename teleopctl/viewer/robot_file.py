"""Reload of the robot when its description file or one of its meshes is saved.

The launch file passes the path of the description's file as a parameter. When that file, a file
that it includes or a mesh is saved, the description is expanded again and set as parameter of the
node that publishes it. A faulty description is reported on the page, and the old robot stays.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.base.file_watch import FileWatch
from teleopctl.errors import TeleopctlError
from teleopctl.node import Parameter
from teleopctl.packages import resolve_uri
from teleopctl.robot import RobotDescription, read_model
from teleopctl.viewer.displays.robot_model import RobotModelDisplay, shapes_of
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.scene.assets import path_of_uri
from teleopctl.viewer.scene.shapes import mesh_uris
from teleopctl.viewer.service_calls import ServiceCalls

if TYPE_CHECKING:
    from teleopctl.viewer.panels.base import Page

FILE_PARAMETER = "robot_description_file"
ARGUMENTS_PARAMETER = "robot_description_arguments"
_TOPIC = "robot_description"


class _Expanded(NamedTuple):
    """An expanded description, and the files that it depends on, meshes among them."""

    text: str
    files: tuple[Path, ...]


class RobotFile:
    """Watcher of the robot's description file and meshes: reloads the robot after a save.

    Args:
        page: The viewer's node, whose parameters contain the path and the xacro arguments.

    Attributes:
        path: The description's file; None without the parameter.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        node = page.node
        file = str(node.declare_parameter(FILE_PARAMETER, "").value)
        arguments = node.declare_parameter(ARGUMENTS_PARAMETER, [""]).value
        self.path = resolve_uri(file).absolute() if file else None
        self._arguments = _mappings(arguments)
        self._text = ""
        self._files: tuple[Path, ...] = ()
        self._reported = ""
        self._turn = 0
        self._calls = ServiceCalls(page)
        self._watch = FileWatch(page.on_node_thread(lambda _: self._read()))
        self._note: Any = page.gui.add_html("", visible=False)
        if self.path is not None:
            self._read()

    def close(self) -> None:
        """Stop watching the files, and drop pending service calls."""
        self._watch.close()
        self._calls.close()

    def _read(self) -> None:
        path = self.path
        assert path is not None
        self._turn += 1
        turn = self._turn
        self._page.stage.run_in_background(
            lambda: _read(path, self._arguments), lambda result: self._apply(turn, result)
        )

    # Any: a task's result, or its exception.
    def _apply(self, turn: int, result: Any) -> None:
        if turn != self._turn:
            return
        if isinstance(result, TeleopctlError):
            # watch the files that the last valid description included
            self._watch.watch(self._files or ((self.path,) if self.path else ()))
            self._report(f"The robot is not reloaded: {result.message}")
            return
        if isinstance(result, BaseException):
            raise result
        first, before = not self._files, self._text
        self._text, self._files = result
        self._watch.watch(self._files)
        if first or result.text == before:
            self._report("")
            if not first:
                self._reload_meshes()
        elif self._page.node.get_parameter("use_sim_time").value:
            self._report("The description has changed; the running simulation keeps the old robot.")
        else:
            self._publish()

    def _reload_meshes(self) -> None:
        for display in self._page.scene_view.displays:
            if isinstance(display, RobotModelDisplay):
                display.reload()

    def _publish(self) -> None:
        """Set the new description as parameter of the node that publishes robot_description."""
        node = self._page.node
        publishers = node.get_publishers_info_by_topic(node.resolve_topic_name(_TOPIC))
        if not publishers:
            self._report("The robot is not reloaded: no node publishes robot_description")
            return
        owner = f"{publishers[0].node_namespace.rstrip('/')}/{publishers[0].node_name}"
        parameter = Parameter(_TOPIC, Parameter.Type.STRING, self._text)
        self._calls.call(
            f"{owner}/set_parameters",
            "rcl_interfaces/srv/SetParameters",
            lambda response: self._answered(owner, response),
            lambda why: self._report(f"The robot is not reloaded: {why}"),
            parameters=[parameter.to_parameter_msg()],
        )

    # Any: a message.
    def _answered(self, owner: str, response: Any) -> None:
        result = response.results[0] if response.results else None
        if result is not None and result.successful:
            self._report("")
            self._reload_meshes()
        else:
            why = result.reason if result is not None else "no result"
            self._report(f"The robot is not reloaded: {owner} rejects it: {why}")

    def _report(self, text: str) -> None:
        """Show a sentence above the tabs, and log it; remove the last one for an empty text."""
        if text and text != self._reported:
            self._page.node.get_logger().warning(text)
        self._reported = text
        self._note.content = (
            f'<div style="color:#fa5252;padding:0.5em 1em">{escaped_html(text)}</div>'
        )
        self._note.visible = bool(text)


def _mappings(arguments: Any) -> dict[str, str]:
    pairs = (str(argument).partition(":=") for argument in arguments)
    return {name: value for name, separator, value in pairs if separator}


def _read(path: Path, arguments: dict[str, str]) -> _Expanded:
    expanded = read_model(path, arguments)
    description = RobotDescription.from_urdf(expanded.text)
    files = list(expanded.files)
    for uri in mesh_uris(shapes_of(description)):
        with contextlib.suppress(TeleopctlError):  # the display reports it
            files.append(path_of_uri(uri, path.parent))
    return _Expanded(expanded.text, tuple(dict.fromkeys(files)))
