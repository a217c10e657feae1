"""Substitutions for launch files that take any robot.

``$(robot FILE name:=value …)`` is a description with the launch arguments that it takes itself,
and meshes by their whole paths; ``$(robot-arguments FILE name:=value …)`` are those arguments, as
a list. ``$(simulated-robot FILE HARDWARE …)`` is the description whose hardware is the simulator,
``$(robot-controllers FILE HARDWARE OTHERWISE)`` the file of its controllers' parameters, and
``$(with-plugins FILE HARDWARE CONTROLLERS)`` that file with the controllers that stand for Gazebo's
plug-ins. Their names stand in `teleopctl.plugins`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.errors import InvalidDescriptionError, LaunchError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.substitution import Substitution
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    from teleopctl.robot import MotionPlugins, RobotDescription

AS_DESCRIBED = "as_described"
_NO_FILE = "its <parameters> {} is no file"


def _file_and_mappings(words: Sequence[str]) -> tuple[Path, dict[str, str]]:
    """Return the file of a description and the arguments that the launch file gives.

    As on the command line of ``xacro``, the file may stand anywhere among them.

    Raises:
        LaunchError: An argument is something else.
    """
    files = [word for word in words if ":=" not in word]
    for word in files[1:]:
        raise LaunchError(f"expected 'name:=value', got '{word}'")
    if not files:
        raise LaunchError("the robot description's file is missing")
    mappings = dict(word.split(":=", 1) for word in words if ":=" in word)
    return resolve_uri(files[0]).absolute(), mappings


def expand(words: Sequence[str], context: LaunchContext) -> str:
    """Return the robot description of a xacro file and its ``name:=value`` arguments.

    Raises:
        TeleopctlError: An argument is something else, or the file cannot be expanded.
    """
    return context.robot_description(*_file_and_mappings(words))


def _robot(words: Sequence[str], context: LaunchContext) -> str:
    from teleopctl.robot import with_mesh_paths

    file, mappings = _file_and_mappings(words)
    given = context.given_to_robot(file, mappings)
    return with_mesh_paths(context.robot_description(file, {**given, **mappings}), file.parent)


def _robot_arguments(words: Sequence[str], context: LaunchContext) -> str:
    """YAML's flow list, which the parameter of the page's node is."""
    file, mappings = _file_and_mappings(words)
    arguments = {**context.given_to_robot(file, mappings), **mappings}
    return json.dumps([f"{name}:={value}" for name, value in arguments.items()])


def _simulated_robot(words: Sequence[str], context: LaunchContext) -> str:
    text, remarks = _with_hardware(words, context)
    if context.launch is not None:
        for remark in remarks:
            context.launch.say("INFO", remark, "launch")
    return text


def _with_hardware(words: Sequence[str], context: LaunchContext) -> tuple[str, tuple[str, ...]]:
    """Return a description with the hardware that is wanted, and what was changed for that."""
    from teleopctl.robot import simulated

    file, hardware, *mappings = words
    if hardware == AS_DESCRIBED:
        return _robot([file, *mappings], context), ()
    text = _robot([file, f"hardware:={hardware}", *mappings], context)
    try:
        urdf, remarks = simulated(text)
    except InvalidDescriptionError as error:
        raise error.at(file) from error
    hint = f"; hardware:={AS_DESCRIBED} takes the description's own"
    return urdf, tuple(remark + (hint if not n else "") for n, remark in enumerate(remarks))


def _robot_controllers(words: Sequence[str], context: LaunchContext) -> str:
    """The file that the description names, else the last argument, else a file made for it."""
    from teleopctl.robot import described_controllers

    *robot, otherwise = words
    description, plugins = _described(robot, context)
    named = described_controllers(description)
    if not named:
        return otherwise or str(_made_for(description, plugins, context))
    for path in named:
        if not resolve_uri(path).is_file():
            raise LaunchError(f"{robot[0]}: <plugin> of ros2_control: {_NO_FILE.format(path)}")
    if context.launch is not None:
        others = f"; not read: {', '.join(named[1:])}" if named[1:] else ""
        context.launch.say("INFO", f"Controllers of the description: {named[0]}{others}", "launch")
    return str(resolve_uri(named[0]).absolute())


def _described(
    words: Sequence[str], context: LaunchContext
) -> tuple[RobotDescription, MotionPlugins]:
    """Return a description with the hardware that is wanted, and what its plug-ins become."""
    from teleopctl.robot import MotionPlugins, RobotDescription, motion_plugins

    text, _ = _with_hardware(words, context)
    description = RobotDescription.from_urdf(text)
    as_described = words[1] == AS_DESCRIBED
    return description, MotionPlugins() if as_described else motion_plugins(description)


def _with_plugins(words: Sequence[str], context: LaunchContext) -> str:
    """The controllers' file, or one that has the plug-ins' controllers behind what stands there."""
    import yaml

    *robot, controllers_file = words
    _, plugins = _described(robot, context)
    if context.launch is not None:
        for remark in plugins.remarks:
            context.launch.say("INFO", remark, "launch")
    if not plugins.controllers:
        return controllers_file
    text = resolve_uri(controllers_file).read_text(encoding="utf-8")
    file = context.log_directory / "controllers_with_plugins.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    more = yaml.safe_dump(plugins.as_parameters(), sort_keys=False)
    file.write_text(f"{text}\n# Gazebo's plug-ins of the description.\n{more}", encoding="utf-8")
    return str(file)


def _made_for(
    description: RobotDescription, plugins: MotionPlugins, context: LaunchContext
) -> Path:
    """Write parameters of controllers that move every joint that can be commanded."""
    import yaml

    from teleopctl.robot import controllers_for

    file = context.log_directory / "controllers.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    text = yaml.safe_dump(controllers_for(description, plugins), sort_keys=False)
    file.write_text(text, encoding="utf-8")
    if context.launch is not None:
        context.launch.say(
            "INFO", f"No controllers_file is given or described: those of {file}", "launch"
        )
    return file


ROBOT = Substitution(_robot, 1, None)
ROBOT_ARGUMENTS = Substitution(_robot_arguments, 1, None)
ROBOT_CONTROLLERS = Substitution(_robot_controllers, 3, None)
SIMULATED_ROBOT = Substitution(_simulated_robot, 2, None)
WITH_PLUGINS = Substitution(_with_plugins, 3, None)
XACRO = Substitution(expand, 1, None)
