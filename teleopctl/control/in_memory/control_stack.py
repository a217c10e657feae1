"""Control stack without a ROS graph: controllers and cycles in memory, for tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, cast

from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controllers.base import ControllerInterface, ControllerInterfaceParams
from teleopctl.control.cycle import Cycle
from teleopctl.control.in_memory.recorded_node import RecordedActionServer, RecordedNode
from teleopctl.control.lifecycle import State, handle_exception, raise_exception
from teleopctl.control.limits import limits_enforced_by_default
from teleopctl.control.realtime_publisher import PublishQueue
from teleopctl.control.reloading.controller_reload import ControllerReload
from teleopctl.control.resource_manager import ResourceManager
from teleopctl.control.switching import SwitchRequest, switch_controller
from teleopctl.interfaces import ActionType, AllowableParameterValue
from teleopctl.node import ActionServer, LeaseWatch, Node, RcutilsLogger
from teleopctl.robot import RobotDescription, joint_inertias

# Longest wait for the first update of reloaded code in a thread of its own, in seconds.
_LONGEST_UPDATE_S = 10.0


class ControlStack:
    """Controller manager, hardware and control cycle in one thread, without a ROS graph.

    The caller runs the cycles with `step`, in the caller's thread. The description's hardware
    plug-in, such as ``mock_components/GenericSystem``, replaces the robot.

    Args:
        urdf: Robot description whose hardware is loaded and activated; None to load none.
        update_rate: Control cycles per second.
        parameters: Parameters of the controller manager, by dotted name. With
            ``handle_exceptions`` false, exceptions of controllers and hardware are raised.
        enforce_limits: Whether commands are clamped to the limits of their joints; None for the
            default of the ROS 2 distribution, as for the manager's ``enforce_command_limits``.
        last_only: Whether only the last published message of each topic is stored, for long runs.

    Attributes:
        start_ns: Time before the first cycle, in nanoseconds.
        time_ns: Time of the last cycle, in nanoseconds.
        node: Node of the controller manager; ``node.log`` has its log lines.
        nodes: Nodes of the controllers by controller name.
        action_servers: Action servers of the controllers by ``controller/name``.
        resources: Resource manager.
        manager: Controller manager.
        cycle: Control cycle.
        lease: Command lease for controllers that are loaded from then on; None for no lease.

    Example:
        >>> import teleopctl
        >>> from teleopctl.testing import serial_robot
        >>> teleopctl.activate()
        >>> from std_msgs.msg import Float64MultiArray
        >>> stack = ControlStack(serial_robot(joints=2), update_rate=100)
        >>> type_name = "forward_command_controller/ForwardCommandController"
        >>> parameters = {"joints": ["joint1"], "interface_name": "position"}
        >>> forward = stack.load_controller("forward", type_name, parameters)
        >>> stack.activate("forward")
        >>> stack.nodes["forward"].receive("~/commands", Float64MultiArray(data=[0.5]))
        >>> stack.step(2)
        >>> stack.state("joint1/position")
        0.5
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
        self.lease: LeaseWatch | None = None
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
            update_rate=update_rate,
            enforce_limits=limits_enforced_by_default()
            if enforce_limits is None
            else enforce_limits,
            on_exception=raise_exception
            if self.parameter("handle_exceptions") is False
            else handle_exception,
        )
        self.publish_queue = PublishQueue(self.log.warning)
        self.manager = ControllerManager(self.resources, self, logger, update_rate)
        self.cycle = Cycle(self.manager, self.publish_queue)
        if urdf is not None:
            self.load_urdf(urdf)

    def load_urdf(self, urdf: str) -> None:
        """Load the hardware components of a URDF text, and activate them.

        Raises:
            TeleopctlError: A plug-in is missing or fails.
        """
        self.description = RobotDescription.from_urdf(urdf)
        self.resources.load_and_initialize_components(self.description)
        inertias = joint_inertias(self.description)
        self.manager.robot_stop.set_limits(self.resources.limits, inertias=inertias)
        self.resources.start_components({})

    def set_controller_parameters(
        self, name: str, parameters: Mapping[str, AllowableParameterValue]
    ) -> None:
        """Set the parameters, by dotted name, for a controller that is loaded afterwards."""
        self._controller_parameters[name] = dict(parameters)

    def load_controller(
        self,
        name: str,
        type_name: str,
        parameters: Mapping[str, AllowableParameterValue] | None = None,
    ) -> ControllerInterface:
        """Load and return a controller; raise AssertionError on failure.

        Args:
            name: Name of the controller.
            type_name: Type of the controller: ``package/Class`` as in files, or ``module:Class``.
            parameters: Parameters of the controller, by dotted name.

        Returns:
            The controller.

        Raises:
            AssertionError: Loading failed; the text is the manager's last error.
        """
        self.node.declare_parameter(f"{name}.type", type_name)
        self.set_controller_parameters(name, parameters or {})
        self._expect(self.manager.load_controller(name))
        return self.manager.controllers[name].controller

    def activate(self, *names: str) -> None:
        """Configure unconfigured controllers, and activate them; raise AssertionError on failure.

        Raises:
            AssertionError: A controller failed; the text is the reason.
        """
        for name in names:
            if self.manager.controllers[name].lifecycle_state is State.UNCONFIGURED:
                self._expect(self.manager.configure_controller(name))
        self._expect(*switch_controller(self.manager, SwitchRequest(names, [])))

    def deactivate(self, *names: str) -> None:
        """Deactivate controllers; raise AssertionError on failure.

        Raises:
            AssertionError: A controller failed; the text is the reason.
        """
        self._expect(*switch_controller(self.manager, SwitchRequest([], names)))

    def reload_controller(self, name: str) -> str:
        """Reload a controller's changed code, with one cycle if it is active; return what changed.

        Raises:
            ReloadError: The new code failed, and the old code still runs.
        """
        reload = ControllerReload(self.manager, name)
        reload.prepare()
        reload.commit()
        if not reload.is_settled.is_set():
            self.step()
        reload.is_settled.wait(_LONGEST_UPDATE_S)
        return reload.finish()

    def _expect(self, succeeded: bool, message: str = "") -> None:
        if not succeeded:
            raise AssertionError(message or self.log.texts("error")[-1])

    def step(self, count: int = 1, period_ns: int | None = None) -> None:
        """Run a number of control cycles, by default one period of the update rate apart."""
        for _ in range(count):
            self.time_ns += period_ns or round(1e9 / self.manager.update_rate)
            self.cycle.run(self.time_ns)

    def step_until(self, seconds: float) -> None:
        """Run control cycles until a time in seconds after `start_ns`."""
        while self.time_ns < self.start_ns + round(seconds * 1e9):
            self.step()

    def state(self, name: str) -> float:
        """Return the value of a state interface, such as ``joint1/position``."""
        return self.resources.state_interfaces[name].value

    def command(self, name: str) -> float:
        """Return the value of a command interface; NaN before the first command."""
        return self.resources.command_interfaces[name].value

    def commands(self, interface_name: str = "position") -> list[float]:
        """Return the values of all hardware command interfaces of a kind, such as ``position``."""
        return [
            command.value
            for component in self.resources.components.values()
            for command in component.command_interfaces
            if command.interface_name == interface_name
        ]

    # -- methods of `ManagerNode` ------------------------------------------------------------------

    def parameter(self, name: str) -> AllowableParameterValue:
        """Return the value of a parameter of the manager's node; None if undeclared."""
        if not self.node.has_parameter(name):
            return None
        value: AllowableParameterValue = self.node.get_parameter(name).value
        return value

    def create_controller_params(self, controller_name: str) -> ControllerInterfaceParams:
        """Create a controller's node; return `ControllerInterfaceParams` with that node."""
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
            robot_stop=self.manager.robot_stop,
            lease=self.lease,
        )

    # Any: arguments of `ActionServer`.
    def _make_action_server(
        self, node: Node, action_type: type[ActionType[Any, Any, Any]], name: str, **callbacks: Any
    ) -> ActionServer[Any, Any, Any]:
        server = RecordedActionServer(action_type, name, now_ns=lambda: self.time_ns, **callbacks)
        self.action_servers[name.replace("~", node.get_name(), 1)] = server
        return cast("ActionServer[Any, Any, Any]", server)

    def destroy_controller_node(self, node: Node) -> None:
        """Remove the node of an unloaded controller from `nodes`."""
        del self.nodes[node.get_name()]

    def publish_activity(self) -> None:
        """Do nothing: in memory there are no subscribers."""
