"""Substitutions for launch files that take any robot.

``$(robot FILE name:=value …)`` is a description with the launch arguments that it takes itself,
and meshes by their whole paths; ``$(robot-arguments FILE name:=value …)`` are those arguments, as
a list. ``$(simulated-robot FILE HARDWARE …)`` is the description whose hardware is the simulator.
What is about its controllers is in `robots_controllers`; the names stand in `teleopctl.plugins`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from teleopctl.errors import InvalidDescriptionError, LaunchError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.substitution import Substitution
from teleopctl.packages import resolve_uri

AS_DESCRIBED = "as_described"


def file_and_mappings(words: Sequence[str]) -> tuple[Path, dict[str, str]]:
    """Split the words of a substitution into description file and xacro arguments.

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
    """Return the robot description of a xacro file with ``name:=value`` arguments.

    Raises:
        TeleopctlError: An argument is something else, or the file cannot be expanded.
    """
    return context.robot_description(*file_and_mappings(words))


def _robot(words: Sequence[str], context: LaunchContext) -> str:
    from teleopctl.robot import with_mesh_paths

    file, mappings = file_and_mappings(words)
    given = context.given_to_robot(file, mappings)
    return with_mesh_paths(context.robot_description(file, {**given, **mappings}), file.parent)


def _robot_arguments(words: Sequence[str], context: LaunchContext) -> str:
    """YAML's flow list, which the parameter of the page's node is."""
    file, mappings = file_and_mappings(words)
    arguments = {**context.given_to_robot(file, mappings), **mappings}
    return json.dumps([f"{name}:={value}" for name, value in arguments.items()])


def _simulated_robot(words: Sequence[str], context: LaunchContext) -> str:
    text, remarks = with_hardware(words, context)
    if context.launch is not None:
        for remark in remarks:
            context.launch.say("INFO", remark, "launch")
    return text


def with_hardware(words: Sequence[str], context: LaunchContext) -> tuple[str, tuple[str, ...]]:
    """Return a robot description with the requested hardware, and remarks on the changes."""
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


ROBOT = Substitution(_robot, 1, None)
ROBOT_ARGUMENTS = Substitution(_robot_arguments, 1, None)
SIMULATED_ROBOT = Substitution(_simulated_robot, 2, None)
XACRO = Substitution(expand, 1, None)
