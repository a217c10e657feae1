"""Base class of controllers, and its constructor argument."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType, State
from teleopctl.errors import InvalidParameterError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from teleopctl.control.realtime_publisher import PublishQueue
    from teleopctl.interfaces import ActionType, FeedbackT, GoalT, ResultT
    from teleopctl.node import (
        AcceptedCallback,
        ActionServer,
        AllowableParameterValue,
        CancelCallback,
        GoalCallback,
        Node,
    )
    from teleopctl.robot import JointLimits

# Parameters that the manager reads, or every node has.
_OF_ANY_CONTROLLER = re.compile(
    r"(type|update_rate|is_async|async_parameters|thread_priority|params_file|fallback_controllers"
    r"|node_options_args|use_sim_time|use_global_arguments|robot_description|qos_overrides"
    r"|start_type_description_service|lock_memory|cpu_affinity)(\.|$)"
)

T = TypeVar("T", bound="AllowableParameterValue")


# Any, here and below: goals, results and feedback of whatever action it is.
def _make_action_server(*args: Any, **options: Any) -> ActionServer[Any, Any, Any]:
    """An action server; the import costs what most controllers do without."""
    from teleopctl.node import ActionServer

    return ActionServer(*args, **options)


@dataclass(frozen=True)
class ControllerInterfaceParams:
    """Constructor argument of controllers (node, limits, URDF), made by the controller manager.

    Attributes:
        controller_name: The controller's name, which is its node's too.
        node: The controller's own node; its parameters are the controller's.
        update_rate: The manager's rate, Hz.
        joint_limits: Limits of the robot's joints, by name.
        continuous_joints: Joints that turn without end.
        robot_description: The URDF.
        publish_queue: For the controller's realtime publishers.
        now_ns: Present time on the clock that ``update`` is given, nanoseconds.
        action_server: Makes the controller's action servers, with the arguments of `ActionServer`.
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
        type: ALL means those that are available when the controller is activated.
        names: Full names, for INDIVIDUAL; all of them must be available at activation.

    Example:
        >>> one = InterfaceConfigurationType.INDIVIDUAL
        >>> InterfaceConfiguration(one, ["joint_1/position"]).names
        ['joint_1/position']
    """

    type: InterfaceConfigurationType = InterfaceConfigurationType.NONE
    names: Sequence[str] = ()


class ControllerInterface:
    """Base class of controllers, with the methods of ros2_control's ControllerInterface.

    A lifecycle callback that returns None has succeeded, one that raises has failed. ``update``
    runs in the control cycle: no input or output, no waiting. Publish with a
    ``RealtimePublisher``.

    Args:
        params: Name, node, description and other arguments from the controller manager.

    Attributes:
        params: The arguments from the controller manager.
        name: Name of the controller and of its node.
        logger: Logger of the controller's node.
        state_interfaces: Claimed state interfaces, in the order of
            ``state_interface_configuration``, while active.
        command_interfaces: Claimed command interfaces, in the order of
            ``command_interface_configuration``, while active.
        lifecycle_state: Lifecycle state of the controller.
        update_rate: Rate of ``update`` in Hz; never above the manager's.

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

    def get_node(self) -> Node:
        """Return the controller's node."""
        return self.params.node

    @property
    def nominal_period(self) -> float:
        """Nominal time between two updates, in seconds."""
        return 1.0 / self.update_rate

    def auto_declare(self, name: str, default: T, *, read_only: bool = False) -> T:
        """Declare a parameter of the controller if undeclared; return the parameter's value.

        Args:
            name: Dotted name.
            default: Value (and so the type) where neither file nor command line sets it.
            read_only: Whether it can only be set at the start.

        Raises:
            InvalidParameterError: Its value is of another type than the default.
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

    def unread_parameters(self) -> list[str]:
        """Return the names of parameters that are set but that the controller never declared.

        Called after ``on_configure``; empty for controllers of others, which may read the node's
        parameters themselves.
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

        The callbacks run beside the control loop, as those of subscriptions do. A goal is followed
        by ``update``, and what ``update`` finds out leaves through a ``RealtimePublisher``.

        Args:
            action_type: Action class.
            name: Its name, ``~/follow_joint_trajectory`` say.
            goal_callback: Accepts or rejects a goal.
            handle_accepted_callback: Takes the handle of an accepted goal, and calls its
                ``executing`` when the work begins.
            cancel_callback: Accepts or refuses to cancel; a goal that is to be cancelled says so
                by ``is_cancel_requested``, for ``update`` to see.
        """
        return self.params.action_server(
            self.get_node(),
            action_type,
            name,
            goal_callback=goal_callback,
            handle_accepted_callback=handle_accepted_callback,
            cancel_callback=cancel_callback,
        )

    def on_init(self) -> CallbackReturn | None:
        """Called after construction: declare parameters; the base class does nothing."""

    def on_configure(self) -> CallbackReturn | None:
        """Called on configuring: read parameters, create topics; the base class does nothing."""

    def on_activate(self) -> CallbackReturn | None:
        """Called on activation, with interfaces assigned: prepare; the base class does nothing."""

    def on_deactivate(self) -> CallbackReturn | None:
        """Called on deactivation, before interfaces are released: stop; does nothing by default."""

    def on_restart(self) -> None:
        """Called in the cycle after a simulation reset: reset plans; the base class does nothing.

        A simulation was reset, or its clock went back. Called in the control cycle, with the states
        as they are now and commands that are NaN, which hardware takes as "stay where you are".
        """

    def on_cleanup(self) -> CallbackReturn | None:
        """Called on cleanup: release what ``on_configure`` created; the base class does nothing."""

    def on_shutdown(self) -> CallbackReturn | None:
        """Called before the controller is unloaded: release all; the base class does nothing."""

    def on_error(self) -> CallbackReturn | None:
        """Called after ERROR or exceptions; SUCCESS leads to unconfigured, else to finalized."""

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Called after ``on_configure``: return the command interfaces to claim; here none."""
        return InterfaceConfiguration()

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Called after ``on_configure``: return the state interfaces to read; here none."""
        return InterfaceConfiguration()

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Called in each cycle: read ``state_interfaces`` and write ``command_interfaces``.

        Args:
            time_ns: Time of this cycle, nanoseconds.
            period: Seconds since this controller's last update; the nominal period at first.
        """
        raise NotImplementedError


def _of_type(name: str, value: object, default: object) -> object:
    """A parameter's value, if it is of its default's type; integers serve as floats."""
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
