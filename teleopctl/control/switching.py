"""Switching: some controllers stop and others start, between two control cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from teleopctl.control.controller_manager import ControllerManager, Loaded
from teleopctl.control.lifecycle import CallbackReturn, State
from teleopctl.control.resource_manager import ClaimError


class Strictness(IntEnum):
    """What a request does about controllers that cannot be switched."""

    DEFAULT = 0
    BEST_EFFORT = 1
    STRICT = 2
    AUTO = 3
    FORCE_AUTO = 4


@dataclass(frozen=True)
class SwitchRequest:
    """Which controllers to stop and to start.

    Attributes:
        activate: Names of controllers to start.
        deactivate: Names of controllers to stop.
        strictness: What to do about those that cannot be switched.
        asap: Whether the switch happens in one go, so that the loop waits for it; otherwise other
            controllers go on being updated meanwhile.
        timeout_s: Longest wait for the running cycle to end, s of wall time.
    """

    activate: Sequence[str]
    deactivate: Sequence[str]
    strictness: Strictness = Strictness.STRICT
    asap: bool = True
    timeout_s: float = 1.0


class _Refused(Exception):
    """The request cannot be carried out."""


NOT_INITIALIZED = (
    "Resource Manager is not initialized yet! Please provide robot description on "
    "'robot_description' topic before trying to switch controllers."
)


def switch(manager: ControllerManager, request: SwitchRequest) -> tuple[bool, str]:
    """Carry a request out.

    Args:
        manager: The controller manager.
        request: What to switch.

    Returns:
        Whether it succeeded, and a message for the person who asked.
    """
    log = manager.logger
    if not manager.resources.loaded:
        log.error(NOT_INITIALIZED)
        return False, NOT_INITIALIZED
    strict = request.strictness is Strictness.STRICT
    try:
        activate = _known(manager, request.activate, "activate", strict=strict)
        deactivate = _known(manager, request.deactivate, "deactivate", strict=strict)
        stopping = [
            loaded
            for loaded in deactivate
            if _accept(manager, _deactivation_problem(loaded), strict=strict)
        ]
        starting = [
            loaded
            for loaded in activate
            if _accept(manager, _activation_problem(manager, loaded, stopping), strict=strict)
        ]
        for loaded in starting:
            manager.refresh_states(loaded)
        if not starting and not stopping:
            text = (
                "After checking the controllers, no controllers need to be activated or "
                "deactivated."
            )
            log.info(text)
            return True, text
        _check_interfaces(manager, starting, stopping)
        _check_hardware(manager, starting, stopping)
    except _Refused as refusal:
        return False, str(refusal)
    return _perform(manager, starting, stopping, request)


def _known(
    manager: ControllerManager, names: Sequence[str], verb: str, *, strict: bool
) -> list[Loaded]:
    known: list[Loaded] = []
    problems = []
    for name in names:
        loaded = manager.controllers.get(name)
        if loaded is None:
            problems.append(
                f"Could not {verb} controller with name '{name}' because no controller with "
                "this name exists"
            )
            manager.logger.error(problems[-1])
        elif loaded not in known:
            known.append(loaded)
    if problems and (strict or not known):
        raise _Refused("\n".join(problems))
    return known


def _accept(manager: ControllerManager, problem: str | None, *, strict: bool) -> bool:
    """Whether a controller takes part; a problem aborts a strict request."""
    if problem is None:
        return True
    if strict:
        manager.logger.error(problem)
        manager.logger.error("Aborting, no controller is switched! (::STRICT switch)")
        raise _Refused(f"{problem}\nAborting, no controller is switched! (::STRICT switch)")
    manager.logger.warning(problem)
    return False


def _deactivation_problem(loaded: Loaded) -> str | None:
    if loaded.state is State.ACTIVE:
        return None
    return f"Controller with name '{loaded.name}' can not be deactivated since it is not active."


def _activation_problem(
    manager: ControllerManager, loaded: Loaded, stopping: Sequence[Loaded]
) -> str | None:
    name = loaded.name
    if loaded.state is State.UNCONFIGURED:
        return (
            f"Controller with name '{name}' is in 'unconfigured' state. The controller needs to "
            "be configured to be in 'inactive' state before it can be checked and activated."
        )
    if loaded.state is State.ACTIVE and loaded not in stopping:
        return f"Controller with name '{name}' is already active."
    if loaded.state not in (State.INACTIVE, State.ACTIVE):
        return f"Controller with name '{name}' is in '{loaded.state.label}' state."
    for fallback in loaded.fallbacks:
        other = manager.controllers.get(fallback)
        if other is None or other.state is not State.INACTIVE:
            state = "not loaded" if other is None else f"in '{other.state.label}' state"
            return (
                f"Controller with name '{name}' cannot be activated, as its fallback controller "
                f"'{fallback}' is {state}."
            )
    return None


def _check_interfaces(
    manager: ControllerManager, starting: Sequence[Loaded], stopping: Sequence[Loaded]
) -> None:
    """Every interface must exist, be available and be free once the others have stopped."""
    freed = {loaded.name for loaded in stopping}
    wanted: dict[str, str] = {}
    resources = manager.resources
    inactive_is_enough = bool(
        manager.host.parameter("defaults.allow_controller_activation_with_inactive_hardware")
    )

    def refuse(name: str, reason: str) -> None:
        text = f"Unable to activate controller '{name}' since {reason}"
        manager.logger.error(text)
        raise _Refused(text)

    for loaded in starting:
        for interface in loaded.command_names:
            command = resources.commands.get(interface)
            label = f"the command interface '{interface}'"
            component = resources.component_of(interface)
            if command is None or component is None or not command.available:
                refuse(loaded.name, f"{label} is not available.")
                return
            if component.state is not State.ACTIVE and not inactive_is_enough:
                refuse(
                    loaded.name,
                    f"the hardware component '{component.name}' of {label} is in "
                    f"'{component.state.label}' state.",
                )
            if command.owner is not None and command.owner not in freed:
                refuse(
                    loaded.name,
                    f"{label} is currently claimed by another controller. It is held by "
                    f"'{command.owner}': deactivate that one in the same request.",
                )
            if interface in wanted:
                refuse(
                    loaded.name,
                    f"{label} will be used by another controller that is being activated: "
                    f"'{wanted[interface]}'.",
                )
            wanted[interface] = loaded.name
        for interface in loaded.state_names:
            state = resources.states.get(interface)
            if state is None or not state.available:
                refuse(loaded.name, f"the state interface '{interface}' is not available.")


def _modes(starting: Sequence[Loaded], stopping: Sequence[Loaded]) -> tuple[list[str], list[str]]:
    return (
        [name for loaded in starting for name in loaded.command_names],
        [name for loaded in stopping for name in loaded.command_names],
    )


def _check_hardware(
    manager: ControllerManager, starting: Sequence[Loaded], stopping: Sequence[Loaded]
) -> None:
    if not manager.resources.switch_mode(*_modes(starting, stopping), perform=False):
        text = "Could not switch controllers since prepare command mode switch was rejected."
        manager.logger.error(text)
        raise _Refused(text)


def _perform(
    manager: ControllerManager,
    starting: Sequence[Loaded],
    stopping: Sequence[Loaded],
    request: SwitchRequest,
) -> tuple[bool, str]:
    log = manager.logger
    if stopping:
        log.info(f"Deactivating controllers: [ {' '.join(c.name for c in stopping)} ]")
    if starting:
        log.info(f"Activating controllers: [ {' '.join(c.name for c in starting)} ]")
    strict = request.strictness is Strictness.STRICT
    if not manager.cycle_lock.acquire(timeout=request.timeout_s):
        # A cycle hangs, in a plug-in most likely.
        text = f"Switch controller timed out after {request.timeout_s:g} seconds!"
        log.error(text)
        return False, text
    try:
        manager.running = tuple(c for c in manager.running if c not in stopping)
        if request.asap:
            unstopped, unstarted, started = _exchange(manager, starting, stopping, strict=strict)
            _run(manager, started)
    finally:
        manager.cycle_lock.release()
    if not request.asap:
        unstopped, unstarted, started = _exchange(manager, starting, stopping, strict=strict)
        with manager.cycle_lock:
            _run(manager, started)
    manager.host.changed()
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
    log.error(message)
    return False, message


def _run(manager: ControllerManager, started: Sequence[Loaded]) -> None:
    """Hand controllers to the loop, in the order in which they were loaded."""
    for loaded in started:
        loaded.last_update_ns = None
    chosen = {*(c.name for c in manager.running), *(c.name for c in started)}
    manager.running = tuple(c for c in manager.controllers.values() if c.name in chosen)


def _exchange(
    manager: ControllerManager,
    starting: Sequence[Loaded],
    stopping: Sequence[Loaded],
    *,
    strict: bool,
) -> tuple[list[str], list[str], list[Loaded]]:
    """Stop and start; returns who could not be stopped, who could not be started, who runs.

    The loop no longer updates those that stop, and does not yet update those that start.
    """
    if not manager.resources.switch_mode(*_modes(starting, stopping), perform=True):
        manager.logger.error("Error while performing mode switch.")
        manager.stop(stopping)
        return [], [c.name for c in starting], []
    unstopped = manager.stop(stopping)
    started: list[Loaded] = []
    unstarted: list[Loaded] = []
    for loaded in starting:
        (started if _start(manager, loaded) else unstarted).append(loaded)
    if unstarted and strict and started:
        manager.logger.error("Deactivating the controllers that were activated: STRICT switch")
        manager.resources.switch_mode(*_modes([], started), perform=True)
        manager.stop(started)
        started = []
    return unstopped, [loaded.name for loaded in unstarted], started


def _start(manager: ControllerManager, loaded: Loaded) -> bool:
    controller, resources = loaded.controller, manager.resources
    try:
        controller.command_interfaces = resources.claim(loaded.command_names, loaded.name)
    except ClaimError as error:
        manager.logger.error(f"Unable to activate controller '{loaded.name}' since {error}.")
        return False
    controller.state_interfaces = [resources.states[name] for name in loaded.state_names]
    outcome = manager.call(controller, controller.on_activate)
    if outcome is CallbackReturn.SUCCESS:
        controller.state = State.ACTIVE
        return True
    manager.logger.error(f"After activating, controller '{loaded.name}' is not active.")
    resources.release(loaded.name)
    resources.switch_mode([], list(loaded.command_names), perform=True)
    controller.command_interfaces = []
    controller.state_interfaces = []
    manager.recover(controller, outcome, State.INACTIVE)
    return False


def start_fallbacks(manager: ControllerManager, failed: Sequence[Loaded]) -> None:
    """Start the fallback controllers of those that failed; called by the loop inside a cycle."""
    names = list(dict.fromkeys(name for loaded in failed for name in loaded.fallbacks))
    if not names:
        return
    manager.logger.error(f"Activating fallback controllers : [ {' '.join(names)} ]")
    known = (manager.controllers.get(name) for name in names)
    # Since the activation somebody may have started, cleaned up or unloaded one.
    starting = [loaded for loaded in known if loaded and loaded.state is State.INACTIVE]
    needed = {name for loaded in starting for name in loaded.command_names}
    holding = [c for c in manager.running if needed & set(c.command_names)]
    manager.running = tuple(c for c in manager.running if c not in holding)
    started = _exchange(manager, starting, holding, strict=False)[2]
    _run(manager, started)
