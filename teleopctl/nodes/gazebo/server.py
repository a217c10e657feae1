"""Executables ``gz sim``, ``gzserver`` and ``gazebo``: simulate the first spawned robot.

``create`` and ``spawn_entity.py`` set the parameters of a `GazeboEntity`, which succeeds once the
entity is in the simulator; other programs call ``/spawn_entity``. The simulator has one robot;
other spawned entities are objects around the robot, in whatever order they are spawned. The
simulation runs in child processes, which end with this program.
"""

from __future__ import annotations

import contextlib
import queue
import sys
import time
from typing import Any

from teleopctl.base import progress
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
from teleopctl.nodes.gazebo.command_line import (
    GazeboRequest,
    server_request,
    sim_request,
    world_file,
)
from teleopctl.nodes.gazebo.entities import (
    DESCRIPTION,
    GazeboEntity,
    ObjectSpawner,
    offer_spawn_services,
)
from teleopctl.nodes.gazebo.programs import ChildPrograms, programs_for
from teleopctl.nodes.single_instance import require_single_instance
from teleopctl.robot import (
    RobotDescription,
    motion_plugins,
    with_plugin_joints,
    with_ros2_control_of,
)

NAME = "gazebo"
_TOPIC = f"/{DESCRIPTION}"
# Topic of the simulated description, if it differs from the one on `/robot_description`.
_OWN_TOPIC = f"/{NAME}/{DESCRIPTION}"
_SIMULATOR = "mujoco_sim"
# Period at which the children's progress and end are checked, in seconds.
_LOOK_EVERY_S = 0.1
# Longest wait for the description of robot_state_publisher, in seconds.
_DESCRIBED_WITHIN_S = 10.0
WITHOUT_EFFECT = "Without effect here, where MuJoCo simulates: {}"
_PAGE = "`teleopctl run rviz2 rviz2` shows the robot in the browser; there is no Gazebo window"


class GazeboServer(Node):
    """Node ``gazebo``: starts the simulator for a spawned robot, and spawns other entities.

    Args:
        request: Parsed command line.
        children: Child processes, to which the simulator and its programs are added.

    Raises:
        InvalidDescriptionError: The world cannot be read.
        RefusedError: A node of the same name runs already.
    """

    def __init__(self, request: GazeboRequest, children: ChildPrograms) -> None:
        super().__init__(NAME)
        self._paused = request.paused
        self._children = children
        self._robot: GazeboEntity | None = None
        self._description: RobotDescription | None = None
        self._things = ObjectSpawner()
        self._publishers: list[Publisher[Any]] = []
        require_single_instance(self)
        logger = self.get_logger()
        self._world = world_file(request, children.folder, logger)
        if request.unserved:
            logger.warning(WITHOUT_EFFECT.format(", ".join(request.unserved)))
        if request.has_window:
            logger.info(_PAGE)
        for parameter in GazeboEntity().as_parameters():
            self.declare_parameter(parameter.name, parameter.value)
        self.add_on_set_parameters_callback(self._on_set_parameters)
        offer_spawn_services(self, self._take)
        logger.info("Waiting for a robot: `create` or `spawn_entity.py` spawns one")
        if request.verbosity:
            logger.set_level(LoggingSeverity[request.verbosity])
        progress.report(progress.READY)

    def destroy_node(self) -> None:
        """Destroy this node and the node whose clients call the simulator."""
        self._things.close()
        super().destroy_node()

    def _on_set_parameters(self, parameters: list[Parameter]) -> Any:
        values = {parameter.name: parameter.value for parameter in parameters}
        if DESCRIPTION in values:
            reason = self._take(GazeboEntity.of_parameters(values))
            return _result(successful=not reason, reason=reason)
        return _result(successful=True)

    def _take(self, entity: GazeboEntity) -> str:
        """Spawn or delete an entity; return the reason of a failure, empty on success."""
        try:
            reason = self._spawn(entity) if entity.text else self._remove(entity.name)
        except TeleopctlError as error:
            reason = f"{error.message} ({error.hint})" if error.hint else error.message
        if reason:
            self.get_logger().error(reason)
        return reason

    def _spawn(self, entity: GazeboEntity) -> str:
        """Spawn an entity; return the reason of a failure, empty on success.

        Raises:
            TeleopctlError: The entity's description cannot be read.
        """
        if self._robot is None:
            return self._start(entity)
        assert self._description is not None
        description = RobotDescription.from_urdf(entity.urdf(self._children.folder))
        if entity.robot_rank(description) <= self._robot.robot_rank(self._description):
            return self._things.spawn(entity)
        first = self._robot
        self.get_logger().info(
            f"'{description.name}' is the robot, and '{self._description.name}' an object beside "
            "it: the simulation restarts"
        )
        self._end()
        reason = self._start(entity)
        if reason:
            self._end()
            self._start(first)
            return reason
        return self._things.spawn(first)

    def _start(self, robot: GazeboEntity) -> str:
        """Start the simulation of a robot; return the reason of a failure, empty on success.

        Raises:
            TeleopctlError: The description, or a file that it names, cannot be read.
        """
        urdf = robot.urdf(self._children.folder)
        description = RobotDescription.from_urdf(urdf)
        if not description.ros2_control and any(
            p.runs_controllers for p in description.gazebo.plugins
        ):
            urdf = with_ros2_control_of(urdf, self._published_description() or urdf)
            description = RobotDescription.from_urdf(urdf)
        commanded = with_plugin_joints(urdf)
        is_on_topic = robot.topic.lstrip("/") == DESCRIPTION
        topic = "" if is_on_topic and commanded == urdf else _OWN_TOPIC
        programs = programs_for(
            description,
            folder=self._children.folder,
            paused=self._paused,
            pose=robot.pose,
            topic=topic,
            world=self._world,
        )
        self._robot, self._description = robot, description
        if any(robot.pose) and description.root == "world":
            self.get_logger().warning(
                "The pose is ignored: the root link of the robot is the world"
            )
        if not self.get_publishers_info_by_topic(_TOPIC):
            # The description is from a file; other nodes subscribe to `/robot_description`.
            self._publish(_TOPIC, urdf)
        if topic:
            self._publish(topic, commanded)
        if not is_on_topic:
            for repair in description.repairs:
                self.get_logger().warning(repair)
        for remark in motion_plugins(description).remarks:
            self.get_logger().info(remark)
        names = ", ".join(program.name for program in programs)
        self.get_logger().info(f"Simulating '{description.name}': {names}")
        self._children.start(programs)
        reason = self._wait_for_simulator()
        things = [] if reason else list(self._things.entities.values())
        for thing in things:
            if lost := self._things.spawn(thing):
                self.get_logger().error(f"'{thing.name}' was removed: {lost}")
        return reason

    def _published_description(self) -> str:
        """Return the description on ``/robot_description``; wait for it, empty if none comes."""
        received: queue.Queue[str] = queue.Queue()
        subscription = self.create_subscription(
            get_message("std_msgs/msg/String"),
            _TOPIC,
            lambda message: received.put(message.data),
            qos_profile_latched,
            immediate=True,
        )
        progress.report(progress.STARTING, f"waiting for {_TOPIC}, which has the <ros2_control>")
        try:
            return received.get(timeout=_DESCRIBED_WITHIN_S)
        except queue.Empty:
            return ""
        finally:
            self.destroy_subscription(subscription)

    def _remove(self, name: str) -> str:
        """Delete the robot or an object; return the reason of a failure, empty on success."""
        if self._robot is None or self._description is None:
            return "There is no robot"
        if name not in ("", self._robot.name, self._description.name):
            return self._things.delete(name)
        self._end()
        return ""

    def _end(self) -> None:
        """End the simulation."""
        self._children.end()
        self._robot = self._description = None
        while self._publishers:
            self.destroy_publisher(self._publishers.pop())

    def _publish(self, topic: str, urdf: str) -> None:
        message = get_message("std_msgs/msg/String")
        publisher = self.create_publisher(message, topic, qos_profile_latched)
        publisher.publish(message(data=urdf))
        self._publishers.append(publisher)

    def _wait_for_simulator(self) -> str:
        # The spawning program waits for this node, so this node reports the simulator's progress.
        progress.report(progress.STARTING, "starting the simulation")
        try:
            return self._watch_simulator_start()
        finally:
            progress.report(progress.READY)

    def _watch_simulator_start(self) -> str:
        shown = ""
        while True:
            said = self._children.progress_of(_SIMULATOR)
            if said is not None and said.state == progress.STARTING and said.detail != shown:
                shown = said.detail
                progress.doing(shown)
            if said is not None and said.state == progress.READY:
                return ""
            if said is not None and said.state == progress.FAILED:
                if said.part != progress.CONTROL:
                    return f"{_SIMULATOR}: {said.detail}"
                # As in Gazebo, the robot is there, without controllers.
                self.get_logger().error(f"controller_manager: {said.detail}")
                return ""
            if (end := self._children.ended()) is not None:
                return f"{end[0]} has ended with status {end[1]}"
            time.sleep(_LOOK_EVERY_S)


def gz() -> int:
    """Run ``gz sim``, with MuJoCo in place of Gazebo, until Ctrl-C; return the exit status.

    Raises:
        UsageError: The subcommand is not ``sim``, and needs Gazebo itself.
    """
    words = _words()
    command = words[0] if words else ""
    if command in ("--version", "--versions"):
        command = "sim"
    if command not in ("sim", "gazebo"):
        raise UsageError(
            f"gz {command}: of gz's subcommands there is `gz sim`, with MuJoCo",
            hint="The simulator has topics and services of ROS 2: `teleopctl topic list`, "
            "`teleopctl service list`.",
        )
    return _run(sim_request(words[1:] if words[0] == command else words))


def gazebo() -> int:
    """Run ``gazebo`` as ``gzserver``, with a log line in place of the window; return the status."""
    return _run(server_request(_words(), has_window=True))


def gzserver() -> int:
    """Run ``gzserver``, with MuJoCo in place of Gazebo, until Ctrl-C; return the exit status."""
    return _run(server_request(_words(), has_window=False))


def server_of_gz() -> int:
    """Run ``ros_gz_sim gzserver`` with the world of its parameters; return the exit status.

    Raises:
        UsageError: Neither parameter gives a world.
    """
    given = parse_ros_arguments(sys.argv[1:])
    with init(publishes_after_signal=True), Node("gzserver") as asked:
        file = str(asked.declare_parameter("world_sdf_file", "").value)
        text = str(asked.declare_parameter("world_sdf_string", "").value)
    if not (file or text):
        raise UsageError("Must specify either 'world_sdf_file' or 'world_sdf_string'")
    unserved = (*given.program, *(["world_sdf_string"] if file and text else []))
    return _run(GazeboRequest(file, "" if file else text, has_window=False, unserved=unserved))


def gzclient() -> int:
    """Run ``gzclient`` until Ctrl-C: log how to open the web page in place of the window."""
    return _show(server_request(_words(), has_window=True))


def _words() -> tuple[str, ...]:
    return parse_ros_arguments(sys.argv[1:]).program


def _show(request: GazeboRequest) -> int:
    if request.asks_version:
        return _print_version()
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(publishes_after_signal=True),
        Node("gzclient") as node,
    ):
        if request.unserved:
            node.get_logger().warning(WITHOUT_EFFECT.format(", ".join(request.unserved)))
        node.get_logger().info(_PAGE)
        spin(node)
    return 0


def _print_version() -> int:
    from importlib.metadata import version

    sys.stdout.write(f"teleopctl {version('teleopctl')}, MuJoCo {version('mujoco')}\n")
    return 0


def _run(request: GazeboRequest) -> int:
    """Run the node ``gazebo`` until Ctrl-C or until a child ends; return the exit status."""
    if request.asks_version:
        return _print_version()
    if not request.has_server:
        return _show(request)
    # The children end before the context shuts down, so the node can still log and publish.
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(publishes_after_signal=True),
        ChildPrograms() as children,
        GazeboServer(request, children) as node,
    ):
        while True:
            spin_once(node, timeout_sec=_LOOK_EVERY_S)
            if (end := children.ended()) is not None:
                node.get_logger().error(
                    f"{end[0]} has ended with status {end[1]}: this program ends as well"
                )
                return end[1]
    return 0


def _result(*, successful: bool, reason: str = "") -> Any:
    return get_message("rcl_interfaces/msg/SetParametersResult")(
        successful=successful, reason=reason
    )
