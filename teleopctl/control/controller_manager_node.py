"""Node of the controller manager: robot description, control cycle, services, topics."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable, Container, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from teleopctl.base import progress
from teleopctl.control.client import managers_of_same_robot
from teleopctl.control.controller_files import MANAGER_PARAMETERS
from teleopctl.control.controller_manager import ControllerManager, string_list_parameter
from teleopctl.control.controllers.base import ControllerInterfaceParams
from teleopctl.control.cycle import Cycle, WallClockLoop
from teleopctl.control.cycle_watchdog import DEFAULT_LIMIT_S, CycleWatchdog
from teleopctl.control.lifecycle import OnException, State, handle_exception
from teleopctl.control.limits import limits_enforced_by_default
from teleopctl.control.manager_log import DESCRIPTION_RECEIVED, DESCRIPTION_REFUSED
from teleopctl.control.realtime_publisher import PublishQueue
from teleopctl.control.resource_manager import ResourceManager
from teleopctl.control.robot_stop_node import RobotStopNode
from teleopctl.control.services import ControllerManagerServices, lifecycle_state_message
from teleopctl.control.statistics_publishers import (
    EXECUTION_TIMES_CHECK_S,
    INTROSPECTION_CHECK_S,
    DiagnosticsPublisher,
    ExecutionTimesService,
    IntrospectionPublisher,
    StatisticsPublisher,
)
from teleopctl.errors import DefectError, HardwareError, InvalidParameterError, TeleopctlError
from teleopctl.interfaces import AllowableParameterValue, get_message, is_distribution_since
from teleopctl.node import (
    Clock,
    ClockType,
    Executor,
    LeaseWatch,
    Node,
    RcutilsLogger,
    find_parameter_line,
    parse_ros_arguments,
    qos_profile_latched,
)
from teleopctl.robot import RobotDescription, joint_inertias, update_rate_problem

DEFAULT_UPDATE_RATE = 100
# Prefixes of parameters of the manager; below other prefixes are parameters of controllers.
_OF_MANAGER = frozenset(
    ("defaults", "hardware_components_initial_state", "hardware_synchronization", "overruns")
)
# Parameters that are read when they are needed, or that every node has.
_READ_LATER = frozenset(
    (
        "defaults.allow_controller_activation_with_inactive_hardware",
        "defaults.deactivate_controllers_on_hardware_self_deactivate",
        "defaults.switch_controller.strictness",
        "cycle_timeout",
        "use_sim_time",
        "start_type_description_service",
    )
)
_ENDS_ON_FAILURE = "hardware_components_initial_state.shutdown_on_initial_state_failure"
# Longest wait for the first states of hardware in lockstep, in seconds of wall time.
_LONGEST_START_S = 1.0
# Part of a period by which the states' period may differ without a warning.
_RATE_TOLERANCE = 0.01


class ControllerManagerNode:
    """Controller manager as a ROS node: waits for the robot description, runs the cycle.

    Args:
        node: Node of the manager.
        executor: Executor that the nodes of controllers are added to.
        ros_arguments: ROS arguments of the process; they apply to controllers' nodes, too.
        on_failure: Called, from any thread, with the error that is to end the process: a control
            cycle does not end within the parameter ``cycle_timeout``, 10 s by default, or, with
            ``handle_exceptions`` false, a controller or hardware raises. None for a process of the
            manager's own, which ends by ``node.fail`` and by default has no limit for a cycle.
        simulation_started: Set once a simulator in this process sends states, which may take
            minutes for a model with large meshes; None for hardware elsewhere.
    """

    def __init__(
        self,
        node: Node,
        executor: Executor,
        ros_arguments: Sequence[str],
        *,
        on_failure: Callable[[TeleopctlError], object] | None = None,
        simulation_started: threading.Event | None = None,
    ) -> None:
        self._node = node
        self._fail = on_failure or node.fail
        self._simulation_started = simulation_started
        self._executor = executor
        self._ros_arguments = without_node_name(ros_arguments)
        self._logger = node.get_logger()
        self._read: set[str] = set()
        rate = self._update_rate()
        enforce = self.parameter("enforce_command_limits")
        if enforce is None:
            enforce = limits_enforced_by_default()
        elif not isinstance(enforce, bool):
            raise InvalidParameterError(
                f"Parameter 'enforce_command_limits' must be true or false, got {enforce}"
            )
        self._resource_manager = ResourceManager(
            node,
            node.get_logger().get_child("resource_manager"),
            lambda sentence: self._cycle.report(sentence),
            update_rate=rate,
            enforce_limits=enforce,
            on_exception=self._on_exception(),
        )
        self._publish_queue = PublishQueue(lambda sentence: self._cycle.report(sentence))
        self.manager = ControllerManager(self._resource_manager, self, self._logger, rate)
        self._cycle = Cycle(self.manager, self._publish_queue)
        self._watchdog = CycleWatchdog(
            self._cycle,
            self._logger,
            limit_s=self._cycle_timeout_s(0.0 if on_failure is None else DEFAULT_LIMIT_S),
            on_limit=self._fail,
            aborts_goals=on_failure is None,
        )
        self._lease = LeaseWatch(node)
        self._stop = RobotStopNode(
            node,
            self.manager.robot_stop,
            self.parameter,
            self.manager.cycle_lock,
            on_stop=self._lease.end,
        )
        self._loop: WallClockLoop | None = None
        self._lockstep = False
        self._last_state_ns: int | None = None
        self._rate_compared = False
        self._services: ControllerManagerServices | None = None
        self._closing_lock = threading.Lock()
        self._is_closed = False
        self._description: RobotDescription | None = None
        self._activity = node.create_publisher(
            get_message("controller_manager_msgs/msg/ControllerManagerActivity"),
            "~/activity",
            qos_profile_latched,
        )
        self._logger.info(f"update rate is {rate} Hz")
        self._subscription = node.create_subscription(
            get_message("std_msgs/msg/String"),
            "robot_description",
            self._description_received,
            qos_profile_latched,
        )
        self._reminder = node.create_timer(1.0, self._log_waiting, clock=Clock())
        progress.report(progress.WAITING, self._subscription.topic_name, part=progress.CONTROL)

    def _update_rate(self) -> int:
        rate = self.parameter("update_rate")
        if rate is None:
            return DEFAULT_UPDATE_RATE
        if problem := update_rate_problem(rate):
            error = InvalidParameterError(f"Parameter 'update_rate' {problem}")
            given = parse_ros_arguments(self._ros_arguments).parameters
            files = [file for file in given if isinstance(file, Path)]
            place = find_parameter_line(files, self._node.get_fully_qualified_name(), "update_rate")
            raise error.at(place) if place else error
        assert isinstance(rate, int)
        return rate

    def _on_exception(self) -> OnException:
        handles = self.parameter("handle_exceptions")
        if handles is None or handles is True:
            return handle_exception
        if handles is False:
            return partial(end_with_exception, self._logger, self._fail)
        raise InvalidParameterError(
            f"Parameter 'handle_exceptions' must be true or false, got {handles}"
        )

    def _cycle_timeout_s(self, default_s: float) -> float:
        limit_s = self.parameter("cycle_timeout")
        if limit_s is None:
            return default_s
        if isinstance(limit_s, bool) or not isinstance(limit_s, int | float) or limit_s < 0:
            raise InvalidParameterError(
                f"Parameter 'cycle_timeout' must be a number of seconds, 0 for no limit, "
                f"got {limit_s}"
            )
        return float(limit_s)

    def _log_waiting(self) -> None:
        self._logger.warning(
            "Waiting for data on 'robot_description' topic to finish initialization"
        )

    # ---- implementation of ManagerNode

    def parameter(self, name: str) -> AllowableParameterValue:
        """Return the value of a parameter of the manager's node; None if undeclared."""
        self._read.add(name)
        if not self._node.has_parameter(name):
            return None
        value: AllowableParameterValue = self._node.get_parameter(name).value
        return value

    def create_controller_params(self, controller_name: str) -> ControllerInterfaceParams:
        """Create a controller's node; return `ControllerInterfaceParams` with that node."""
        arguments = list(self._ros_arguments)
        for file in dict.fromkeys(string_list_parameter(self, f"{controller_name}.params_file")):
            arguments += ["--ros-args", "--params-file", file, "--"]
        options = string_list_parameter(self, f"{controller_name}.node_options_args")
        if options:
            arguments += ["--ros-args", *options, "--"]
        node = Node(
            controller_name,
            namespace=self._node.get_namespace(),
            cli_args=arguments,
            use_global_arguments=False,
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        self._declare_manager_parameters(node)
        self._executor.add_node(node)
        assert self._description is not None
        return ControllerInterfaceParams(
            controller_name=controller_name,
            node=node,
            update_rate=float(self.manager.update_rate),
            joint_limits=self._resource_manager.limits,
            continuous_joints=frozenset(
                joint.name
                for joint in self._description.joints.values()
                if joint.type == "continuous"
            ),
            robot_description=self._description.urdf,
            publish_queue=self._publish_queue,
            now_ns=self._now_ns,
            robot_stop=self.manager.robot_stop,
            lease=self._lease,
        )

    def _declare_manager_parameters(self, node: Node) -> None:
        """Declare a controller's parameters that files set in the manager's section; log a warning.

        The controller's own section has precedence. ROS 2 reads only that section.
        """
        name = node.get_name()
        below = self._node.get_parameters_by_prefix(name)
        handed = [
            key
            for key in below
            if key not in MANAGER_PARAMETERS
            and not key.startswith(f"{name}.")
            and not node.has_parameter(key)
        ]
        for key in handed:
            node.declare_parameter(key, below[key].value)
        if handed:
            self._logger.warning(
                f"Controller '{name}' takes {', '.join(handed)} from the controller manager's "
                f"parameters: ROS 2 reads them in a section '{name}' only"
            )

    def _now_ns(self) -> int:
        return self._cycle.time_ns if self._lockstep else time.time_ns()

    def destroy_controller_node(self, node: Node) -> None:
        """Destroy the node of an unloaded controller."""
        node.destroy_node()

    def publish_activity(self) -> None:
        """Publish the states of all controllers and hardware components on ``~/activity``."""
        named: Any = get_message("controller_manager_msgs/msg/NamedLifecycleState")
        message = get_message("controller_manager_msgs/msg/ControllerManagerActivity")(
            controllers=[
                named(name=spec.name, state=lifecycle_state_message(spec.lifecycle_state))
                for spec in list(self.manager.controllers.values())
            ],
            hardware_components=[
                named(name=component.name, state=lifecycle_state_message(component.lifecycle_state))
                for component in self._resource_manager.components.values()
            ],
        )
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._activity.publish(message)

    # ---- start and end

    def _description_received(self, message: Any) -> None:
        if self._resource_manager.components_initialized:
            self._logger.warning(
                "ResourceManager has already loaded a urdf and is initialized. Ignoring attempt "
                "to reload a robot description."
            )
            return
        self._logger.info(DESCRIPTION_RECEIVED)
        progress.report(progress.STARTING, part=progress.CONTROL)
        self._reminder.cancel()
        try:
            description = RobotDescription.from_urdf(message.data)
            progress.doing("initializing the hardware", part=progress.CONTROL)
            self._resource_manager.load_and_initialize_components(description)
        except TeleopctlError as error:
            self._logger.error(
                f"{DESCRIPTION_REFUSED} {error.message}"
                + (f" ({error.hint})" if error.hint else "")
            )
            self._logger.info(f"Another description on {self._subscription.topic_name} is taken")
            progress.report(
                progress.FAILED,
                f"the robot description is refused: {error.message}",
                part=progress.CONTROL,
            )
            return
        own = self._node.get_fully_qualified_name()
        for other, topic in managers_of_same_robot(self._node.graph().endpoints, own).items():
            self._logger.warning(
                f"{other} takes the robot description on {topic}, too: two controller managers "
                "command the same joints. 'teleopctl ps' lists what runs"
            )
        self._description = description
        self._stop.set_limits(self._resource_manager.limits, joint_inertias(description))
        self._node.destroy_timer(self._reminder)
        self._find_lockstep_hardware()
        self._resource_manager.set_lockstep(self._lockstep)
        progress.doing("activating the hardware", part=progress.CONTROL)
        self._start_hardware()
        self._logger.info(
            "Resource Manager has been successfully initialized. Starting Controller Manager "
            "services..."
        )
        self._services = ControllerManagerServices(self._node, self.manager)
        self._start_cycling()
        self.publish_activity()
        if unread := unread_manager_parameters(self._node.get_parameter_overrides(), self._read):
            self._logger.warning(f"Parameters that have no effect: {', '.join(unread)}")
        if self._lockstep:
            # The simulator's present step is to be shown.
            progress.doing("", part=progress.CONTROL)
            threading.Thread(target=self._offer_switching_later, daemon=True).start()
        else:
            self._offer_switching()
        StatisticsPublisher(self._node, self.manager, self._cycle)
        execution_times = ExecutionTimesService(self._node, self.manager, self._cycle)
        introspection = IntrospectionPublisher(
            self._node, self.manager, self._cycle, self._publish_queue
        )
        for interval_s, check in (
            (INTROSPECTION_CHECK_S, introspection.follow_subscriptions),
            (EXECUTION_TIMES_CHECK_S, execution_times.end_unused_counting),
        ):
            self._node.create_timer(
                interval_s, check, clock=Clock(clock_type=ClockType.STEADY_TIME)
            )
        DiagnosticsPublisher(self._node, self.manager, self._cycle, self.parameter)

    def _offer_switching_later(self) -> None:
        """Offer the switch of controllers once the hardware in lockstep has its first states.

        Controllers read the measured positions when they are activated, and clients wait for a
        service without a limit, but for its answer some seconds only. A simulation that is paused
        may have no states yet, so that the wait for them is limited.
        """
        if self._simulation_started is not None:
            self._simulation_started.wait()
        self.manager.first_cycle.wait(_LONGEST_START_S)
        with self._closing_lock:
            if not self._is_closed:
                self._offer_switching()

    def _offer_switching(self) -> None:
        assert self._services is not None
        self._services.offer_switching()
        progress.report(progress.READY, part=progress.CONTROL)

    def _start_hardware(self) -> None:
        initial = {
            name: state
            for state, key in ((State.UNCONFIGURED, "unconfigured"), (State.INACTIVE, "inactive"))
            for name in string_list_parameter(self, f"hardware_components_initial_state.{key}")
        }
        failed = self._resource_manager.start_components(initial)
        ends = self.parameter(_ENDS_ON_FAILURE)
        if ends is None:
            ends = not is_distribution_since("kilted")
        if failed and ends:
            name, state = failed[0]
            raise HardwareError(
                f"Failed to set the initial state of the component : '{name}' to '{state.label}'",
                hint=f"The log has the cause. With {_ENDS_ON_FAILURE}: false, the default from "
                "Kilted on, the controller manager goes on without the component.",
            )

    def _find_lockstep_hardware(self) -> None:
        """Set the cycle function of hardware in lockstep, before it is started."""
        for component in self._resource_manager.components.values():
            if component.hardware.drives_cycle:
                # One component's states trigger the cycles; the others are read and written then.
                self._lockstep = True
                component.hardware.set_cycle(self._run_lockstep_cycle)
                self._watchdog.absence = component.hardware.absence
                self._logger.info(
                    f"In lockstep with hardware '{component.name}': one cycle for each state"
                )
                return

    def _run_lockstep_cycle(self, time_ns: int) -> None:
        """Run a control cycle for a received state with a time stamp in nanoseconds."""
        last_ns, self._last_state_ns = self._last_state_ns, time_ns
        if not self._rate_compared and last_ns is not None and time_ns > last_ns:
            self._rate_compared = True
            self._compare_rate((time_ns - last_ns) * 1e-9)
        self._cycle.run(time_ns)

    def _compare_rate(self, period: float) -> None:
        """Log a warning if states do not arrive at the update rate."""
        rate = self.manager.update_rate
        if abs(period * rate - 1.0) > _RATE_TOLERANCE:
            self._cycle.report(
                f"States come every {period:g} s, but 'update_rate' is {rate} Hz, a cycle every "
                f"{1.0 / rate:g} s: give the simulator and the controller manager the same rate"
            )

    def _start_cycling(self) -> None:
        """Start the control loop on the wall clock, unless hardware triggers the cycles."""
        self._watchdog.start()
        if self._lockstep:
            return
        self._publish_queue.start_thread()
        manage = self.parameter("overruns.print_warnings")
        self._loop = WallClockLoop(
            self._cycle,
            self.manager.update_rate,
            self._logger,
            print_warnings=manage is None or bool(manage),
        )
        self._loop.start()

    def close(self) -> None:
        """Stop the control loop, unload the controllers, and finalize the hardware."""
        with self._closing_lock:
            self._is_closed = True
        self._watchdog.stop()
        if self._loop is not None:
            self._loop.stop()
        for component in self._resource_manager.components.values():
            component.hardware.set_cycle(_no_cycle)
        self.manager.shutdown()
        self._publish_queue.close()


def end_with_exception(
    logger: RcutilsLogger,
    fail: Callable[[TeleopctlError], object],
    what: str,
    error: BaseException,
) -> None:
    """End the process with an exception of a controller or hardware: ``handle_exceptions: false``.

    A foreseen failure, such as an invalid parameter, is a TeleopctlError, and ends nothing.

    Args:
        logger: Logger of the traceback.
        fail: Called with the error that is to end the process.
        what: What raised it, in a sentence.
        error: The exception.
    """
    if isinstance(error, TeleopctlError):
        return
    logger.fatal("".join(traceback.format_exception(error)).rstrip())
    failure = DefectError(
        what,
        hint="The log has the traceback. With `handle_exceptions: true`, the default, the others "
        "go on.",
    )
    failure.__cause__ = error
    fail(failure)


def unread_manager_parameters(given: Iterable[str], read: Container[str]) -> list[str]:
    """Return the parameters of a manager that have no effect, sorted.

    Args:
        given: Names of the parameters from files and the command line. Those below the name of a
            controller are the controller's.
        read: Names of the parameters that were read at the start.
    """
    return sorted(
        name
        for name in given
        if ("." not in name or name.partition(".")[0] in _OF_MANAGER)
        and name not in read
        and name not in _READ_LATER
    )


def _no_cycle(time_ns: int) -> None:
    del time_ns


def without_node_name(arguments: Sequence[str]) -> list[str]:
    """Return ROS arguments without remap rules of the node's name (``__node``, ``__name``).

    Args:
        arguments: Command line with ``--ros-args`` groups.
    """
    kept: list[str] = []
    words = iter(arguments)
    for word in words:
        if word in ("-r", "--remap"):
            rule = next(words, "")
            if rule.startswith(("__node:=", "__name:=")):
                continue
            kept += [word, rule]
        else:
            kept.append(word)
    return kept
