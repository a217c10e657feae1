"""Node ``mujoco_sim``: parameters, topics and services around the simulation."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

import mujoco

from teleopctl.base import progress
from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message, set_stamp, to_nanoseconds
from teleopctl.node import (
    Node,
    Parameter,
    qos_profile_latched,
)
from teleopctl.robot import RobotDescription
from teleopctl.sim.assembly import (
    RANGES,
    assemble,
    build_robot,
    checked_number,
    declare_parameters,
    number_of,
)
from teleopctl.sim.cameras.model_topic import ModelPublisher
from teleopctl.sim.entities.running_simulation import RunningSimulation
from teleopctl.sim.entities.standard_services import offer_standard_services
from teleopctl.sim.gazebo_services import GazeboServices
from teleopctl.sim.lockstep import Command, LockstepLoop
from teleopctl.sim.ports import CHANGES_TOPIC, HostedController
from teleopctl.sim.reporting import PerformancePublisher, report_robot
from teleopctl.sim.sensors.settings import checked_numbers
from teleopctl.sim.state.services import MujocoServices
from teleopctl.sim.world_markers import WorldMarkers
from teleopctl.wire import EntityKind

_String = get_message("std_msgs/msg/String")
_Twist = get_message("geometry_msgs/msg/Twist")
_SimulationChange = get_message("teleopctl_msgs/msg/SimulationChange")
_JointState = get_message("sensor_msgs/msg/JointState")
_SetParametersResult = get_message("rcl_interfaces/msg/SetParametersResult")

_DESCRIPTION_TOPIC = "/robot_description"
_READ_AT_START = {
    *("update_rate", "timestep", "lockstep_timeout", "state_rate", "paused"),
    *("joint_states_topic", "joint_commands_topic", "robot_description"),
}
# Time that a service waits for the loop, in seconds of wall time, on top of a lockstep timeout.
_TIMEOUT_S = 10.0
# Longest wait for the physics thread at the end, in seconds of wall time.
_LONGEST_END_S = 3.0


class MujocoSim(Node):
    """Simulator node ``mujoco_sim``; physics has its own thread, services run on the executor's.

    Args:
        controller: Controller in this process, which the physics thread calls at each control tick;
            None for controllers elsewhere.
    """

    def __init__(self, controller: HostedController | None = None) -> None:
        progress.report(progress.STARTING)
        super().__init__("mujoco_sim")
        self._controller = controller
        self._loop: LockstepLoop | None = None
        self._thread: threading.Thread | None = None
        self._urdf = ""
        self._last_names: list[str] = []
        self._commanders = 0
        self._subscriptions: dict[str, int] = {}
        # What an earlier graph means must not be set after a later one. Reentrant, since a new
        # endpoint of this node changes the graph as well.
        self._graph_lock = threading.RLock()
        declare_parameters(self)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._follow_parameters)
        mujoco.set_mju_user_warning(self._on_mujoco_warning)
        self._running: RunningSimulation | None = None
        MujocoServices(self, lambda: self._running)
        offer_standard_services(self, lambda: self._running)
        GazeboServices(self, lambda: self._running)
        given = str(self.get_parameter("robot_description").value)
        if given:
            self._start(given)
            for repair in RobotDescription.from_urdf(given).repairs:
                self.get_logger().warning(repair)
        else:
            self._description = self.create_subscription(
                _String, _DESCRIPTION_TOPIC, self._on_description, qos_profile_latched
            )
            topic = self._description.topic_name
            self.get_logger().info(f"Waiting for the robot description on {topic}")
            progress.report(progress.WAITING, topic)

    def _on_mujoco_warning(self, text: str) -> None:
        # Unstable physics causes a warning in each step.
        self.get_logger().warning(f"MuJoCo: {text}", throttle_duration_sec=10.0)

    # --- parameters -----------------------------------------------------------------------

    def _check_parameters(self, parameters: list[Parameter]) -> Any:
        for parameter in parameters:
            try:
                if self._loop is not None and parameter.name in _READ_AT_START:
                    raise InvalidParameterError(f"'{parameter.name}' is read at the start only")
                if parameter.name in RANGES:
                    checked_number(parameter)
                if parameter.name == "gravity":
                    checked_numbers(parameter, "x", "y", "z")
            except InvalidParameterError as error:
                return _SetParametersResult(successful=False, reason=error.message)
        return _SetParametersResult(successful=True)

    def _follow_parameters(self, parameters: list[Parameter]) -> None:
        """Apply parameters once set: before, another one of the same request may be refused."""
        if self._loop is None:
            return
        for parameter in parameters:
            if parameter.name == "publish_base_tf":
                self._ports.show_base(bool(parameter.value))
            if parameter.name == "gravity":
                self._set_gravity(checked_numbers(parameter, "x", "y", "z"))
            if parameter.name == "real_time_factor":
                self._loop.set_real_time_factor(checked_number(parameter))

    def _set_gravity(self, gravity: list[float]) -> None:
        assert self._loop is not None
        # Without waiting: the loop's own thread may set the parameter.
        self._loop.post(lambda: self._simulation.set_gravity(gravity))

    # --- start ----------------------------------------------------------------------------

    def _on_description(self, message: Any) -> None:
        if self._loop is not None:
            if message.data != self._urdf:
                self.get_logger().warning(
                    "Another robot description was published; this simulator keeps the first one"
                )
            return
        # This may be the first use of the graph, whose entries arrive by event.
        topic = self._description.topic_name
        self.wait_for_match(EntityKind.MP, topic, message.TYPE_NAME, 1, 1.0)
        publishers = self.get_publishers_info_by_topic(topic)
        names = sorted({publisher.node_name for publisher in publishers}) or ["its publisher"]
        self.get_logger().info(f"Connected to {', '.join(names)}")
        self._start(message.data)

    def _start(self, urdf: str) -> None:
        logger = self.get_logger()
        progress.report(progress.STARTING)
        logger.info("Received the robot description, parsing...")
        self._urdf = urdf
        robot = build_robot(self, urdf)
        description, model, simulation = robot.description, robot.model, robot.simulation
        report_robot(logger, description, model)
        period_s, step_s = simulation.control_period_ns * 1e-9, simulation.timestep_s
        if period_s > step_s:
            # Gazebo's plug-in warns here, though several physics steps per command are normal.
            logger.info(
                f"Desired controller update period ({period_s:g} s) is slower than the simulation "
                f"period ({step_s:g} s)."
            )
        made = assemble(self, robot, self._controller)
        ports, self._sensors = made.ports, made.sensors
        self._loop = made.loop(self)
        self._simulation = simulation
        PerformancePublisher(self, simulation, self._loop)
        self._commands = self.create_subscription(
            _JointState,
            str(self.get_parameter("joint_commands_topic").value),
            self._on_command,
            10,
            immediate=True,
        )
        for mover in simulation.movers:
            self.create_subscription(_Twist, mover.topic, mover.receive, 10, immediate=True)
        self._ports = ports
        self._markers = WorldMarkers(self, model)
        self._shown = ModelPublisher(self)
        self._changes = self.create_publisher(_SimulationChange, CHANGES_TOPIC, 100)
        self._running = RunningSimulation(
            simulation,
            self._loop,
            timeout_s=self._timeout_s,
            world=robot.world,
            on_change=self._on_change,
            on_restart=self._sensors.restart,
            record=self._record,
        )
        self.add_graph_callback(self._on_graph)
        self._on_graph()
        logger.info("Simulation is paused" if self._loop.paused else "Simulation is running")
        self._thread = threading.Thread(target=self._run, name="physics", daemon=True)
        self._thread.start()
        if self._controller is not None:
            self._controller.simulation_started()
        progress.report(progress.READY)

    def _run(self) -> None:
        assert self._loop is not None
        try:
            self._loop.run()
            if self._loop.at_end:
                self.get_logger().info(f"The simulation ends at {number_of(self, 'end_time'):g} s")
                self.context.try_shutdown()
        except Exception as error:  # noqa: BLE001 - the thread that spins raises it
            self.fail(error)

    # --- the controller -------------------------------------------------------------------

    def _on_graph(self) -> None:
        """Count publishers and subscribers; called on other threads after each graph change."""
        with self._graph_lock:
            self._count_endpoints()

    def _count_endpoints(self) -> None:
        assert self._loop is not None
        before, self._commanders = self._commanders, self._commands.get_publisher_count()
        has_controller, commanded = self._ports.has_controller(), self._commanders > 0
        is_hosted = self._controller is not None and self._controller.is_connected
        self._ports.publishes_states = self._controller is None or has_controller
        self._loop.set_controller_present(is_hosted or (has_controller and commanded))
        self._loop.set_subscribed(
            clock=self._ports.has_clock(), ticks=is_hosted or has_controller or commanded
        )
        self._loop.set_viewed(self._ports.is_viewed())
        self._sensors.on_graph_change()
        before_now, self._subscriptions = (
            self._subscriptions,
            {
                **self._ports.subscription_counts(),
                **self._sensors.subscription_counts(),
            },
        )
        if any(now > before_now.get(topic, 0) for topic, now in self._subscriptions.items()):
            # New subscribers get the state now: nothing is published while time stands still.
            self._loop.post(self._loop.show)
        self._markers.on_graph_change()
        self._shown.on_graph_change()
        if self._commanders > max(before, 1):
            topic = self._commands.topic_name
            names = sorted(info.node_name for info in self.get_publishers_info_by_topic(topic))
            self.get_logger().warning(
                f"{self._commanders} publishers on {topic} ({', '.join(names)}): the first to "
                "answer a state wins, so that runs are not reproducible"
            )

    def _on_command(self, message: Any) -> None:
        """Pass a command to the loop; called on the transport's thread."""
        stamp_ns = to_nanoseconds(message.header.stamp)
        if self._controller is not None and self._controller.published_ns == stamp_ns:
            return  # the hosted controller's own, published for others
        values = (message.position, message.velocity, message.effort)
        self.receive_command(stamp_ns, message.name, *values)

    def controller_changed(self) -> None:
        """Note that the hosted controller was connected or disconnected; any thread may call."""
        if self._running is not None:
            self._on_graph()

    def receive_command(
        self,
        stamp_ns: int,
        names: list[str],
        position: list[float],
        velocity: list[float],
        effort: list[float],
    ) -> None:
        """Pass a command to the loop, if it is valid; any thread may call.

        Args:
            stamp_ns: Time of the state that the command answers, in nanoseconds.
            names: Joint names.
            position: Positions (rad or m), one per name, or empty.
            velocity: Velocities (rad/s or m/s), one per name, or empty.
            effort: Efforts (N m or N), one per name, or empty.
        """
        assert self._loop is not None
        if names != self._last_names:
            self._last_names = names
            unknown = [name for name in names if not self._simulation.commandable(name)]
            if unknown:
                self.get_logger().warning(
                    f"Commands for joints that cannot be commanded: {', '.join(unknown)}"
                )
        values, wanted = (position, velocity, effort), (0, len(names))
        if not (len(position) in wanted and len(velocity) in wanted and len(effort) in wanted):
            self.get_logger().error(
                "A command has not as many values as joint names, it is ignored",
                throttle_duration_sec=10.0,
            )
            return
        self._loop.receive_command(Command(stamp_ns, names, *values))

    # Any: messages, whose classes are made at run time.
    def _record(self, steps: int, free_joints: Sequence[Any]) -> None:
        """Publish a change by a service; called on the loop's thread."""
        change = _SimulationChange(steps=steps, free_joints=list(free_joints))
        set_stamp(change.header.stamp, self._simulation.time_ns)
        self._changes.publish(change)

    def _on_change(self) -> None:
        """Publish changed objects; called on the loop's thread."""
        self._ports.bodies_changed()
        self._markers.replace_model(self._simulation.present_model)
        self._shown.replace_model(self._simulation.present_model)
        if self.get_parameter("gravity").value != self._simulation.gravity:
            # Another world has its own gravity.
            self.set_parameters([Parameter("gravity", value=self._simulation.gravity)])
        self._on_graph()

    # --- services -------------------------------------------------------------------------

    @property
    def _timeout_s(self) -> float:
        return _TIMEOUT_S + number_of(self, "lockstep_timeout")

    def stop(self) -> None:
        """Stop the simulation, and wait up to 3 s for the end of its thread."""
        if self._loop is not None:
            self._loop.stop()
        # Ctrl-C may have arrived while the thread was being started.
        if self._thread is not None and self._thread.is_alive():
            # A hosted controller that never returns must not keep the process.
            self._thread.join(_LONGEST_END_S if self.failure is None else 1.0)

    def destroy_node(self) -> None:
        """Stop the simulation's thread, and destroy the node."""
        self.stop()
        super().destroy_node()
