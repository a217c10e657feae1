"""Controller manager without ROS: the loaded controllers and their life cycles.

``services`` offers the manager to the graph, ``cycle`` runs it. Requests arrive in service threads,
one at a time; the control loop runs in another thread. Their shared data, the tuple of active
controllers and the ownership of interfaces, changes only under ``cycle_lock``, which the loop holds
during a cycle. So a switch happens between two cycles, also while the simulation is paused and no
cycle is due.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Protocol

from teleopctl import plugins
from teleopctl.base.exception_origin import with_origin
from teleopctl.control.asynchronous.update import AsyncUpdate, async_thread
from teleopctl.control.chaining import ChainCycleError, Chains
from teleopctl.control.controller_files import parameter_place, unread_parameter_sentence
from teleopctl.control.controller_spec import ControllerSpec, repeated_name, required_names
from teleopctl.control.controllers.base import (
    ControllerInterface,
    ControllerInterfaceParams,
)
from teleopctl.control.controllers.chainable import (
    ChainableControllerInterface,
    InvalidExportError,
)
from teleopctl.control.controllers.controller_node import with_controller_node
from teleopctl.control.hardware_component import HardwareComponent
from teleopctl.control.lifecycle import CallbackReturn, State
from teleopctl.control.resource_manager import ResourceManager
from teleopctl.control.robot_stop import RobotStop
from teleopctl.errors import (
    BrokenPluginError,
    InvalidParameterError,
    TeleopctlError,
    UnknownPluginError,
)

if TYPE_CHECKING:
    from teleopctl.interfaces import AllowableParameterValue
    from teleopctl.node import Node, RcutilsLogger


LONGEST_CYCLE_S = 1.0
"""Longest wait for the end of a control cycle, in seconds: one that takes longer hangs."""


class ManagerNode(Protocol):
    """Interface of the node that a controller manager uses: parameters, controllers' nodes."""

    def parameter(self, name: str) -> AllowableParameterValue:
        """Return the value of a parameter of the manager's node; None if undeclared."""

    def create_controller_params(self, controller_name: str) -> ControllerInterfaceParams:
        """Create a controller's node; return `ControllerInterfaceParams` with that node."""

    def destroy_controller_node(self, node: Node) -> None:
        """Destroy the node of an unloaded controller."""

    def publish_activity(self) -> None:
        """Publish the lifecycle states of all controllers and hardware components."""


def string_list_parameter(node: ManagerNode, name: str) -> list[str]:
    """Return a manager's parameter, a string or a list, as a list of strings; empty if undeclared.

    Args:
        node: Node of the manager.
        name: Name of the parameter.

    Raises:
        InvalidParameterError: The value is neither a string nor a list of strings.
    """
    value = node.parameter(name)
    strings = [value] if isinstance(value, str) and value else value or []
    if not isinstance(strings, Sequence) or not all(isinstance(each, str) for each in strings):
        raise InvalidParameterError(f"Parameter '{name}' must be a list of strings, got {value!r}")
    return [str(each) for each in strings]


class ControllerManager:
    """Core of a controller manager, without ROS services: holds controllers, changes their states.

    Args:
        resource_manager: Resource manager with the robot's hardware.
        node: Node of the manager.
        logger: Logger of the manager.
        update_rate: Update rate in Hz.

    Attributes:
        controllers: Loaded controllers by name, in update order: the order of loading, but each
            controller before those it commands and after those it reads.
        active_controllers: Active controllers, in update order.
        loaded_types: Types of the controllers that have been loaded so far, as keys.
        cycle_lock: Lock that the loop holds during a cycle.
        robot_stop: State of the robot's stop.
        first_cycle: Set after the first control cycle.
    """

    def __init__(
        self,
        resource_manager: ResourceManager,
        node: ManagerNode,
        logger: RcutilsLogger,
        update_rate: int,
    ) -> None:
        self.resource_manager = resource_manager
        self.node = node
        self.logger = logger
        self.update_rate = update_rate
        self.controllers: dict[str, ControllerSpec] = {}
        self.active_controllers: tuple[ControllerSpec, ...] = ()
        self.loaded_types: dict[str, None] = {}
        self._causes: dict[str, str] = {}
        self.cycle_lock = threading.Lock()
        self.robot_stop = RobotStop()
        self.first_cycle = threading.Event()

    # ---- life cycle of single controllers

    def load_controller(self, name: str) -> bool:
        """Load a controller of the type in parameter ``<name>.type``; return False on failure."""
        if name in self.controllers:
            self.logger.error(
                f"A controller named '{name}' was already loaded inside the controller manager"
            )
            return False
        type_name = self.node.parameter(f"{name}.type")
        if not type_name:
            self.logger.error(f"The 'type' param was not defined for '{name}'.")
            return False
        self.logger.info(f"Loading controller : '{name}' of type '{type_name}'")
        try:
            controller_class = plugins.load(plugins.CONTROLLERS, str(type_name))
        except UnknownPluginError as error:
            near = f" {error.hint}" if error.hint else ""
            self.logger.error(
                f"Loader for controller '{name}' (type '{type_name}') not found.{near}"
            )
            self.logger.info("Available classes:")
            for known in sorted(plugins.available(plugins.CONTROLLERS)):
                self.logger.info(f"  {known}")
            return False
        except BrokenPluginError as error:
            sentence = f"Could not load controller '{name}' (type '{type_name}'): {error.message}"
            self.logger.error(sentence)
            self.resource_manager.on_exception(sentence, error.__cause__ or error)
            return False
        try:
            fallbacks = tuple(string_list_parameter(self.node, f"{name}.fallback_controllers"))
        except InvalidParameterError as error:
            self.logger.error(f"Could not load controller '{name}': {error.message}")
            return False
        if name in fallbacks:
            self.logger.error(f"Controller '{name}' cannot be a fallback controller for itself.")
            return False
        self.logger.info(f"Loading controller '{name}'")
        try:
            params = with_controller_node(self.node.create_controller_params(name))
        except TeleopctlError as error:
            self.logger.error(f"Could not make the node of controller '{name}': {error.message}")
            return False
        try:
            controller: ControllerInterface = controller_class(params)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a controller's failure is reported, not ours
            sentence = f"Could not initialize the controller named '{name}': {with_origin(error)}"
            self.logger.error(sentence)
            self.resource_manager.on_exception(sentence, error)
            self.node.destroy_controller_node(params.node)
            return False
        if self.call(controller, controller.on_init) is not CallbackReturn.SUCCESS:
            self.logger.error(
                f"Could not initialize the controller named '{name}'{self.cause(controller)}"
            )
            self.node.destroy_controller_node(params.node)
            return False
        self.controllers[name] = ControllerSpec(controller, str(type_name), fallbacks)
        plugins.remember_sources(plugins.CONTROLLERS, str(type_name))
        self.loaded_types[str(type_name)] = None
        self.node.publish_activity()
        return True

    def configure_controller(self, name: str) -> bool:
        """Configure a controller, cleaned up first if inactive; return False on failure."""
        spec = self._find(name, "configure")
        if spec is None:
            return False
        self.logger.info(f"Configuring controller: '{name}'")
        if spec.lifecycle_state not in (State.UNCONFIGURED, State.INACTIVE):
            self.logger.error(
                f"Controller '{name}' can not be configured from "
                f"'{spec.lifecycle_state.label}' state."
            )
            return False
        controller = spec.controller
        if spec.lifecycle_state is State.INACTIVE and not self.cleanup_controller(name):
            return False
        if not self.set_rate(controller) or not self._set_thread(spec):
            return False
        outcome = self.call(controller, controller.on_configure)
        if outcome is CallbackReturn.SUCCESS:
            outcome = self.call(controller, partial(self._request_interfaces, spec))
            if outcome is not CallbackReturn.SUCCESS:
                self._remove_interfaces(spec)
                self._call_after_failure(controller, controller.on_cleanup)
        if outcome is CallbackReturn.SUCCESS:
            controller.lifecycle_state = State.INACTIVE
            self._report_unread_parameters(spec)
        else:
            self.logger.error(
                f"Could not configure the controller named '{name}'{self.cause(controller)}"
            )
            self.recover(controller, outcome, State.UNCONFIGURED)
        self.node.publish_activity()
        return outcome is CallbackReturn.SUCCESS

    def _report_unread_parameters(self, spec: ControllerSpec) -> None:
        """Log each parameter without effect once, with its place and the nearest known name."""
        controller = spec.controller
        unread = [
            name
            for name in controller.unread_parameters()
            # A parameter for all nodes of the process is the manager's, too.
            if name not in spec.reported_parameters and self.node.parameter(name) is None
        ]
        if not unread:
            return
        spec.reported_parameters.update(unread)
        files = string_list_parameter(self.node, f"{spec.name}.params_file")
        manager = f"{controller.get_node().get_namespace().rstrip('/')}/controller_manager"
        for name in unread:
            place = parameter_place(spec.name, manager, files, name)
            sentence = unread_parameter_sentence(name, place, controller.known_parameters)
            controller.logger.warning(sentence)

    def cleanup_controller(self, name: str) -> bool:
        """Clean up an inactive controller; return False on failure; do nothing if unconfigured."""
        spec = self._find(name, "cleanup")
        if spec is None:
            return False
        if spec.lifecycle_state is State.UNCONFIGURED:
            return True
        self.logger.info(f"Cleanup controller '{name}'")
        if spec.lifecycle_state is not State.INACTIVE:
            self.logger.error(
                f"Controller '{name}' cannot be cleaned-up from "
                f"'{spec.lifecycle_state.label}' state."
            )
            return False
        controller = spec.controller
        outcome = self.call(controller, controller.on_cleanup)
        controller.lifecycle_state = State.UNCONFIGURED
        self._remove_interfaces(spec)
        if outcome is not CallbackReturn.SUCCESS:
            self.logger.error(f"Failed to clean-up controller '{name}'{self.cause(controller)}")
            self.recover(controller, outcome, State.UNCONFIGURED)
        self.node.publish_activity()
        return outcome is CallbackReturn.SUCCESS

    def unload_controller(self, name: str) -> bool:
        """Clean up and unload a controller that is not active; return False on failure."""
        spec = self._find(name, "unload")
        if spec is None:
            return False
        self.logger.info(f"Unloading controller: '{name}'")
        if spec.lifecycle_state is State.ACTIVE:
            self.logger.error(
                f"Could not unload controller with name '{name}' because it is still active"
            )
            return False
        if spec.lifecycle_state is State.INACTIVE:
            self.cleanup_controller(name)
        self._remove_interfaces(spec)
        if spec.async_update is not None:
            spec.async_update.stop()
        self.call(spec.controller, spec.controller.on_shutdown)
        del self.controllers[name]
        self.node.destroy_controller_node(spec.controller.get_node())
        self.node.publish_activity()
        return True

    def _find(self, name: str, operation: str) -> ControllerSpec | None:
        spec = self.controllers.get(name)
        if spec is None:
            self.logger.error(
                f"Could not {operation} controller with name '{name}' because no controller "
                "with this name exists"
            )
        return spec

    def _request_interfaces(self, spec: ControllerSpec) -> CallbackReturn:
        """Store a controller's exported and required interfaces, each of them named once."""
        controller = spec.controller
        if isinstance(controller, ChainableControllerInterface):
            try:
                controller.export_interfaces()
                self._import_interfaces(controller)
            except InvalidExportError as error:
                return self.record_failure(
                    controller,
                    "Export of the state or reference interfaces failed with following error: "
                    f"{error}",
                )
        spec.command_interface_configuration = controller.command_interface_configuration()
        spec.state_interface_configuration = controller.state_interface_configuration()
        self.refresh_interfaces(spec)
        problem = repeated_name(spec.required_command_interfaces) or repeated_name(
            spec.required_state_interfaces
        )
        if problem is not None:
            return self.record_failure(controller, f"It requires the interface '{problem}' twice.")
        try:
            ordered = self.chains.in_update_order()
        except ChainCycleError as error:
            return self.record_failure(controller, f"It cannot be in a chain of {error}.")
        self.controllers = {other.name: other for other in ordered}
        return CallbackReturn.SUCCESS

    def _import_interfaces(self, controller: ChainableControllerInterface) -> None:
        resources = self.resource_manager
        states, references = controller.exported_state_interfaces, controller.reference_interfaces
        for interface in (*states, *references):
            if resources.component_of(interface.name) is not None:
                controller.forget_exported_interfaces()
                raise InvalidExportError(f"'{interface.name}' is an interface of the hardware.")
        resources.import_interfaces(states, references)

    def _remove_interfaces(self, spec: ControllerSpec) -> None:
        """Remove the interfaces that a controller requires and exports."""
        controller = spec.controller
        spec.required_command_interfaces = spec.required_state_interfaces = ()
        if isinstance(controller, ChainableControllerInterface):
            self.resource_manager.remove_interfaces(
                controller.exported_state_interfaces, controller.reference_interfaces
            )
            controller.forget_exported_interfaces()

    @property
    def chains(self) -> Chains:
        """Chains of the loaded controllers: which commands or reads which others."""
        return Chains(self.controllers, self.resource_manager)

    def refresh_interfaces(self, spec: ControllerSpec) -> None:
        """Recompute the interface names that a controller requires from its configurations."""
        resources = self.resource_manager
        spec.required_command_interfaces = required_names(
            spec.command_interface_configuration, resources.command_interfaces
        )
        spec.required_state_interfaces = required_names(
            spec.state_interface_configuration, resources.state_interfaces
        )

    def set_rate(self, controller: ControllerInterface) -> bool:
        """Set a controller's update rate from its parameter; return False if it is invalid."""
        try:
            wanted = controller.auto_declare("update_rate", self.update_rate)
            if wanted < 0:
                raise InvalidParameterError(
                    f"Parameter 'update_rate' must be at least 0, got {wanted}"
                )
        except TeleopctlError as error:
            self.logger.error(f"Could not configure '{controller.name}': {error.message}")
            return False
        if wanted > self.update_rate:
            self.logger.warning(
                f"The controller : {controller.name} update rate : {wanted} Hz should be less than "
                f"or equal to controller manager's update rate : {self.update_rate} Hz!. The "
                "controller will be updated at controller_manager's update rate."
            )
        controller.update_rate = float(min(wanted, self.update_rate) or self.update_rate)
        return True

    def _set_thread(self, spec: ControllerSpec) -> bool:
        """Set whether a controller has a thread, from its parameter; return False if invalid."""
        controller = spec.controller
        if spec.async_update is not None:
            spec.async_update.stop()
            spec.async_update = None
        try:
            if not controller.auto_declare("is_async", False):
                return True
            thread = async_thread(controller)
        except TeleopctlError as error:
            self.logger.error(f"Could not configure '{controller.name}': {error.message}")
            return False
        resources = self.resource_manager
        spec.async_update = AsyncUpdate(
            lambda: spec.controller, spec.statistics, thread, lambda: not resources.in_lockstep
        )
        if resources.in_lockstep:
            controller.logger.info(
                "Asynchronous in lockstep: the control cycle updates the controller, and its "
                "commands hold from the next cycle on, so that runs repeat exactly"
            )
        else:
            controller.logger.info(
                f"Starting async handler with scheduler priority: {thread.priority}"
            )
        return True

    # ---- shared with switching and the cycle

    def call(
        self, controller: ControllerInterface, function: Callable[[], CallbackReturn | None]
    ) -> CallbackReturn:
        """Call a controller's callback; return its result, SUCCESS for None, ERROR if it raises."""
        # A bound method has a name; a `partial` has none.
        where = getattr(function, "__name__", "its interface configuration")
        self._causes.pop(controller.name, None)
        try:
            outcome = function() or CallbackReturn.SUCCESS
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a controller's failure must not end the manager
            outcome = CallbackReturn.ERROR
            self._causes[controller.name] = f"{where} raised {with_origin(error)}"
            sentence = f"Controller '{controller.name}' raised in {where}: {with_origin(error)}"
            self.logger.error(sentence)
            self.resource_manager.on_exception(sentence, error)
        if outcome is not CallbackReturn.SUCCESS:
            self._causes.setdefault(controller.name, f"{where} returned {outcome.name}")
        return outcome

    def record_failure(self, controller: ControllerInterface, cause: str) -> CallbackReturn:
        """Store the cause of a controller's failure for messages; return CallbackReturn.FAILURE."""
        self._causes[controller.name] = cause
        return CallbackReturn.FAILURE

    def cause(self, controller: ControllerInterface) -> str:
        """Return the cause of a controller's last failure as ``": CAUSE"``; empty if none."""
        return f": {self._causes[controller.name]}" if controller.name in self._causes else ""

    def recover(
        self, controller: ControllerInterface, outcome: CallbackReturn, after_failure: State
    ) -> None:
        """Set a controller's state: to `after_failure` after FAILURE, by ``on_error`` after ERROR.

        Args:
            controller: Controller with the failed callback.
            outcome: Result of the callback: FAILURE or ERROR.
            after_failure: State to set for FAILURE.
        """
        if outcome is CallbackReturn.FAILURE:
            controller.lifecycle_state = after_failure
            return
        recovered = (
            self._call_after_failure(controller, controller.on_error) is CallbackReturn.SUCCESS
        )
        controller.lifecycle_state = State.UNCONFIGURED if recovered else State.FINALIZED

    def _call_after_failure(
        self, controller: ControllerInterface, function: Callable[[], CallbackReturn | None]
    ) -> CallbackReturn:
        """Call a life cycle callback after a failed one, whose cause is kept."""
        cause = self._causes.get(controller.name)
        outcome = self.call(controller, function)
        if cause is not None:
            self._causes[controller.name] = cause
        return outcome

    def deactivate_controllers(self, stopping: Sequence[ControllerSpec]) -> list[str]:
        """Deactivate controllers and release their interfaces; return the names of failed ones."""
        failed = []
        for spec in stopping:
            controller = spec.controller
            if spec.async_update is not None:
                spec.async_update.pause()
            outcome = self.call(controller, controller.on_deactivate)
            if spec.async_update is not None:
                spec.async_update.finish()
            if outcome is CallbackReturn.SUCCESS:
                controller.lifecycle_state = State.INACTIVE
            else:
                failed.append(spec.name)
                self.recover(controller, outcome, State.INACTIVE)
            self.resource_manager.release_command_interfaces(spec.name)
            controller.command_interfaces = []
            controller.state_interfaces = []
            if isinstance(controller, ChainableControllerInterface):
                controller.set_chained_mode(False)
                controller.make_exported_interfaces_available(False)
        return failed

    def stop_controllers(self, stopping: Sequence[ControllerSpec]) -> None:
        """Stop updating and deactivate controllers; called with ``cycle_lock`` held."""
        self.active_controllers = tuple(
            spec for spec in self.active_controllers if spec not in stopping
        )
        self.resource_manager.perform_command_mode_switch(
            [], [name for spec in stopping for name in spec.required_command_interfaces]
        )
        self.deactivate_controllers(stopping)

    def users_of(
        self, component: HardwareComponent, *, only_commands: bool
    ) -> list[ControllerSpec]:
        """Return the active controllers that command or read interfaces of a hardware component."""
        hardware = component.hardware
        users = []
        for spec in self.active_controllers:
            uses_commands = any(
                name in hardware.command_interfaces for name in spec.required_command_interfaces
            )
            uses_states = any(
                name in hardware.state_interfaces for name in spec.required_state_interfaces
            )
            if uses_commands or (uses_states and not only_commands):
                users.append(spec)
        return users

    def shutdown(self) -> None:
        """Deactivate and unload all controllers, and finalize all hardware components.

        A cycle that hangs prevents that.
        """
        if not self.cycle_lock.acquire(timeout=LONGEST_CYCLE_S):
            self.logger.error(
                "Controllers and hardware are not deactivated: the control cycle does not end"
            )
            return
        try:
            active, self.active_controllers = self.active_controllers, ()
            self.deactivate_controllers(active)
        finally:
            self.cycle_lock.release()
        for name in list(self.controllers):
            self.unload_controller(name)
        self.resource_manager.shutdown_components()
