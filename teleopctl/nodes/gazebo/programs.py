"""Programs that simulate one robot, chosen by its description, and their processes."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from teleopctl.base import background, progress
from teleopctl.errors import InvalidDescriptionError
from teleopctl.node import read_parameter_file
from teleopctl.packages import resolve_uri
from teleopctl.robot import MotionPlugins, PluginTag, RobotDescription, motion_plugins

_MANAGER = "controller_manager"
_DEFAULT_RATE_HZ = 100


class Program(NamedTuple):
    """Program to run as a child process of a Gazebo program: name and command line.

    Attributes:
        name: Name of the program in messages.
        command: Command line of the program.
        ends: Whether the program exits by itself when its work is done.
    """

    name: str
    command: list[str]
    ends: bool = False


def programs_for(
    description: RobotDescription,
    *,
    folder: Path,
    paused: bool,
    pose: Sequence[float] = (),
    topic: str = "",
    world: Path | None = None,
) -> list[Program]:
    """Return the programs to start for a robot: simulator with controller manager, spawner, camera.

    Args:
        description: Description of the robot.
        folder: Folder for parameter files of the programs.
        paused: Whether the simulation starts paused.
        pose: Initial pose: x, y, z (m), roll, pitch, yaw (rad); empty for the default.
        topic: Topic of the description; empty for ``/robot_description``.
        world: Path of the world file; None for an empty world.

    Raises:
        TeleopctlError: A parameter file that the description names cannot be read.
    """
    control = next((one for one in description.gazebo.plugins if one.runs_controllers), None)
    files = [] if control is None else _files(control)
    plugins = motion_plugins(description)
    sensors = description.gazebo.sensors
    simulator = [f"update_rate:={_rate(files)}", f"paused:={str(paused).lower()}"]
    place = [f"spawn_pose:={[float(value) for value in pose]}"] if pose else []
    simulator += place
    # In quotes, so that YAML reads any path as a string.
    around = [] if world is None else [f"world:={json.dumps(str(world))}"]
    simulator += around
    elsewhere = ["-r", f"/robot_description:={topic}"] if topic else []
    if control is None and not plugins.controllers:
        programs = [_program("mujoco_sim", "mujoco_sim", elsewhere, parameters=simulator)]
    else:
        words = elsewhere + _words_of_manager(control, files)
        name = _name_of_manager(control)
        if plugins.controllers:
            file = _parameters_of(plugins, name.rpartition("/")[2], folder)
            words += ["--params-file", str(file)]
        # The simulator hosts the controller manager, as with Gazebo's plug-in.
        hosted = shlex.join(["--ros-args", *words, "-p", "use_sim_time:=true"])
        programs = [
            _program(
                "mujoco_sim",
                "mujoco_sim",
                elsewhere,
                parameters=simulator,
                # A launch file may start one itself, as for a robot without Gazebo.
                program=[f"--controller-manager={hosted}", "--unless-running"],
            )
        ]
        if plugins.controllers:
            names = [controller.name for controller in plugins.controllers]
            words = [*names, "--controller-manager", name, "--param-file", str(file)]
            programs.append(_program(_MANAGER, "spawner", program=words)._replace(ends=True))
    if any(sensor.camera is not None for sensor in sensors):
        programs.append(
            _program(
                "camera", "camera", elsewhere, parameters=["use_sim_time:=true", *place, *around]
            )
        )
    return programs


def _files(plugin: PluginTag) -> list[Path]:
    files = [resolve_uri(text).absolute() for text in plugin.parameters.get("parameters", ())]
    for file in files:
        if not file.is_file():
            raise InvalidDescriptionError(
                f"<plugin filename='{plugin.filename}'>: its <parameters> {file} is not a file"
            )
    return files


def _rate(files: list[Path]) -> int:
    """Return the update rate (Hz) of the controllers: one cycle per state of the simulator."""
    rate = _DEFAULT_RATE_HZ
    for file in files:
        found = read_parameter_file(file).for_node(f"/{_MANAGER}").get("update_rate")
        if isinstance(found, int) and not isinstance(found, bool):
            rate = found
    return rate


def _parameters_of(plugins: MotionPlugins, manager: str, folder: Path) -> Path:
    """Write the parameters of the controllers that replace plug-ins to a file; return its path."""
    import yaml

    file = Path(tempfile.mkdtemp(dir=folder)) / "plugins.yaml"
    file.write_text(yaml.safe_dump(plugins.as_parameters(manager), sort_keys=False), "utf-8")
    return file


def _name_of_manager(plugin: PluginTag | None) -> str:
    """Return the full name of the controller manager."""
    if plugin is None:
        return f"/{_MANAGER}"
    name = plugin.parameter("controller_manager_name") or plugin.parameter(
        "controller_manager_prefix_node_name"
    )
    namespace = plugin.parameter("ros/namespace").strip("/")
    return f"{f'/{namespace}' if namespace else ''}/{name or _MANAGER}"


def _words_of_manager(plugin: PluginTag | None, files: list[Path]) -> list[str]:
    if plugin is None:
        return []
    words = [word for file in files for word in ("--params-file", str(file))]
    namespace, _, name = _name_of_manager(plugin).rpartition("/")
    if name != _MANAGER:
        words += ["-r", f"__node:={name}"]
    if namespace:
        words += ["-r", f"__ns:={namespace}"]
    for remapping in plugin.parameters.get("ros/remapping", ()):
        words += ["-r", remapping]
    return words


def _program(
    package: str,
    executable: str,
    words: Sequence[str] = (),
    *,
    parameters: Sequence[str] = (),
    program: Sequence[str] = (),
) -> Program:
    command = [sys.executable, "-P", "-m", "teleopctl.nodes", "--builtin", package, executable]
    command += [*program, "--ros-args", *words]
    for parameter in parameters:
        command += ["-p", parameter]
    return Program(executable, command)


# Ctrl-C, and the end of a launch, signal the whole process group, so the children may exit by
# themselves within this time, in seconds.
_GRACE_S = 2.0


class ChildPrograms:
    """Child processes of a Gazebo program; ``with`` ends them all, the simulator last."""

    def __init__(self) -> None:
        self._folder = background.temporary_folder()
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._may_end: set[str] = set()

    def __enter__(self) -> ChildPrograms:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        interrupted = kind is not None and issubclass(kind, KeyboardInterrupt)
        self._end(at_once=not interrupted)
        self._folder.remove()

    @property
    def folder(self) -> Path:
        """Temporary folder for files of the child processes."""
        return self._folder.path

    def start(self, programs: Iterable[Program]) -> None:
        """Start programs as child processes."""
        for program in programs:
            if program.ends:
                self._may_end.add(program.name)
            said = progress.progress_file(self._log(program.name))
            self._processes[program.name] = subprocess.Popen(
                program.command,
                env={**os.environ, progress.VARIABLE: str(said)},
                stdin=subprocess.DEVNULL,
                restore_signals=False,
            )

    def progress_of(self, name: str) -> progress.Progress | None:
        """Return the last progress that a named child process has reported; None if none."""
        return progress.read(self._log(name))

    def end(self) -> None:
        """End all child processes, the simulator last, and remove them from this object."""
        self._end(at_once=True)
        for name in self._processes:
            progress.progress_file(self._log(name)).unlink(missing_ok=True)
        self._processes.clear()

    def ended(self) -> tuple[str, int] | None:
        """Return (name, exit status) of a child process that ended unexpectedly, or None."""
        for name, process in self._processes.items():
            status = process.poll()
            if status is not None and not (status == 0 and name in self._may_end):
                return name, status if status >= 0 else 128 - status
        return None

    def _log(self, name: str) -> Path:
        return self.folder / f"{name}.log"

    def _end(self, *, at_once: bool) -> None:
        # The simulator ends last: a controller manager still deactivates its hardware.
        steps = [signal.SIGTERM] if sys.platform == "win32" else [signal.SIGINT, signal.SIGTERM]
        if not at_once:
            self._wait()
        for number in steps:
            for process in reversed(self._processes.values()):
                if process.poll() is None:
                    process.send_signal(number)
            self._wait()
        for process in self._processes.values():
            process.kill()
            process.wait()

    def _wait(self) -> None:
        deadline = time.monotonic() + _GRACE_S
        for process in self._processes.values():
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                return
