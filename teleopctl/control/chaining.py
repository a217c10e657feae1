"""Chains of controllers: which commands which, and which reads whose exported states.

In ros2_control's terms, a *preceding* controller commands the references of a *following* one. An
interface belongs to a controller if its name begins with the controller's name.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from graphlib import CycleError, TopologicalSorter

from teleopctl.control.controller_spec import ControllerSpec
from teleopctl.control.controllers.base import InterfaceConfigurationType
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.lifecycle import State
from teleopctl.control.resource_manager import ResourceManager


class ChainCycleError(Exception):
    """Raised when controllers command each other in a cycle; the message names them."""


class Chains:
    """Chains of loaded controllers: which command or read which, and what order follows from it.

    Args:
        controllers: Loaded controllers by name.
        resources: Resource manager with the interfaces of the hardware.
    """

    def __init__(
        self, controllers: Mapping[str, ControllerSpec], resources: ResourceManager
    ) -> None:
        self._controllers = controllers
        self._resources = resources

    def exporting_controller(self, interface: str) -> ControllerSpec | None:
        """Return the controller whose name begins an interface's name; None for hardware's."""
        spec = self._controllers.get(interface.partition("/")[0])
        if spec is None or self._resources.component_of(interface) is not None:
            return None
        return spec

    def _exporters(self, interfaces: Iterable[str]) -> list[ControllerSpec]:
        found = (self.exporting_controller(interface) for interface in interfaces)
        return list({spec.name: spec for spec in found if spec is not None}.values())

    def commanded_controllers(self, spec: ControllerSpec) -> list[ControllerSpec]:
        """Return the controllers whose reference interfaces a controller requires."""
        return self._exporters(spec.required_command_interfaces)

    def state_sources(self, spec: ControllerSpec) -> list[ControllerSpec]:
        """Return the controllers whose exported states a controller requires by name."""
        return self._exporters(_states(spec))

    def users(self, spec: ControllerSpec) -> list[ControllerSpec]:
        """Return the controllers that require a controller's references or exported states."""
        return [
            other
            for other in self._controllers.values()
            if spec in self.commanded_controllers(other) or spec in self.state_sources(other)
        ]

    def connected(self, specs: Iterable[ControllerSpec]) -> list[ControllerSpec]:
        """Return the given controllers and all active controllers that chains connect to them."""
        found = {spec.name: spec for spec in specs}
        waiting = list(found.values())
        while waiting:
            spec = waiting.pop()
            for other in (
                *self.commanded_controllers(spec),
                *self.state_sources(spec),
                *self.users(spec),
            ):
                if other.name not in found and other.lifecycle_state is State.ACTIVE:
                    found[other.name] = other
                    waiting.append(other)
        return list(found.values())

    def chain_connections(self, spec: ControllerSpec) -> dict[str, list[str]]:
        """Return the references that a controller requires, by exporting controller's name.

        The names of the references are without the controller's name.
        """
        found: dict[str, list[str]] = {}
        for interface in spec.required_command_interfaces:
            if (other := self.exporting_controller(interface)) is not None:
                found.setdefault(other.name, []).append(interface.partition("/")[2])
        return found

    def in_update_order(self) -> list[ControllerSpec]:
        """Return all controllers, each before those commanded, after those read; raise on cycles.

        A controller that both commands another controller and reads its states is before it.
        Controllers without a chain keep their order.

        Raises:
            ChainCycleError: Controllers command each other in a cycle.
        """
        graph: dict[str, list[str]] = {name: [] for name in self._controllers}
        specs = list(self._controllers.values())
        for spec in specs:
            for other in self.commanded_controllers(spec):
                graph[other.name].append(spec.name)
        _sorted(graph)
        for spec in specs:
            for other in self.state_sources(spec):
                if spec.name not in _above(graph, other.name):
                    graph[spec.name].append(other.name)
        return [self._controllers[name] for name in _sorted(graph)]

    # -- switching ---------------------------------------------------------------------------------

    def activation_problem(
        self,
        spec: ControllerSpec,
        starting: Collection[ControllerSpec],
        stopping: Collection[ControllerSpec],
    ) -> str | None:
        """Return the reason why a switch cannot activate a controller; None if it can.

        Args:
            spec: Controller to activate.
            starting: Controllers that the same switch activates.
            stopping: Controllers that the same switch deactivates.
        """
        name = spec.name
        if spec.lifecycle_state is State.UNCONFIGURED:
            return (
                f"Controller with name '{name}' is in 'unconfigured' state. The controller needs "
                "to be configured to be in 'inactive' state before it can be checked and activated."
            )
        if spec.lifecycle_state is State.ACTIVE and spec not in stopping:
            return f"Controller with name '{name}' is already active."
        if spec.lifecycle_state not in (State.INACTIVE, State.ACTIVE):
            return f"Controller with name '{name}' is in '{spec.lifecycle_state.label}' state."
        return self._following_problem(spec, starting, stopping) or self._fallback_problem(spec)

    def _following_problem(
        self,
        spec: ControllerSpec,
        starting: Collection[ControllerSpec],
        stopping: Collection[ControllerSpec],
    ) -> str | None:
        for interface in (*spec.required_command_interfaces, *_states(spec)):
            other = self.exporting_controller(interface)
            if other is None:
                continue
            if not isinstance(other.controller, ChainableControllerInterface):
                return (
                    f"No state/reference interface from controller : '{interface}' exist, since "
                    f"the following controller with name '{other.name}' is not chainable."
                )
            if other in starting:
                continue
            if other.lifecycle_state is not State.ACTIVE:
                return (
                    f"The following controller with name '{other.name}' is currently inactive and "
                    "it is not requested to be activated."
                )
            if other in stopping:
                return (
                    f"The following controller with name '{other.name}' is currently active but "
                    "it is requested to be deactivated."
                )
        return None

    def _fallback_problem(self, spec: ControllerSpec) -> str | None:
        for fallback in spec.fallback_controllers:
            other = self._controllers.get(fallback)
            if other is None or other.lifecycle_state is not State.INACTIVE:
                state = (
                    "not loaded" if other is None else f"in '{other.lifecycle_state.label}' state"
                )
                return (
                    f"Controller with name '{spec.name}' cannot be activated, as its fallback "
                    f"controller '{fallback}' is {state}."
                )
        return None

    def deactivation_problem(
        self,
        spec: ControllerSpec,
        starting: Collection[ControllerSpec],
        stopping: Collection[ControllerSpec],
    ) -> str | None:
        """Return the reason why a switch cannot deactivate a controller; None if it can."""
        if spec.lifecycle_state is not State.ACTIVE:
            return (
                f"Controller with name '{spec.name}' can not be deactivated since it is not active."
            )
        if not isinstance(spec.controller, ChainableControllerInterface):
            return None
        for user in self.users(spec):
            text = (
                f"Unable to deactivate controller with name '{spec.name}' because preceding "
                f"controller with name '{user.name}' is"
            )
            if user.lifecycle_state is not State.ACTIVE and user in starting:
                if spec in starting:
                    continue
                return f"{text} inactive and will be activated."
            if user.lifecycle_state is State.ACTIVE and user not in stopping:
                return f"{text} currently active and will not be deactivated."
        return None

    def controllers_in_chained_mode(self, running: Iterable[ControllerSpec]) -> set[str]:
        """Return the names of the controllers that the given running controllers command."""
        return {other.name for spec in running for other in self.commanded_controllers(spec)}

    def chained_mode_changes(
        self,
        active: Collection[ControllerSpec],
        starting: Collection[ControllerSpec],
        stopping: Collection[ControllerSpec],
    ) -> list[ControllerSpec]:
        """Return the controllers that stay active in a switch but enter or leave chained mode."""
        staying = [spec for spec in active if spec not in stopping]
        controllers_in_chained_mode = self.controllers_in_chained_mode((*staying, *starting))
        return [
            spec
            for spec in staying
            if isinstance(spec.controller, ChainableControllerInterface)
            and spec.controller.in_chained_mode is not (spec.name in controllers_in_chained_mode)
        ]

    def in_activation_order(self, specs: Iterable[ControllerSpec]) -> list[ControllerSpec]:
        """Return controllers in activation order: each after those that it commands or reads."""
        depths: dict[str, int] = {}

        def depth(spec: ControllerSpec) -> int:
            if spec.name not in depths:
                needed = (*self.commanded_controllers(spec), *self.state_sources(spec))
                depths[spec.name] = 0  # controllers may read each other's states
                depths[spec.name] = 1 + max(map(depth, needed), default=-1)
            return depths[spec.name]

        return sorted(specs, key=depth)


def _states(spec: ControllerSpec) -> tuple[str, ...]:
    """Return the state interfaces that a controller requires by name."""
    if spec.state_interface_configuration.type is InterfaceConfigurationType.ALL:
        return ()
    return spec.required_state_interfaces


def _above(graph: Mapping[str, Iterable[str]], name: str) -> set[str]:
    """Return all nodes that come before a node of the graph."""
    found: set[str] = set()
    waiting = list(graph[name])
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting += graph[node]
    return found


def _sorted(graph: Mapping[str, Iterable[str]]) -> list[str]:
    try:
        return list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        names = " -> ".join(f"'{name}'" for name in error.args[1])
        raise ChainCycleError(f"controllers that command each other in a cycle: {names}") from None
