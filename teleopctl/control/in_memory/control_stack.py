"""The control stack in one thread without ROS: hardware, controllers and time as a test wants."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, cast

from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controllers.base import ControllerInterface, ControllerInterfaceParams
from teleopctl.control.cycle import Cycle
from teleopctl.control.in_memory.recorded_action import RecordedActionServer
from teleopctl.control.in_memory.recorded_node import RecordedNode
from teleopctl.control.lifecycle import State
from teleopctl.control.limits import enforced_by_default
from teleopctl.control.realtime_publisher import PublishQueue
from teleopctl.control.resource_manager import ResourceManager
from teleopctl.control.switching import SwitchRequest, switch_controller
from teleopctl.interfaces import ActionType
from teleopctl.node import ActionServer, AllowableParameterValue, Node, RcutilsLogger
from teleopctl.robot import RobotDescription


class ControlStack:
    """The controller manager with its hardware and control cycle, without a ROS graph.

    A cycle runs when a test says so, as `ControllerManagerNode` would run it on time.

        stack = ControlStack(serial_robot(joints=2))
        stack.load_controller("mine", "my_package:MyController", {"joints": ["joint1"]})
        stack.activate("mine")
        stack.step()
        assert stack.command("joint1/position") == 0.5

    Args:
        urdf: The robot, whose hardware is loaded and activated; None loads none yet.
        update_rate: Cycles per second.
        parameters: Of the controller manager, by dotted name.
        enforce_limits: Whether commands are kept inside the limits of their joints; None is the
            default of the ROS 2 distribution, as for the manager's ``enforce_command_limits``.
        last_only: Whether of what is published only the last message is remembered, for long runs.

    Attributes:
        start_ns: Time before the first cycle, nanoseconds.
        time_ns: Time of the last cycle.
        node: The controller manager's node; ``node.log`` has its lines.
        nodes: The controllers' nodes by name.
        action_servers: The controllers' action servers by ``controller/name``.
        resources: The resource manager.
        manager: The controller manager.
        cycle: The control cycle.
    """

    start_ns: ClassVar[int] = 1_000_000_000_000

    def __init__(
        self,
        urdf: str | None = None,
        *,
        update_rate: int = 100,
        parameters: Mapping[str, AllowableParameterValue] | None = None,
        enforce_limits: bool | None = None,
        last_only: bool = False,
    ) -> None:
        self._last_only = last_only
        self.node = RecordedNode("controller_manager", parameters, last_only=last_only)
        self.log = self.node.log
        self.nodes: dict[str, RecordedNode] = {}
        self.action_servers: dict[str, RecordedActionServer] = {}
        self.time_ns = self.start_ns
        self._controller_parameters: dict[str, dict[str, AllowableParameterValue]] = {}
        logger = cast(RcutilsLogger, self.log)
        self.resources = ResourceManager(
            cast(Node, self.node),
            logger,
            lambda text: self.cycle.report(text),
            enforce_limits=enforced_by_default() if enforce_limits is None else enforce_limits,
        )
        self.publish_queue = PublishQueue(self.log.warning)
        self.manager = ControllerManager(self.resources, self, logger, update_rate)
        self.cycle = Cycle(self.manager, self.publish_queue)
        if urdf is not None:
            self.load_urdf(urdf)

    def load_urdf(self, urdf: str) -> None:
        """Load the robot's hardware components and activate them.

        Raises:
            TeleopctlError: A plug-in is missing or fails.
        """
        self.description = RobotDescription.from_urdf(urdf)
        self.resources.load_and_initialize_components(self.description)
        for component in self.resources.components.values():
            component.change_state(State.ACTIVE)

    def set_controller_parameters(
        self, name: str, parameters: Mapping[str, AllowableParameterValue]
    ) -> None:
        """Set parameters for a controller that is not yet loaded, by dotted name."""
        self._controller_parameters[name] = dict(parameters)

    def load_controller(
        self,
        name: str,
        type_name: str,
        parameters: Mapping[str, AllowableParameterValue] | None = None,
    ) -> ControllerInterface:
        """Load a controller.

        Args:
            name: The controller's name.
            type_name: ``package/Class`` as files have it, or ``module:Class``.
            parameters: Its parameters, by dotted name.

        Returns:
            The controller.

        Raises:
            AssertionError: It failed; the text is the manager's last error.
        """
        self.node.declare_parameter(f"{name}.type", type_name)
        self.set_controller_parameters(name, parameters or {})
        self._expect(self.manager.load_controller(name))
        return self.manager.controllers[name].controller

    def activate(self, *names: str) -> None:
        """Configure controllers that are unconfigured, and activate all of them.

        Raises:
            AssertionError: It failed; the text says why.
        """
        for name in names:
            if self.manager.controllers[name].lifecycle_state is State.UNCONFIGURED:
                self._expect(self.manager.configure_controller(name))
        self._expect(*switch_controller(self.manager, SwitchRequest(names, [])))

    def deactivate(self, *names: str) -> None:
        """Deactivate controllers.

        Raises:
            AssertionError: It failed; the text says why.
        """
        self._expect(*switch_controller(self.manager, SwitchRequest([], names)))

    def _expect(self, succeeded: bool, message: str = "") -> None:
        if not succeeded:
            raise AssertionError(message or self.log.texts("error")[-1])

    def step(self, count: int = 1, period_ns: int | None = None) -> None:
        """Run control cycles, by default with the period of the update rate."""
        for _ in range(count):
            self.time_ns += period_ns or round(1e9 / self.manager.update_rate)
            self.cycle.run(self.time_ns)

    def step_until(self, seconds: float) -> None:
        """Run control cycles until a time in seconds since the start."""
        while self.time_ns < self.start_ns + round(seconds * 1e9):
            self.step()

    def state(self, name: str) -> float:
        """Return the value of a state interface, such as ``joint1/position``."""
        return self.resources.state_interfaces[name].value

    def command(self, name: str) -> float:
        """Return the value of a command interface; NaN before the first command."""
        return self.resources.command_interfaces[name].value

    def commands(self, interface_name: str = "position") -> list[float]:
        """Return the values of all hardware command interfaces of a kind."""
        return [
            command.value
            for component in self.resources.components.values()
            for command in component.command_interfaces
            if command.interface_name == interface_name
        ]

    # -- what the manager asks of its node ---------------------------------------------------------

    # Any: a parameter has one of nine types, and files decide which.
    def parameter(self, name: str) -> Any:
        """Return a parameter of the manager, or None."""
        return self.node.get_parameter(name).value if self.node.has_parameter(name) else None

    def create_controller_params(self, controller_name: str) -> ControllerInterfaceParams:
        """Make a controller's node and its other arguments."""
        node = RecordedNode(
            controller_name,
            self._controller_parameters.get(controller_name),
            last_only=self._last_only,
        )
        self.nodes[controller_name] = node
        joints = self.description.joints.values()
        return ControllerInterfaceParams(
            controller_name=controller_name,
            node=cast(Node, node),
            update_rate=float(self.manager.update_rate),
            joint_limits=self.resources.limits,
            continuous_joints=frozenset(j.name for j in joints if j.type == "continuous"),
            robot_description=self.description.urdf,
            publish_queue=self.publish_queue,
            now_ns=lambda: self.time_ns,
            action_server=self._make_action_server,
        )

    # Any: the arguments of `ActionServer`.
    def _make_action_server(
        self, node: Node, action_type: type[ActionType[Any, Any, Any]], name: str, **callbacks: Any
    ) -> ActionServer[Any, Any, Any]:
        server = RecordedActionServer(action_type, name, now_ns=lambda: self.time_ns, **callbacks)
        self.action_servers[name.replace("~", node.get_name(), 1)] = server
        return cast("ActionServer[Any, Any, Any]", server)

    def destroy_controller_node(self, node: Node) -> None:
        """Remove a controller's node."""
        del self.nodes[node.get_name()]

    def publish_activity(self) -> None:
        """Do nothing: there are no subscribers."""
