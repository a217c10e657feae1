"""Base class of controllers, and its constructor argument."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType, State
from teleopctl.control.robot_stop import RobotStop
from teleopctl.errors import InvalidParameterError
from teleopctl.node import InvalidGoalTransitionError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from teleopctl.control.realtime_publisher import PublishQueue
    from teleopctl.interfaces import ActionType, AllowableParameterValue, FeedbackT, GoalT, ResultT
    from teleopctl.node import (
        AcceptedCallback,
        ActionServer,
        CancelCallback,
        GoalCallback,
        LeaseWatch,
        Node,
    )
    from teleopctl.robot import JointLimits

# Parameters that the manager reads or that every node has.
_OF_ANY_CONTROLLER = re.compile(
    r"(type|update_rate|is_async|async_parameters|thread_priority|params_file|fallback_controllers"
    r"|node_options_args|use_sim_time|use_global_arguments|robot_description|qos_overrides"
    r"|start_type_description_service|lock_memory|cpu_affinity)(\.|$)"
)

T = TypeVar("T", bound="AllowableParameterValue")


# Any, here and below: goals, results and feedback of any action.
def _make_action_server(*args: Any, **options: Any) -> ActionServer[Any, Any, Any]:
    """Return an action server; imports its module only here, since most controllers have none."""
    from teleopctl.node import ActionServer

    return ActionServer(*args, **options)


@dataclass(frozen=True)
class ControllerInterfaceParams:
    """Constructor argument of controllers (node, limits, URDF), made by the controller manager.

    Attributes:
        controller_name: Name of the controller and of its node.
        node: Node of the controller, with the controller's parameters.
        update_rate: Update rate of the manager, Hz.
        joint_limits: Limits of the robot's joints, by joint name.
        continuous_joints: Names of the continuous joints.
        robot_description: URDF of the robot.
        publish_queue: Queue for the controller's realtime publishers.
        now_ns: Function that returns the present time in nanoseconds, on the clock of ``update``.
        action_server: Function that creates the controller's action servers, with the arguments
            of `ActionServer`.
        robot_stop: State of the robot's stop.
        lease: Command lease of the robot; None if any node may command.
    """

    controller_name: str
    node: Node
    update_rate: float
    joint_limits: dict[str, JointLimits]
    continuous_joints: frozenset[str]
    robot_description: str
    publish_queue: PublishQueue
    now_ns: Callable[[], int]
    action_server: Callable[..., ActionServer[Any, Any, Any]] = _make_action_server
    robot_stop: RobotStop = field(default_factory=RobotStop)
    lease: LeaseWatch | None = None


class InterfaceConfigurationType(Enum):
    """Choice of the interfaces that a controller claims: all, some by name, or none.

    Example:
        >>> InterfaceConfiguration(InterfaceConfigurationType.ALL)
        InterfaceConfiguration(type=<InterfaceConfigurationType.ALL: 'all'>, names=())
    """

    ALL = "all"
    INDIVIDUAL = "individual"
    NONE = "none"


@dataclass(frozen=True)
class InterfaceConfiguration:
    """Selection of the command or state interfaces that a controller claims.

    Attributes:
        type: Kind of the selection. ALL selects the interfaces available at activation.
        names: Full names for INDIVIDUAL; all of them must be available at activation.

    Example:
        >>> one = InterfaceConfigurationType.INDIVIDUAL
        >>> InterfaceConfiguration(one, ["joint_1/position"]).names
        ['joint_1/position']
    """

    type: InterfaceConfigurationType = InterfaceConfigurationType.NONE
    names: Sequence[str] = ()


class ControllerInterface:
    """Base class of controllers, with the methods of ros2_control's ControllerInterface.

    A lifecycle callback that returns None has succeeded, a callback that raises has failed.
    ``update`` runs in the control cycle, where input, output and waiting are not allowed: publish
    with a ``RealtimePublisher``.

    Args:
        params: Name, node, description and other arguments from the controller manager.

    Attributes:
        params: Arguments from the controller manager.
        name: Name of the controller and of its node.
        logger: Logger of the controller's node.
        state_interfaces: Claimed state interfaces, in the order of
            ``state_interface_configuration``, while active.
        command_interfaces: Claimed command interfaces, in the order of
            ``command_interface_configuration``, while active.
        lifecycle_state: Lifecycle state of the controller.
        update_rate: Rate of ``update`` in Hz; never above the manager's.
        introspected: Functions of the values that `register_introspection` has registered.

    Example:
        >>> class Hold(ControllerInterface):
        ...     def command_interface_configuration(self):
        ...         one = InterfaceConfigurationType.INDIVIDUAL
        ...         return InterfaceConfiguration(one, ["joint1/position"])
        ...
        ...     def update(self, time_ns, period):
        ...         self.command_interfaces[0].value = 0.3
    """

    base_class: ClassVar[str] = "controller_interface::ControllerInterface"

    def __init__(self, params: ControllerInterfaceParams) -> None:
        self.params = params
        self.name = params.controller_name
        self.logger = params.node.get_logger()
        self.state_interfaces: list[StateInterface] = []
        self.command_interfaces: list[CommandInterface] = []
        self.lifecycle_state = State.UNCONFIGURED
        self.update_rate = params.update_rate
        self._known_parameters: set[str] = set()
        self._action_servers: list[ActionServer[Any, Any, Any]] = []
        self._reported_refusals: set[tuple[int, str]] = set()
        self._reported_leases: set[tuple[int, str]] = set()
        self.introspected: Mapping[str, Callable[[], float]] = {}

    def get_node(self) -> Node:
        """Return the controller's node."""
        return self.params.node

    @property
    def nominal_period(self) -> float:
        """Nominal time between two updates, in seconds."""
        return 1.0 / self.update_rate

    def auto_declare(self, name: str, default: T, *, read_only: bool = False) -> T:
        """Declare a controller's parameter if undeclared; return its value, raise for a wrong type.

        Args:
            name: Dotted name of the parameter.
            default: Default value, which also defines the type.
            read_only: Whether the parameter can only be set at startup.

        Raises:
            InvalidParameterError: The value is of another type than the default.
        """
        node = self.get_node()
        self._known_parameters.add(name)
        if not node.has_parameter(name):
            from teleopctl.interfaces import get_message

            descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
            node.declare_parameter(
                name, default, descriptor(name=name, read_only=read_only, dynamic_typing=True)
            )
        value: object = node.get_parameter(name).value
        return default if value is None else cast(T, _of_type(name, value, default))

    @property
    def known_parameters(self) -> frozenset[str]:
        """Names of the parameters that `auto_declare` has declared so far."""
        return frozenset(self._known_parameters)

    def register_introspection(self, name: str, value: Callable[[], float]) -> None:
        """Publish a value on the manager's ``~/introspection_data`` topics while active.

        The counterpart of ros2_control's ``REGISTER_ROS2_CONTROL_INTROSPECTION``.

        Args:
            name: Name of the value, published as ``controller.name``.
            value: Function called in each control cycle while the topics have subscribers.
        """
        self.introspected = {**self.introspected, name: value}

    def unread_parameters(self) -> list[str]:
        """Return the set parameters that a built-in controller never declared; empty for others.

        Called after ``on_configure``. Empty for controllers from other packages, which may read the
        node's parameters directly.
        """
        if not type(self).__module__.startswith(f"{__package__}."):
            return []
        given = self.get_node().get_parameter_overrides()
        return sorted(
            name
            for name in given
            if name not in self._known_parameters and not _OF_ANY_CONTROLLER.match(name)
        )

    def create_action_server(
        self,
        action_type: type[ActionType[GoalT, ResultT, FeedbackT]],
        name: str,
        *,
        goal_callback: GoalCallback[GoalT],
        handle_accepted_callback: AcceptedCallback[GoalT, ResultT, FeedbackT],
        cancel_callback: CancelCallback[GoalT, ResultT, FeedbackT],
    ) -> ActionServer[GoalT, ResultT, FeedbackT]:
        """Create and return an action server, which ``on_cleanup`` has to destroy.

        The callbacks run outside the control loop, like those of subscriptions. ``update`` executes
        the goal, and publishes its results through a ``RealtimePublisher``.

        Args:
            action_type: Action class.
            name: Name of the action, for example ``~/follow_joint_trajectory``.
            goal_callback: Function called with a goal request; accepts or rejects the goal.
            handle_accepted_callback: Function called with the handle of an accepted goal; calls the
                handle's ``executing`` when the execution begins.
            cancel_callback: Function called for a cancel request; accepts or rejects it. ``update``
                reads ``is_cancel_requested`` of the goal.
        """
        server = self.params.action_server(
            self.get_node(),
            action_type,
            name,
            goal_callback=goal_callback,
            handle_accepted_callback=handle_accepted_callback,
            cancel_callback=cancel_callback,
        )
        self._action_servers.append(server)
        return server

    def on_init(self) -> CallbackReturn | None:
        """Called after construction: declare parameters; the base class does nothing."""

    def on_configure(self) -> CallbackReturn | None:
        """Called on configuring: read parameters, create topics; the base class does nothing."""

    def on_activate(self) -> CallbackReturn | None:
        """Called on activation, with interfaces assigned: prepare; the base class does nothing."""

    def on_deactivate(self) -> CallbackReturn | None:
        """Called on deactivation, before interfaces are released: stop; does nothing by default."""

    def on_restart(self) -> None:
        """Called in the cycle in which the joints have jumped, or after a long time without cycles.

        The base class does nothing; controllers with plans drop them and hold the joints where they
        are. Called in the control cycle, with the present states. After a reset of a simulation
        or a jump back of its clock, commands are NaN, for which hardware holds its position.
        """

    def abort_goals(self, reason: str) -> None:
        """Called while no control cycle runs, as its hardware hangs or is gone: abort all goals.

        Not called in the control cycle; when it runs again, `on_restart` is called. The base class
        aborts the goals of the servers that `create_action_server` has created.

        Args:
            reason: Why no cycle runs, for results that have a text.
        """
        del reason
        for server in self._action_servers:
            for goal in server.active_goals():
                # It may end at this instant.
                with contextlib.suppress(InvalidGoalTransitionError):
                    goal.abort()

    def on_stop(self) -> None:
        """Called in the cycle in which the robot is stopped: end goals, discard received commands.

        Also called when the controller is activated while the robot is stopped. ``update`` is still
        called, but the commands it writes to `interfaces_to_decelerate` are replaced: they
        decelerate within the joints' limits and stay. The base class does nothing.
        """

    def on_release(self) -> None:
        """Called in the cycle in which the robot is released: plan from the present commands.

        The base class calls ``on_deactivate`` and ``on_activate``.
        """
        self.on_deactivate()
        self.on_activate()

    @property
    def seconds_since_step(self) -> float:
        """Seconds since a position command that joints cannot follow at once; NaN for none.

        When the robot is stopped, joints that follow such a step decelerate from where they are.
        NaN in the base class: joints near their commands follow them, and decelerate from there.
        """
        return math.nan

    def interfaces_to_decelerate(self) -> Sequence[CommandInterface]:
        """Return the interfaces whose commands are replaced while the robot is stopped; all here.

        Called after ``on_stop``. A controller that decelerates the joints itself returns none.
        """
        return self.command_interfaces

    def is_refused(self, what: str, sender: bytes = b"") -> bool:
        """Return whether commands are refused; then log so, once per stop and kind of command.

        They are while the robot is stopped, while no control cycle runs, and if another node holds
        the command lease.

        For callbacks that receive commands or goals; not for the control cycle.

        Args:
            what: What is refused, as the beginning of a sentence, such as "The trajectory".
            sender: GID of the publisher or client; empty if it does not matter.
        """
        stop = self.params.robot_stop
        reason = stop.reason
        if not reason:
            return bool(self.lease_refusal(what, sender))
        if (stop.count, what) not in self._reported_refusals:
            self._reported_refusals = {(stop.count, what)} | {
                entry for entry in self._reported_refusals if entry[0] == stop.count
            }
            release = "" if stop.standstill else " 'teleopctl stop --robot --release' releases it."
            self.logger.warning(f"{what} is refused: {reason[0].lower()}{reason[1:]}.{release}")
        return True

    def lease_refusal(self, what: str, sender: bytes) -> str:
        """Return why a sender may not command, empty if it may; log it once per lease and sender.

        Args:
            what: What is refused, as the beginning of a sentence.
            sender: GID of the publisher or client.
        """
        lease = self.params.lease
        reason = "" if lease is None else lease.refusal(sender)
        if reason and lease is not None:
            entry = (lease.term, f"{what} {sender.hex()}")
            if entry not in self._reported_leases:
                self._reported_leases = {entry} | {
                    known for known in self._reported_leases if known[0] == lease.term
                }
                self.logger.warning(f"{what} is refused: {reason}")
        return reason

    def on_cleanup(self) -> CallbackReturn | None:
        """Called on cleanup: release what ``on_configure`` created; the base class does nothing."""

    def on_shutdown(self) -> CallbackReturn | None:
        """Called before the controller is unloaded: release all; the base class does nothing."""

    def on_error(self) -> CallbackReturn | None:
        """Called after ERROR or exceptions; SUCCESS leads to unconfigured, else to finalized."""

    def export_state(self) -> object:
        """Called when new code replaces this active controller: return its state; None by default.

        The state goes to the new instance's `import_state`: for example the goal, the reference,
        the time on a trajectory, an integral. Called between two cycles; the old instance continues
        if the new one fails, so its state must not be changed by the new one before
        its first update. Claimed interfaces and parameters are handed over in any case.
        """
        return None

    def import_state(self, state: Any) -> None:
        """Called after ``on_activate`` of new code with the old `export_state`, unless None.

        Without a state, or if this method is not overridden, the new instance gets the values of
        the attributes that ``on_activate`` sets, if they are numbers, texts, or lists of these, and
        active goals of action servers as if they had just been accepted.

        Args:
            state: State of the replaced instance, which may have been of older code.
        """

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Called after ``on_configure``: return command interfaces to claim; none by default."""
        return InterfaceConfiguration()

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Called after ``on_configure``: return state interfaces to read; none by default."""
        return InterfaceConfiguration()

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Called at the update rate: read ``state_interfaces``, write ``command_interfaces``.

        Args:
            time_ns: Time of the control cycle, in nanoseconds.
            period: Seconds since this controller's last update; the nominal period at first.
        """
        raise NotImplementedError


def _of_type(name: str, value: object, default: object) -> object:
    """Return a parameter's value, checked for its default's type; integers become floats."""
    if isinstance(default, (list, tuple)):
        if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
            return list(value)
        expected = "a list"
    elif isinstance(default, float):
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return float(value)
        expected = "a number"
    elif isinstance(default, bool):
        if isinstance(value, bool):
            return value
        expected = "true or false"
    elif isinstance(default, int):
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        expected = "an integer"
    elif isinstance(default, str) and not isinstance(value, str):
        expected = "a string"
    else:
        return value
    raise InvalidParameterError(f"Parameter '{name}' must be {expected}, got {value!r}")
