"""The controller manager's heart: which controllers there are and in what state.

It knows no ROS services; ``services`` offers it to the graph, ``cycle`` runs it. Requests come
from service threads, one at a time; the control loop runs in another thread. What both touch, the
tuple of running controllers and the ownership of interfaces, changes only under ``cycle_lock``,
which the loop holds during a cycle. So a switch happens between two cycles, also when no cycle is
due because the simulation is paused.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

from teleopctl import plugins
from teleopctl.control.controllers.base import ControllerInterface, Environment
from teleopctl.control.hardware_component import Component
from teleopctl.control.lifecycle import CallbackReturn, State
from teleopctl.control.resource_manager import ResourceManager
from teleopctl.errors import (
    BrokenPluginError,
    InvalidParameterError,
    TeleopctlError,
    UnknownPluginError,
)


class Host(Protocol):
    """What the manager needs from the process around it."""

    def parameter(self, name: str) -> Any:
        """A parameter of the controller manager's node, or None."""

    def create_environment(self, controller: str) -> Environment:
        """A node for a controller, and all else that it needs."""

    def destroy_environment(self, environment: Environment) -> None:
        """Take a controller's node out of the graph."""

    def changed(self) -> None:
        """A controller or a component has changed its state."""


@dataclass
class Loaded:
    """A controller that has been loaded.

    Attributes:
        controller: The controller.
        type_name: Its plug-in's name.
        fallbacks: Controllers that take over when its update fails.
        command_names: Command interfaces that it needs, known once it is configured.
        state_names: State interfaces that it needs, likewise.
        all_states: Whether it reads every state interface that is available.
        last_update_ns: Time of its last update on the clock that triggers the cycles, or None
            since its activation.
    """

    controller: ControllerInterface
    type_name: str
    fallbacks: tuple[str, ...] = ()
    command_names: tuple[str, ...] = ()
    state_names: tuple[str, ...] = ()
    all_states: bool = False
    last_update_ns: int | None = field(default=None)

    @property
    def name(self) -> str:
        """The controller's name."""
        return self.controller.name

    @property
    def state(self) -> State:
        """Where the controller stands in its life cycle."""
        return self.controller.state


class ControllerManager:
    """Loads, configures, starts and stops controllers.

    Args:
        resources: The robot's hardware.
        host: The process around it.
        logger: The manager's logger.
        update_rate: Cycles per second.

    Attributes:
        controllers: Loaded controllers by name, in the order in which they were loaded.
        running: The active controllers, in the order in which they are updated.
        cycle_lock: Held by the loop during a cycle.
    """

    def __init__(
        self, resources: ResourceManager, host: Host, logger: Any, update_rate: int
    ) -> None:
        self.resources = resources
        self.host = host
        self.logger = logger
        self.update_rate = update_rate
        self.controllers: dict[str, Loaded] = {}
        self.running: tuple[Loaded, ...] = ()
        self.cycle_lock = threading.Lock()

    # ---- life cycle of single controllers

    def load(self, name: str) -> bool:
        """Make a controller; its type comes from the parameter ``<name>.type``."""
        if name in self.controllers:
            self.logger.error(
                f"A controller named '{name}' was already loaded inside the controller manager"
            )
            return False
        type_name = self.host.parameter(f"{name}.type")
        if not type_name:
            self.logger.error(f"The 'type' param was not defined for '{name}'.")
            return False
        self.logger.info(f"Loading controller : '{name}' of type '{type_name}'")
        try:
            controller_class = plugins.load(plugins.CONTROLLERS, str(type_name))
        except (UnknownPluginError, BrokenPluginError) as error:
            self.logger.error(f"Loader for controller '{name}' (type '{type_name}') not found.")
            self.logger.info(str(error))
            return False
        fallbacks = tuple(self.host.parameter(f"{name}.fallback_controllers") or ())
        if name in fallbacks:
            self.logger.error(f"Controller '{name}' cannot be a fallback controller for itself.")
            return False
        self.logger.info(f"Loading controller '{name}'")
        try:
            environment = self.host.create_environment(name)
        except TeleopctlError as error:
            self.logger.error(f"Could not make the node of controller '{name}': {error.message}")
            return False
        try:
            controller: ControllerInterface = controller_class(name, environment)
        except Exception as error:  # noqa: BLE001 - a controller's failure is reported, not ours
            self.logger.error(f"Could not initialize the controller named '{name}': {error}")
            self.host.destroy_environment(environment)
            return False
        if self.call(controller, controller.on_init) is not CallbackReturn.SUCCESS:
            self.logger.error(f"Could not initialize the controller named '{name}'")
            self.host.destroy_environment(environment)
            return False
        self.controllers[name] = Loaded(controller, str(type_name), fallbacks)
        self.host.changed()
        return True

    def configure(self, name: str) -> bool:
        """Bring a controller from unconfigured or inactive to inactive."""
        loaded = self._find(name, "configure")
        if loaded is None:
            return False
        self.logger.info(f"Configuring controller: '{name}'")
        if loaded.state not in (State.UNCONFIGURED, State.INACTIVE):
            self.logger.error(
                f"Controller '{name}' can not be configured from '{loaded.state.label}' state."
            )
            return False
        controller = loaded.controller
        if loaded.state is State.INACTIVE and not self.cleanup(name):
            return False
        if not self._set_rate(controller):
            return False
        outcome = self.call(controller, controller.on_configure)
        if outcome is CallbackReturn.SUCCESS:
            outcome = self.call(controller, partial(self._ask_interfaces, loaded))
            if outcome is not CallbackReturn.SUCCESS:
                self.call(controller, controller.on_cleanup)
        if outcome is CallbackReturn.SUCCESS:
            controller.state = State.INACTIVE
        else:
            self.logger.error(f"Could not configure the controller named '{name}'")
            self.recover(controller, outcome, State.UNCONFIGURED)
        self.host.changed()
        return outcome is CallbackReturn.SUCCESS

    def cleanup(self, name: str) -> bool:
        """Bring a controller from inactive to unconfigured."""
        loaded = self._find(name, "cleanup")
        if loaded is None:
            return False
        if loaded.state is State.UNCONFIGURED:
            return True
        self.logger.info(f"Cleanup controller '{name}'")
        if loaded.state is not State.INACTIVE:
            self.logger.error(
                f"Controller '{name}' cannot be cleaned-up from '{loaded.state.label}' state."
            )
            return False
        controller = loaded.controller
        outcome = self.call(controller, controller.on_cleanup)
        controller.state = State.UNCONFIGURED
        loaded.command_names = loaded.state_names = ()
        if outcome is not CallbackReturn.SUCCESS:
            self.logger.error(f"Failed to clean-up controller '{name}'")
            self.recover(controller, outcome, State.UNCONFIGURED)
        self.host.changed()
        return outcome is CallbackReturn.SUCCESS

    def unload(self, name: str) -> bool:
        """Remove a controller that is not active."""
        loaded = self._find(name, "unload")
        if loaded is None:
            return False
        self.logger.info(f"Unloading controller: '{name}'")
        if loaded.state is State.ACTIVE:
            self.logger.error(
                f"Could not unload controller with name '{name}' because it is still active"
            )
            return False
        if loaded.state is State.INACTIVE:
            self.cleanup(name)
        self.call(loaded.controller, loaded.controller.on_shutdown)
        del self.controllers[name]
        self.host.destroy_environment(loaded.controller.env)
        self.host.changed()
        return True

    def _find(self, name: str, operation: str) -> Loaded | None:
        loaded = self.controllers.get(name)
        if loaded is None:
            self.logger.error(
                f"Could not {operation} controller with name '{name}' because no controller "
                "with this name exists"
            )
        return loaded

    def _ask_interfaces(self, loaded: Loaded) -> CallbackReturn:
        """Ask a controller what it needs; each interface may be named once."""
        wanted = loaded.controller.wanted_states()
        loaded.all_states = wanted.everything
        loaded.state_names = wanted.names
        loaded.command_names = loaded.controller.wanted_commands().names
        problem = _repeated(loaded.command_names) or _repeated(loaded.state_names)
        if problem is None:
            self.refresh_states(loaded)
            return CallbackReturn.SUCCESS
        self.logger.error(f"Controller '{loaded.name}' asks for the interface '{problem}' twice.")
        return CallbackReturn.FAILURE

    def refresh_states(self, loaded: Loaded) -> None:
        """Bring what a controller reads up to date, if it reads whatever there is."""
        if loaded.all_states:
            states = self.resources.states
            loaded.state_names = tuple(name for name in states if states[name].available)

    def _set_rate(self, controller: ControllerInterface) -> bool:
        """Take the controller's own update rate over; False when it is none."""
        try:
            wanted = controller.parameter("update_rate", self.update_rate)
            if controller.parameter("is_async", False):
                self.logger.warning(
                    f"Controller '{controller.name}': 'is_async' has no effect, it is updated in "
                    "the control loop"
                )
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

    # ---- shared with switching and the cycle

    def call(
        self, controller: ControllerInterface, function: Callable[[], CallbackReturn | None]
    ) -> CallbackReturn:
        """Run a life cycle callback; what it raises is logged and counts as an error."""
        try:
            return function() or CallbackReturn.SUCCESS
        except Exception as error:  # noqa: BLE001 - a controller's failure must not end the manager
            where = getattr(function, "__name__", "its choice of interfaces")
            self.logger.error(
                f"Controller '{controller.name}' raised in {where}: {type(error).__name__}: {error}"
            )
            return CallbackReturn.ERROR

    def recover(
        self, controller: ControllerInterface, outcome: CallbackReturn, after_failure: State
    ) -> None:
        """Choose the state after a life cycle callback that did not succeed.

        Args:
            controller: The controller.
            outcome: What the callback returned.
            after_failure: Its state when that was FAILURE.
        """
        if outcome is CallbackReturn.FAILURE:
            controller.state = after_failure
        elif self.call(controller, controller.on_error) is CallbackReturn.SUCCESS:
            controller.state = State.UNCONFIGURED
        else:
            controller.state = State.FINALIZED

    def stop(self, stopping: Sequence[Loaded]) -> list[str]:
        """Deactivate controllers that are no longer in ``running``; returns those that failed."""
        failed = []
        for loaded in stopping:
            controller = loaded.controller
            outcome = self.call(controller, controller.on_deactivate)
            if outcome is CallbackReturn.SUCCESS:
                controller.state = State.INACTIVE
            else:
                failed.append(loaded.name)
                self.recover(controller, outcome, State.INACTIVE)
            self.resources.release(loaded.name)
            controller.command_interfaces = []
            controller.state_interfaces = []
        return failed

    def fail(self, failed: Sequence[Loaded]) -> None:
        """Stop controllers whose update failed; called by the loop inside a cycle."""
        self.running = tuple(loaded for loaded in self.running if loaded not in failed)
        self.resources.switch_mode(
            [], [name for loaded in failed for name in loaded.command_names], perform=True
        )
        self.stop(failed)

    def users_of(self, component: Component, *, only_commands: bool) -> list[Loaded]:
        """The running controllers that use a component's interfaces."""
        hardware = component.hardware
        users = []
        for loaded in self.running:
            uses_commands = any(name in hardware.commands for name in loaded.command_names)
            uses_states = any(name in hardware.states for name in loaded.state_names)
            if uses_commands or (uses_states and not only_commands):
                users.append(loaded)
        return users

    def shutdown(self) -> None:
        """Stop and unload everything."""
        with self.cycle_lock:
            stopping, self.running = self.running, ()
            self.stop(stopping)
        for name in list(self.controllers):
            self.unload(name)
        self.resources.shutdown()


def _repeated(names: Sequence[str]) -> str | None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None
