"""Switching of controllers between two control cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controller_spec import ControllerSpec
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.lifecycle import CallbackReturn, State
from teleopctl.control.resource_manager import ClaimError


class Strictness(IntEnum):
    """Strictness of a request to switch controllers, numbered as in controller_manager_msgs."""

    DEFAULT = 0
    BEST_EFFORT = 1
    STRICT = 2
    AUTO = 3
    FORCE_AUTO = 4


@dataclass(frozen=True)
class SwitchRequest:
    """Request to activate and deactivate controllers, as of ``~/switch_controller``.

    Attributes:
        activate_controllers: Names of controllers to activate.
        deactivate_controllers: Names of controllers to deactivate.
        strictness: Treatment of controllers that cannot be switched.
        activate_asap: Whether the control loop waits for the switch; otherwise the loop updates
            other controllers during the switch.
        timeout_s: Longest wait for the end of the running cycle, in seconds of wall time.
    """

    activate_controllers: Sequence[str]
    deactivate_controllers: Sequence[str]
    strictness: Strictness = Strictness.STRICT
    activate_asap: bool = True
    timeout_s: float = 1.0


class _SwitchRefused(Exception):
    """Raised when a switch request is refused; the message says why."""


NOT_INITIALIZED = (
    "Resource Manager is not initialized yet! Please provide robot description on "
    "'robot_description' topic before trying to switch controllers."
)


def switch_controller(manager: ControllerManager, request: SwitchRequest) -> tuple[bool, str]:
    """Activate and deactivate requested controllers; return the success and a message.

    Args:
        manager: Controller manager with the controllers.
        request: Controllers to switch.

    Returns:
        Whether the switch succeeded, and a message for users.
    """
    log = manager.logger
    if not manager.resource_manager.components_initialized:
        log.error(NOT_INITIALIZED)
        return False, NOT_INITIALIZED
    strict = request.strictness is Strictness.STRICT
    try:
        activate = _known(manager, request.activate_controllers, "activate", strict=strict)
        deactivate = _known(manager, request.deactivate_controllers, "deactivate", strict=strict)
        for spec in activate:
            restarted = spec.lifecycle_state is State.ACTIVE and spec in deactivate
            if restarted or spec.lifecycle_state is State.INACTIVE:
                manager.refresh_interfaces(spec)
        starting, stopping = _accepted(manager, activate, deactivate, strict=strict)
        if not starting and not stopping:
            text = (
                "After checking the controllers, no controllers need to be activated or "
                "deactivated."
            )
            log.info(text)
            return True, text
        restarting = manager.chains.chained_mode_changes(
            manager.active_controllers, starting, stopping
        )
        starting, stopping = [*starting, *restarting], [*stopping, *restarting]
        _check_interfaces(manager, starting, stopping)
        _check_hardware(manager, starting, stopping)
    except _SwitchRefused as refusal:
        return False, str(refusal)
    return _perform(manager, starting, stopping, request)


def _known(
    manager: ControllerManager, names: Sequence[str], verb: str, *, strict: bool
) -> list[ControllerSpec]:
    known: list[ControllerSpec] = []
    problems = []
    for name in names:
        spec = manager.controllers.get(name)
        if spec is None:
            problems.append(
                f"Could not {verb} controller with name '{name}' because no controller with "
                "this name exists"
            )
            manager.logger.error(problems[-1])
        elif spec not in known:
            known.append(spec)
    if problems and (strict or not known):
        raise _SwitchRefused("\n".join(problems))
    return known


def _accepted(
    manager: ControllerManager,
    activate: Sequence[ControllerSpec],
    deactivate: Sequence[ControllerSpec],
    *,
    strict: bool,
) -> tuple[list[ControllerSpec], list[ControllerSpec]]:
    """Return the controllers that can be started, and stopped, given the chains they are in."""
    starting, stopping = list(activate), list(deactivate)
    chains = manager.chains
    while True:
        count = len(starting) + len(stopping)
        stopping = [
            spec
            for spec in stopping
            if _accept(
                manager, chains.deactivation_problem(spec, starting, stopping), strict=strict
            )
        ]
        starting = [
            spec
            for spec in starting
            if _accept(manager, chains.activation_problem(spec, starting, stopping), strict=strict)
        ]
        # A controller that was removed may be required by another one in its chain.
        if len(starting) + len(stopping) == count:
            return starting, stopping


def _accept(manager: ControllerManager, problem: str | None, *, strict: bool) -> bool:
    """Return whether a controller takes part in a switch; raise for a problem if strict."""
    if problem is None:
        return True
    if strict:
        manager.logger.error(problem)
        manager.logger.error("Aborting, no controller is switched! (::STRICT switch)")
        raise _SwitchRefused(f"{problem}\nAborting, no controller is switched! (::STRICT switch)")
    manager.logger.warning(problem)
    return False


def _check_interfaces(
    manager: ControllerManager,
    starting: Sequence[ControllerSpec],
    stopping: Sequence[ControllerSpec],
) -> None:
    """Raise unless each interface to start exists, is available, and is free after the stops."""
    freed = {spec.name for spec in stopping}
    wanted: dict[str, str] = {}
    resources, chains = manager.resource_manager, manager.chains
    inactive_is_enough = bool(
        manager.node.parameter("defaults.allow_controller_activation_with_inactive_hardware")
    )

    def refuse(name: str, reason: str) -> None:
        text = f"Unable to activate controller '{name}' since {reason}"
        manager.logger.error(text)
        raise _SwitchRefused(text)

    for spec in starting:
        for interface in spec.required_command_interfaces:
            command = resources.command_interfaces.get(interface)
            label = f"the command interface '{interface}'"
            component = resources.component_of(interface)
            # A reference interface becomes available with its controller, as checked before.
            exported = chains.exporting_controller(interface) is not None
            if command is None or not (exported or command.available):
                refuse(spec.name, f"{label} is not available.")
                return
            if (
                component is not None
                and component.lifecycle_state is not State.ACTIVE
                and not inactive_is_enough
            ):
                refuse(
                    spec.name,
                    f"the hardware component '{component.name}' of {label} is in "
                    f"'{component.lifecycle_state.label}' state.",
                )
            if command.owner is not None and command.owner not in freed:
                refuse(
                    spec.name,
                    f"{label} is currently claimed by another controller. It is held by "
                    f"'{command.owner}': deactivate that one in the same request.",
                )
            if interface in wanted:
                refuse(
                    spec.name,
                    f"{label} will be used by another controller that is being activated: "
                    f"'{wanted[interface]}'.",
                )
            wanted[interface] = spec.name
        for interface in spec.required_state_interfaces:
            state = resources.state_interfaces.get(interface)
            exported = chains.exporting_controller(interface) is not None
            if state is None or not (exported or state.available):
                refuse(spec.name, f"the state interface '{interface}' is not available.")


def _modes(
    starting: Sequence[ControllerSpec], stopping: Sequence[ControllerSpec]
) -> tuple[list[str], list[str]]:
    return (
        [name for spec in starting for name in spec.required_command_interfaces],
        [name for spec in stopping for name in spec.required_command_interfaces],
    )


def _check_hardware(
    manager: ControllerManager,
    starting: Sequence[ControllerSpec],
    stopping: Sequence[ControllerSpec],
) -> None:
    resources = manager.resource_manager
    for spec in starting:
        for name in spec.required_command_interfaces:
            resources.command_interfaces[name].next_owner = spec.name
    try:
        prepared = resources.prepare_command_mode_switch(*_modes(starting, stopping))
    finally:
        for command in resources.command_interfaces.values():
            command.next_owner = None
    if not prepared:
        text = "Could not switch controllers since prepare command mode switch was rejected."
        manager.logger.error(text)
        raise _SwitchRefused(text)


def _perform(
    manager: ControllerManager,
    starting: Sequence[ControllerSpec],
    stopping: Sequence[ControllerSpec],
    request: SwitchRequest,
) -> tuple[bool, str]:
    log = manager.logger
    if stopping:
        log.info(f"Deactivating controllers: [ {' '.join(c.name for c in stopping)} ]")
    if starting:
        log.info(f"Activating controllers: [ {' '.join(c.name for c in starting)} ]")
    strict = request.strictness is Strictness.STRICT
    for spec in stopping:
        if spec.async_update is not None:
            # The control loop does not wait for a running update.
            spec.async_update.pause()
    if not manager.cycle_lock.acquire(timeout=request.timeout_s):
        for spec in stopping:
            if spec.async_update is not None:
                spec.async_update.resume()
        # A cycle hangs, probably in a plug-in.
        text = f"Switch controller timed out after {request.timeout_s:g} seconds!"
        log.error(text)
        return False, text
    try:
        manager.active_controllers = tuple(
            c for c in manager.active_controllers if c not in stopping
        )
        if request.activate_asap:
            unstopped, unstarted, started = _exchange(manager, starting, stopping, strict=strict)
            _run(manager, started)
    finally:
        manager.cycle_lock.release()
    if not request.activate_asap:
        unstopped, unstarted, started = _exchange(manager, starting, stopping, strict=strict)
        with manager.cycle_lock:
            lost = [spec for spec in started if not _available(manager, spec)]
            if lost:
                # The hardware of these controllers failed during their activation.
                manager.deactivate_controllers(lost)
                for spec in lost:
                    manager.record_failure(spec.controller, "its hardware has failed")
                unstarted += [spec.name for spec in lost]
                started = [spec for spec in started if spec not in lost]
            _run(manager, started)
    manager.node.publish_activity()
    if not unstopped and not unstarted:
        log.info("Successfully switched controllers!")
        lines = ["Successfully switched controllers!"]
        if not strict:
            if stopping:
                lines.append(f"Deactivated controllers: [ {' '.join(c.name for c in stopping)} ]")
            if started:
                lines.append(f"Activated controllers: [ {' '.join(c.name for c in started)} ]")
        return True, "\n".join(lines)
    message = "Failed switching controllers.... "
    if unstarted:
        message += f"\nUnable to activate controllers: [ {' '.join(unstarted)} ]"
    if unstopped:
        message += f"\nUnable to deactivate controllers: [ {' '.join(unstopped)} ]"
    for name in (*unstarted, *unstopped):
        spec = manager.controllers[name]
        message += f"\n{name}{cause}" if (cause := manager.cause(spec.controller)) else ""
    log.error(message)
    return False, message


def _available(manager: ControllerManager, spec: ControllerSpec) -> bool:
    """Return whether all interfaces of a controller are still available."""
    resources = manager.resource_manager
    commands = map(resources.command_interfaces.get, spec.required_command_interfaces)
    states = map(resources.state_interfaces.get, spec.required_state_interfaces)
    return all(interface is not None and interface.available for interface in (*commands, *states))


def _run(manager: ControllerManager, started: Sequence[ControllerSpec]) -> None:
    """Add started controllers to the active ones, in update order."""
    for spec in started:
        spec.last_update_cycle_time_ns = None
        spec.statistics.reset()
        spec.statistics.set_rate(spec.controller.update_rate)
    chosen = {*(c.name for c in manager.active_controllers), *(c.name for c in started)}
    manager.active_controllers = tuple(c for c in manager.controllers.values() if c.name in chosen)


def _exchange(
    manager: ControllerManager,
    starting: Sequence[ControllerSpec],
    stopping: Sequence[ControllerSpec],
    *,
    strict: bool,
) -> tuple[list[str], list[str], list[ControllerSpec]]:
    """Stop and start controllers; return those not stopped, not started, and started.

    The loop no longer updates the controllers to stop, and does not update those to start yet.
    """
    if not manager.resource_manager.perform_command_mode_switch(*_modes(starting, stopping)):
        manager.logger.error("Error while performing mode switch.")
        manager.deactivate_controllers(stopping)
        return [], [c.name for c in starting], []
    chains = manager.chains
    # A controller stops before those that it commands, and starts after them.
    unstopped = manager.deactivate_controllers(chains.in_activation_order(stopping)[::-1])
    started: list[ControllerSpec] = []
    unstarted: list[ControllerSpec] = []
    commanded = chains.controllers_in_chained_mode((*manager.active_controllers, *starting))
    for spec in chains.in_activation_order(starting):
        (started if _start(manager, spec, spec.name in commanded) else unstarted).append(spec)
    if unstarted and not strict:
        # Controllers started in chained mode by failed ones restart without chained mode.
        unchained = chains.chained_mode_changes((*manager.active_controllers, *started), [], [])
        chained = [spec for spec in started if spec in unchained]
        manager.deactivate_controllers(chained)
        failed = [spec for spec in chained if not _start(manager, spec, False)]
        started = [spec for spec in started if spec not in failed]
        unstarted += failed
    if unstarted and strict and started:
        manager.logger.error("Deactivating the controllers that were activated: STRICT switch")
        manager.resource_manager.perform_command_mode_switch(*_modes([], started))
        manager.deactivate_controllers(started)
        started = []
    return unstopped, [spec.name for spec in unstarted], started


def _start(manager: ControllerManager, spec: ControllerSpec, chained: bool) -> bool:
    controller, resources = spec.controller, manager.resource_manager
    chainable = controller if isinstance(controller, ChainableControllerInterface) else None
    if chainable is not None and not chainable.set_chained_mode(chained):
        manager.record_failure(controller, "it rejects the chained mode")
        manager.logger.error(
            f"Got request to turn {'ON' if chained else 'OFF'} chained mode for controller "
            f"'{spec.name}', but controller refused to do it!"
        )
        return False
    try:
        controller.state_interfaces = resources.available_states(spec.required_state_interfaces)
        controller.command_interfaces = resources.claim_command_interfaces(
            spec.required_command_interfaces, spec.name
        )
    except ClaimError as error:
        manager.record_failure(controller, f"{error}")
        manager.logger.error(f"Unable to activate controller '{spec.name}' since {error}.")
        controller.state_interfaces = []
        return False
    if spec.async_update is not None:
        spec.async_update.separate_interfaces()
    if chainable is not None:
        chainable.make_exported_interfaces_available(True)
    outcome = manager.call(controller, controller.on_activate)
    if outcome is CallbackReturn.SUCCESS:
        controller.lifecycle_state = State.ACTIVE
        return True
    manager.logger.error(f"After activating, controller '{spec.name}' is not active.")
    resources.release_command_interfaces(spec.name)
    resources.perform_command_mode_switch([], list(spec.required_command_interfaces))
    if chainable is not None:
        chainable.make_exported_interfaces_available(False)
    controller.command_interfaces = []
    controller.state_interfaces = []
    manager.recover(controller, outcome, State.INACTIVE)
    return False


def start_fallbacks(manager: ControllerManager, failed: Sequence[ControllerSpec]) -> None:
    """Activate failed controllers' fallbacks in place of conflicting ones; called in a cycle."""
    names = list(dict.fromkeys(name for spec in failed for name in spec.fallback_controllers))
    if not names:
        return
    manager.logger.error(f"Activating fallback controllers : [ {' '.join(names)} ]")
    known = (manager.controllers.get(name) for name in names)
    # Since the failed controller's activation, its fallbacks may have changed state or be unloaded.
    starting = [spec for spec in known if spec and spec.lifecycle_state is State.INACTIVE]
    needed = {name for spec in starting for name in spec.required_command_interfaces}
    holding = manager.chains.connected(
        c for c in manager.active_controllers if needed & set(c.required_command_interfaces)
    )
    restarting = manager.chains.chained_mode_changes(manager.active_controllers, starting, holding)
    starting, holding = [*starting, *restarting], [*holding, *restarting]
    manager.active_controllers = tuple(c for c in manager.active_controllers if c not in holding)
    started = _exchange(manager, starting, holding, strict=False)[2]
    _run(manager, started)
