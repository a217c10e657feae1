"""The programs that simulate one robot, as its description asks Gazebo for them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.node import read_parameter_file
from teleopctl.packages import resolve_uri
from teleopctl.robot import Plugin, RobotDescription

_MANAGER = "controller_manager"
_DEFAULT_RATE_HZ = 100


class Program(NamedTuple):
    """A program of ours to start.

    Attributes:
        name: What it is called in messages.
        command: Its command line.
    """

    name: str
    command: list[str]


def programs_for(
    description: RobotDescription, *, paused: bool, pose: Sequence[float] = ()
) -> list[Program]:
    """Return what simulates a robot, the simulator first.

    Args:
        description: The robot.
        paused: Whether time is to stand still.
        pose: Where it is to start: x, y, z, roll, pitch, yaw; empty for nowhere in particular.

    Raises:
        TeleopctlError: A file of parameters that the description names cannot be read.
    """
    control = next(filter(_is_control, description.gazebo.plugins), None)
    files = [] if control is None else _files(control)
    sensors = description.gazebo.sensors
    simulator = [f"update_rate:={_rate(files)}", f"paused:={str(paused).lower()}"]
    if pose:
        simulator.append(f"spawn_pose:={[float(value) for value in pose]}")
    programs = [_program("mujoco_sim", "mujoco_sim", parameters=simulator)]
    if control is not None:
        programs.append(_controller_manager(control, files))
    if any(sensor.camera is not None for sensor in sensors):
        programs.append(_program("camera", "camera", parameters=["use_sim_time:=true"]))
    return programs


def _is_control(plugin: Plugin) -> bool:
    """Whether a plug-in is the one that runs a controller manager within Gazebo."""
    return "ros2_control" in plugin.filename


def _files(plugin: Plugin) -> list[Path]:
    files = [resolve_uri(text).absolute() for text in plugin.parameters.get("parameters", ())]
    for file in files:
        if not file.is_file():
            raise InvalidDescriptionError(
                f"<plugin filename='{plugin.filename}'>: its <parameters> {file} is no file"
            )
    return files


def _rate(files: list[Path]) -> int:
    """Return in Hz how often controllers compute: one cycle for each state of the simulator."""
    rate = _DEFAULT_RATE_HZ
    for file in files:
        found = read_parameter_file(file).for_node(f"/{_MANAGER}").get("update_rate")
        if isinstance(found, int) and not isinstance(found, bool):
            rate = found
    return rate


def _controller_manager(plugin: Plugin, files: list[Path]) -> Program:
    words = [word for file in files for word in ("--params-file", str(file))]
    name = plugin.parameter("controller_manager_name") or plugin.parameter(
        "controller_manager_prefix_node_name"
    )
    if name:
        words += ["-r", f"__node:={name}"]
    if namespace := plugin.parameter("ros/namespace"):
        words += ["-r", f"__ns:=/{namespace.strip('/')}"]
    for remapping in plugin.parameters.get("ros/remapping", ()):
        words += ["-r", remapping]
    return _program(_MANAGER, "ros2_control_node", words, parameters=["use_sim_time:=true"])


def _program(
    package: str, executable: str, words: list[str] | None = None, *, parameters: list[str]
) -> Program:
    command = [sys.executable, "-P", "-m", "teleopctl.nodes", "--builtin", package, executable]
    command += ["--ros-args", *(words or ())]
    for parameter in parameters:
        command += ["-p", parameter]
    return Program(executable, command)
