"""Readers of launch files: one per language, each produces steps with actions."""

from __future__ import annotations

from pathlib import Path

from teleopctl import plugins
from teleopctl.base.typed import Callable
from teleopctl.errors import LaunchError, UnknownPluginError
from teleopctl.launch.model.action import LaunchFile
from teleopctl.launch.model.element import Element


def read_launch_file(path: Path) -> LaunchFile:
    """Return a launch file's path and steps, by the reader registered for its suffix.

    Raises:
        TeleopctlError: The file cannot be read or is no valid launch file. The message names file
            and line, and what was expected there.
    """
    try:
        read: Callable[[Path], LaunchFile] = plugins.load(plugins.LAUNCH_LANGUAGES, path.suffix)
    except UnknownPluginError as error:
        endings = sorted(plugins.available(plugins.LAUNCH_LANGUAGES))
        raise LaunchError(
            f"{path} is not a launch file that teleopctl can read",
            hint=f"It reads ROS 2's launch files that end in {', '.join(endings)}.",
        ) from error
    return read(path)


def parse_text(text: str, path: Path, language: str) -> tuple[str, Element]:
    """Parse the text of a launch description; return the outermost entry's name and content.

    Args:
        text: Text of the launch description.
        path: Path of the text, for messages.
        language: ``xml`` or ``yaml``.

    Raises:
        TeleopctlError: The text is not in that language; the message has the line.
    """
    if language == "xml":
        from teleopctl.launch.frontends.xml_file import parse_xml

        return parse_xml(text, path).action()
    from teleopctl.launch.frontends.yaml_file import parse_yaml

    return parse_yaml(text, path).action()
