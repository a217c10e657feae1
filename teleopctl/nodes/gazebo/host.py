"""``gz sim``, ``gzserver`` and ``gazebo``: wait for a robot, and simulate it with MuJoCo.

As with Gazebo there is nothing in the world before somebody spawns it: ``create`` and
``spawn_entity.py`` set the parameters ``robot_description`` and ``robot_pose``, which succeeds once
the robot stands in the simulator. What simulates it are programs of ours, which end with this one.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Sequence
from typing import Any

from teleopctl import progress
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    ExternalShutdownException,
    LoggingSeverity,
    Node,
    Parameter,
    Publisher,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    spin,
    spin_once,
)
from teleopctl.nodes.gazebo.children import Children
from teleopctl.nodes.gazebo.command_line import Request, server_request, sim_request
from teleopctl.nodes.gazebo.simulation import programs_for
from teleopctl.nodes.only_one import refuse_a_second
from teleopctl.robot import RobotDescription, motion_plugins, with_plugin_joints

NAME = "gazebo"
PARAMETER = "robot_description"
POSE_PARAMETER = "robot_pose"
_TOPIC = f"/{PARAMETER}"
_COMMANDED_TOPIC = f"/{NAME}/{PARAMETER}"
_SIMULATOR = "mujoco_sim"
# The end of a child, and what it says of itself, are looked for this often, in seconds.
_LOOK_EVERY_S = 0.1
WITHOUT_EFFECT = "Without effect here, where MuJoCo simulates: {}"
_PAGE = "`teleopctl run rviz2 rviz2` shows the robot in the browser; Gazebo's window is not there"


class Host(Node):
    """Starts the simulation of the first robot that is spawned.

    Args:
        request: What the command line wants.
        children: Takes the programs.
    """

    def __init__(self, request: Request, children: Children) -> None:
        super().__init__(NAME)
        self._paused = request.paused
        self._children = children
        self._has_robot = False
        self._publishers: list[Publisher[Any]] = []
        refuse_a_second(self)
        logger = self.get_logger()
        if not request.has_empty_world:
            logger.warning(f"World {request.world} is not built: the robot stands in an empty one")
        if request.unserved:
            logger.warning(WITHOUT_EFFECT.format(", ".join(request.unserved)))
        if request.has_window:
            logger.info(_PAGE)
        self.declare_parameter(PARAMETER, "")
        self.declare_parameter(POSE_PARAMETER, [0.0] * 6)
        self.add_on_set_parameters_callback(self._on_set_parameters)
        logger.info("Waiting for a robot: `create` or `spawn_entity.py` spawns one")
        if request.verbosity:
            logger.set_level(LoggingSeverity[request.verbosity])
        progress.tell(progress.READY)

    def _on_set_parameters(self, parameters: list[Parameter]) -> Any:
        values = {parameter.name: parameter.value for parameter in parameters}
        if PARAMETER in values:
            urdf, pose = str(values[PARAMETER] or ""), values.get(POSE_PARAMETER, ())
            reason = self._spawn(urdf, pose) if urdf else self._remove()
            if reason:
                self.get_logger().error(reason)
                return _result(successful=False, reason=reason)
        return _result(successful=True)

    def _spawn(self, urdf: str, pose: Sequence[float]) -> str:
        """Simulate a robot, and return why that cannot be; empty when it stands there."""
        if self._has_robot:
            return "There is a robot already: this simulator takes one"
        try:
            description = RobotDescription.from_urdf(urdf)
            commanded = with_plugin_joints(urdf)
            topic = _COMMANDED_TOPIC if commanded != urdf else ""
            programs = programs_for(
                description,
                folder=self._children.folder,
                paused=self._paused,
                pose=pose,
                topic=topic,
            )
        except TeleopctlError as error:
            return f"{error.message} ({error.hint})" if error.hint else error.message
        self._has_robot = True
        if any(pose) and description.root == "world":
            self.get_logger().warning(
                "The robot stands where its description puts it: its root link is the world"
            )
        if not self.get_publishers_info_by_topic(_TOPIC):
            # It was read from a file; the programs take it from where ROS has it.
            self._publish(_TOPIC, urdf)
        if topic:
            self._publish(topic, commanded)
        for remark in motion_plugins(description).remarks:
            self.get_logger().info(remark)
        names = ", ".join(program.name for program in programs)
        self.get_logger().info(f"Simulating '{description.name}': {names}")
        self._children.start(programs)
        return self._wait_for_the_simulator()

    def _remove(self) -> str:
        """End the simulation of the robot, and return why that cannot be."""
        if not self._has_robot:
            return "There is no robot"
        self._children.end()
        self._has_robot = False
        while self._publishers:
            self.destroy_publisher(self._publishers.pop())
        return ""

    def _publish(self, topic: str, urdf: str) -> None:
        message = get_message("std_msgs/msg/String")
        publisher = self.create_publisher(message, topic, qos_profile_latched)
        publisher.publish(message(data=urdf))
        self._publishers.append(publisher)

    def _wait_for_the_simulator(self) -> str:
        while True:
            said = self._children.said(_SIMULATOR)
            if said is not None and said.state == progress.READY:
                return ""
            if said is not None and said.state == progress.FAILED:
                return f"{_SIMULATOR}: {said.detail}"
            if (end := self._children.ended()) is not None:
                return f"{end[0]} has ended with status {end[1]}"
            time.sleep(_LOOK_EVERY_S)


def gz() -> int:
    """Run ``gz sim``.

    Raises:
        UsageError: It is another subcommand, which needs Gazebo itself.
    """
    words = _words()
    command = words[0] if words else ""
    if command in ("--version", "--versions"):
        command = "sim"
    if command not in ("sim", "gazebo"):
        raise UsageError(
            f"gz {command}: of gz's subcommands there is `gz sim`, with MuJoCo",
            hint="The simulator speaks ROS 2: `teleopctl topic list`, `teleopctl service list`.",
        )
    return _run(sim_request(words[1:] if words[0] == command else words))


def gazebo() -> int:
    """Run ``gazebo``: the server, and a word on the window."""
    return _run(server_request(_words(), has_window=True))


def gzserver() -> int:
    """Run ``gzserver``."""
    return _run(server_request(_words(), has_window=False))


def server_of_gz() -> int:
    """Run ``ros_gz_sim gzserver``: time passes from the start.

    Raises:
        UsageError: There is no world.
    """
    given = parse_ros_arguments(sys.argv[1:])
    with init(), Node("gzserver") as asked:
        file = str(asked.declare_parameter("world_sdf_file", "").value)
        text = str(asked.declare_parameter("world_sdf_string", "").value)
    if not (file or text):
        raise UsageError("Must specify either 'world_sdf_file' or 'world_sdf_string'")
    unserved = (*given.program, *(() if file else ("world_sdf_string",)))
    return _run(Request(file, has_window=False, unserved=unserved))


def gzclient() -> int:
    """Say where Gazebo's picture is, and stay: with the window's end many a launch ends."""
    return _show(server_request(_words(), has_window=True))


def _words() -> tuple[str, ...]:
    return parse_ros_arguments(sys.argv[1:]).program


def _show(request: Request) -> int:
    if request.asks_version:
        return _tell_version()
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(),
        Node("gzclient") as node,
    ):
        if request.unserved:
            node.get_logger().warning(WITHOUT_EFFECT.format(", ".join(request.unserved)))
        node.get_logger().info(_PAGE)
        spin(node)
    return 0


def _tell_version() -> int:
    from importlib.metadata import version

    sys.stdout.write(f"teleopctl {version('teleopctl')}, MuJoCo {version('mujoco')}\n")
    return 0


def _run(request: Request) -> int:
    """Run until it is interrupted, or until one of the programs ends."""
    if request.asks_version:
        return _tell_version()
    if not request.has_server:
        return _show(request)
    # Behind `init`: what is told while the children end may still be published.
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(),
        Children() as children,
        Host(request, children) as node,
    ):
        while True:
            spin_once(node, timeout_sec=_LOOK_EVERY_S)
            if (end := children.ended()) is not None:
                node.get_logger().error(f"{end[0]} has ended with status {end[1]}: so does this")
                return end[1]
    return 0


def _result(*, successful: bool, reason: str = "") -> Any:
    return get_message("rcl_interfaces/msg/SetParametersResult")(
        successful=successful, reason=reason
    )
