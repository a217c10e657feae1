"""Chains of controllers: who commands the references of whom, and who reads whose states.

In ros2_control's words the controller that commands *precedes*, and the one whose references it
commands *follows*. An interface is a controller's own where its name begins with the controller's.
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
    """Controllers wait for each other in a cycle; the message names them."""


class Chains:
    """Dependencies among the configured controllers.

    Args:
        controllers: The loaded controllers by name.
        resources: Whose interfaces are hardware's, whatever their names.
    """

    def __init__(
        self, controllers: Mapping[str, ControllerSpec], resources: ResourceManager
    ) -> None:
        self._controllers = controllers
        self._resources = resources

    def exporter(self, interface: str) -> ControllerSpec | None:
        """Return the controller that exports an interface; None for hardware interfaces."""
        spec = self._controllers.get(interface.partition("/")[0])
        if spec is None or self._resources.component_of(interface) is not None:
            return None
        return spec

    def _exporters(self, interfaces: Iterable[str]) -> list[ControllerSpec]:
        found = (self.exporter(interface) for interface in interfaces)
        return list({spec.name: spec for spec in found if spec is not None}.values())

    def following(self, spec: ControllerSpec) -> list[ControllerSpec]:
        """Return the controllers that a controller commands."""
        return self._exporters(spec.required_command_interfaces)

    def read(self, spec: ControllerSpec) -> list[ControllerSpec]:
        """Return the controllers whose exported states a controller reads."""
        return self._exporters(_states(spec))

    def users(self, spec: ControllerSpec) -> list[ControllerSpec]:
        """Return the controllers that require this one to be active."""
        return [
            other
            for other in self._controllers.values()
            if spec in self.following(other) or spec in self.read(other)
        ]

    def connected(self, specs: Iterable[ControllerSpec]) -> list[ControllerSpec]:
        """Return the active controllers that are in one chain with any of the given ones."""
        found = {spec.name: spec for spec in specs}
        waiting = list(found.values())
        while waiting:
            spec = waiting.pop()
            for other in (*self.following(spec), *self.read(spec), *self.users(spec)):
                if other.name not in found and other.lifecycle_state is State.ACTIVE:
                    found[other.name] = other
                    waiting.append(other)
        return list(found.values())

    def connection(self, spec: ControllerSpec) -> dict[str, list[str]]:
        """Return, by following controller, the reference interfaces that a controller commands.

        The references are named without their controllers.
        """
        found: dict[str, list[str]] = {}
        for interface in spec.required_command_interfaces:
            if (other := self.exporter(interface)) is not None:
                found.setdefault(other.name, []).append(interface.partition("/")[2])
        return found

    def in_update_order(self) -> list[ControllerSpec]:
        """Return all controllers in update order: commanding before commanded ones.

        Who commands a controller and reads its states too, as a base does with the controllers of
        its wheels, comes before it. Controllers without a chain keep their order.

        Raises:
            ChainCycleError: There is no such order.
        """
        graph: dict[str, list[str]] = {name: [] for name in self._controllers}
        specs = list(self._controllers.values())
        for spec in specs:
            for other in self.following(spec):
                graph[other.name].append(spec.name)
        _sorted(graph)
        for spec in specs:
            for other in self.read(spec):
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
        """Return why a controller cannot be activated; None if it can.

        Args:
            spec: The controller.
            starting: What the same request activates.
            stopping: What the same request deactivates.
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
            other = self.exporter(interface)
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
        """Return why a controller cannot be deactivated; see ``activation_problem``."""
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

    def commanded(self, running: Iterable[ControllerSpec]) -> set[str]:
        """Return the names of the controllers in chained mode while these are active."""
        return {other.name for spec in running for other in self.following(spec)}

    def restarts(
        self,
        active: Collection[ControllerSpec],
        starting: Collection[ControllerSpec],
        stopping: Collection[ControllerSpec],
    ) -> list[ControllerSpec]:
        """Return the active controllers that must enter or leave chained mode."""
        staying = [spec for spec in active if spec not in stopping]
        commanded = self.commanded((*staying, *starting))
        return [
            spec
            for spec in staying
            if isinstance(spec.controller, ChainableControllerInterface)
            and spec.controller.in_chained_mode is not (spec.name in commanded)
        ]

    def followers_first(self, specs: Iterable[ControllerSpec]) -> list[ControllerSpec]:
        """Return controllers in activation order: commanded before commanding ones."""
        depths: dict[str, int] = {}

        def depth(spec: ControllerSpec) -> int:
            if spec.name not in depths:
                needed = (*self.following(spec), *self.read(spec))
                depths[spec.name] = 0  # for who asks meanwhile: they read each other's states
                depths[spec.name] = 1 + max(map(depth, needed), default=-1)
            return depths[spec.name]

        return sorted(specs, key=depth)


def _states(spec: ControllerSpec) -> tuple[str, ...]:
    """The state interfaces that a controller cannot do without."""
    if spec.state_interface_configuration.type is InterfaceConfigurationType.ALL:
        return ()
    return spec.required_state_interfaces


def _above(graph: Mapping[str, Iterable[str]], name: str) -> set[str]:
    """All that comes before a node."""
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
        raise ChainCycleError(f"controllers that command each other in a circle: {names}") from None
