"""Reload of a controller's code beside the running loop, which keeps the old code if that fails.

The new code is imported, initialized and configured in `ControllerReload.prepare`, while the old
instance is updated. `ControllerReload.commit` exchanges the instances between two cycles. The new
instance's first update decides: if it fails, the old one is updated in the same cycle. Then
`ControllerReload.finish` releases the instance that is no longer used.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from types import FrameType
from typing import Any, TypeVar

from teleopctl import plugins
from teleopctl.base.exception_origin import is_user_code, with_origin
from teleopctl.control.chaining import ChainCycleError
from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.controller_spec import ControllerSpec, repeated_name, required_names
from teleopctl.control.controllers.base import ControllerInterface
from teleopctl.control.controllers.chainable import (
    ChainableControllerInterface,
    InvalidExportError,
)
from teleopctl.control.controllers.controller_node import for_successor
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType, State
from teleopctl.control.reloading.plain_state import attributes_set_by, copy_plain_attributes
from teleopctl.control.resource_manager import ClaimError
from teleopctl.errors import BrokenPluginError, UnknownPluginError

T = TypeVar("T")


# Longest wait for the end of the running cycle, in seconds of wall time.
_LONGEST_CYCLE_S = 5.0
_LONGEST_UNDO_WAIT_S = 1.0
# Number of modules that are named in a message.
_MOST_NAMED = 5
_CONFIGURED = (State.INACTIVE, State.ACTIVE)


class ReloadError(Exception):
    """Raised when a controller is not reloaded; the message says why, with file and line.

    Args:
        text: Message of the error.
        file: File that cannot be imported, or None.

    Attributes:
        file: File that cannot be imported, or None.
    """

    def __init__(self, text: str, file: str | None = None) -> None:
        super().__init__(text)
        self.file = file


class ReloadRefusedError(ReloadError):
    """Raised when a reload cannot begin; the message says why."""


class ControllerReload:
    """One reload of a controller: new code beside the old, exchange, first update, release.

    Args:
        manager: Controller manager with the controller.
        name: Name of the controller.

    Attributes:
        name: Name of the controller.
        is_settled: Set when it is decided which instance stays.
        on_settled: Called then; in the control loop if the first update decides.

    Raises:
        ReloadRefusedError: There is no such controller.
    """

    def __init__(self, manager: ControllerManager, name: str) -> None:
        spec = manager.controllers.get(name)
        if spec is None:
            names = ", ".join(manager.controllers)
            loaded = f"loaded are: {names}" if names else "none is loaded"
            raise ReloadRefusedError(f"no controller with this name exists; {loaded}")
        self.name = name
        self.is_settled = threading.Event()
        self.on_settled: Callable[[], object] = _nothing
        self._manager = manager
        self._spec = spec
        self._old = spec.controller
        self._configured = spec.lifecycle_state in _CONFIGURED
        self._new_spec: ControllerSpec | None = None
        self._reloaded: plugins.Reloaded | None = None
        self._problem: str | None = None
        self._undo = ExitStack()
        self._lock = threading.Lock()
        self._abandoned = self._prepared = False
        # Phase of `prepare` in words, and the thread that runs it.
        self._phase = "importing its code"
        self._thread = 0
        self._was_configured = False

    # -- new code beside the old -------------------------------------------------------------------

    def prepare(self) -> None:
        """Import, initialize and configure the new code; not in the control loop.

        Raises:
            ReloadError: That failed, or `abandon` was called meanwhile; nothing has changed.
        """
        self._thread = threading.get_ident()
        try:
            self._reloaded, controller_class = self._import()
            self._check_abandoned()
            self._create(controller_class)
            self._check_interfaces()
            self._check_abandoned()
        except BaseException:
            self._release_new()
            raise

    def abandon(self) -> str | None:
        """Make `prepare` fail; return what it was doing, with the user's line, None if it ended.

        Code that never ends is interrupted by an exception, since it would slow the control loop.
        Code that waits in the system for ever stays there.
        """
        with self._lock:
            if self._prepared:
                return None
            self._abandoned = True
        place = _place_of(self._thread)
        _interrupt(self._thread)
        return self._phase + (f" ({place})" if place else "")

    def _check_abandoned(self) -> None:
        with self._lock:
            if self._abandoned:
                raise ReloadError("it took too long")
            self._prepared = self._new_spec is not None

    def _import(self) -> tuple[plugins.Reloaded, type[ControllerInterface]]:
        kind, type_name = plugins.CONTROLLERS, self._spec.type
        try:
            reloaded = plugins.reload(kind, [type_name], only_changed=True)
            try:
                return reloaded, plugins.load(kind, type_name)
            except (BrokenPluginError, UnknownPluginError):
                reloaded.undo()
                raise
        except (BrokenPluginError, UnknownPluginError) as error:
            near = f" ({error.hint})" if error.hint else ""
            file, _, line = (error.place or "").rpartition(":")
            file = file if line.isdigit() else line
            raise ReloadError(f"{error.message}{near}", file or None) from error

    def _create(self, controller_class: type[ControllerInterface]) -> None:
        """Create the new instance, and configure it if the old one is configured."""
        self._old_view, self._view, params = for_successor(self._old.params)
        self._phase = "its constructor has not returned"
        try:
            new = controller_class(params)
        except (Exception, SystemExit) as error:
            raise ReloadError(f"its constructor raised {with_origin(error)}") from error
        self._new = new
        self._new_spec = replace(self._spec, controller=new)
        self._call(new.on_init)
        if not self._configured:
            return
        if not self._manager.set_rate(new):
            raise ReloadError("its 'update_rate' is invalid")
        self._call(new.on_configure)
        self._was_configured = True
        new.lifecycle_state = State.INACTIVE
        if isinstance(new, ChainableControllerInterface):
            try:
                self._guarded("the export of its interfaces", new.export_interfaces)
            except InvalidExportError as error:
                raise ReloadError(str(error)) from error
        self._new_spec.command_interface_configuration = self._guarded(
            "command_interface_configuration", new.command_interface_configuration
        )
        self._new_spec.state_interface_configuration = self._guarded(
            "state_interface_configuration", new.state_interface_configuration
        )

    def _call(self, function: Callable[[], CallbackReturn | None]) -> None:
        name = function.__name__
        outcome = self._guarded(name, function)
        if outcome not in (None, CallbackReturn.SUCCESS):
            code = function.__code__ if hasattr(function, "__code__") else None
            place = f" ({code.co_filename}:{code.co_firstlineno})" if code else ""
            raise ReloadError(f"{name} returned {outcome.name}{place}")

    def _guarded(self, name: str, function: Callable[[], T]) -> T:
        self._phase = f"{name} has not returned"
        try:
            return function()
        except InvalidExportError:
            raise
        except (Exception, SystemExit) as error:
            raise ReloadError(f"{name} raised {with_origin(error)}") from error

    def _check_interfaces(self) -> None:
        """Raise unless the new instance's interfaces are valid."""
        if not self._configured:
            return
        spec, resources = self._spec_of_new(), self._manager.resource_manager
        spec.required_command_interfaces = required_names(
            spec.command_interface_configuration, resources.command_interfaces
        )
        spec.required_state_interfaces = required_names(
            spec.state_interface_configuration, resources.state_interfaces
        )
        for required in (spec.required_command_interfaces, spec.required_state_interfaces):
            if (problem := repeated_name(required)) is not None:
                raise ReloadError(f"it requires the interface '{problem}' twice")
        for interface in _exported(self._new):
            if resources.component_of(interface.name) is not None:
                raise ReloadError(f"'{interface.name}' is an interface of the hardware")

    def _spec_of_new(self) -> ControllerSpec:
        assert self._new_spec is not None
        return self._new_spec

    # -- exchange ----------------------------------------------------------------------------------

    def commit(self) -> None:
        """Exchange the instances between two cycles.

        Raises:
            ReloadError: The new instance cannot take over; the old one still runs.
        """
        async_update = self._spec.async_update
        if async_update is not None:
            # The control loop does not wait for a running update.
            async_update.pause()
        try:
            self._commit()
        except BaseException:
            if async_update is not None:
                async_update.resume()
            self._release_new()
            raise

    def _commit(self) -> None:
        lock = self._manager.cycle_lock
        if not lock.acquire(timeout=_LONGEST_CYCLE_S):
            raise ReloadError(f"a control cycle has not ended for {_LONGEST_CYCLE_S:g} seconds")
        try:
            with ExitStack() as undo:
                self._exchange(undo)
                self._undo = undo.pop_all()
        finally:
            lock.release()

    def _exchange(self, undo: ExitStack) -> None:
        manager, spec, old, new = self._manager, self._spec, self._old, self._new
        if manager.controllers.get(self.name) is not spec or spec.controller is not old:
            raise ReloadError("it was unloaded meanwhile")
        state = spec.lifecycle_state
        if self._configured is not (state in _CONFIGURED):
            raise ReloadError(f"it has become '{state.label}' meanwhile")
        commands: Sequence[CommandInterface] = old.command_interfaces
        if spec.async_update is not None:
            undo.callback(spec.async_update.interfaces_restorer())
            commands = spec.async_update.shared(commands)
        for handle in commands:
            undo.callback(setattr, handle, "value", handle.value)
        if self._configured:
            self._exchange_exported(undo, active=state is State.ACTIVE)
        self._exchange_spec(undo)
        undo.callback(self._old_view.connect_callbacks)
        if state is State.ACTIVE:
            self._activate(undo)
        self._view.connect_callbacks()
        if state is not State.FINALIZED:
            new.lifecycle_state = state
        if state is State.ACTIVE:
            self._claims = new.command_interfaces
            # An attribute of the instance has precedence over the method of its class.
            new.__dict__["update"] = self._first_update
        else:
            self._settle()

    def _exchange_exported(self, undo: ExitStack, *, active: bool) -> None:
        """Give the exported interfaces of the old instance to the new one, with their values."""
        resources, old, new = self._manager.resource_manager, self._old, self._new
        before, after = _exported(old), _exported(new)
        # A reference and an exported state may have the same name.
        kept = {(type(interface), interface.name): interface for interface in before}
        names, gone = ({interface.name for interface in each} for each in (after, before))
        users = [
            user
            for user in self._manager.chains.users(self._spec)
            if user.lifecycle_state is State.ACTIVE
        ]
        for user in users:
            for name in (*user.required_command_interfaces, *user.required_state_interfaces):
                if name in gone and name not in names:
                    raise ReloadError(f"it no longer exports '{name}', which '{user.name}' uses")
        # The users' handles stay, so the new instance gets the same.
        same = {id(one): kept[key] for one in after if (key := (type(one), one.name)) in kept}
        if isinstance(new, ChainableControllerInterface):
            # Any: the lists have interfaces of two classes.
            exports: list[list[Any]] = [new.reference_interfaces, new.exported_state_interfaces]
            for interfaces in exports:
                interfaces[:] = [same.get(id(one), one) for one in interfaces]
            for attribute, value in list(vars(new).items()):
                if id(value) in same:
                    setattr(new, attribute, same[id(value)])
            for interface in _exported(new):
                interface.available = active
        # Not the mappings of now: other controllers may be loaded before the first update.
        undo.callback(resources.import_interfaces, *_by_kind(old))
        undo.callback(resources.remove_interfaces, *_by_kind(new))
        resources.remove_interfaces(*_by_kind(old))
        resources.import_interfaces(*_by_kind(new))
        if isinstance(new, ChainableControllerInterface):
            chained = isinstance(old, ChainableControllerInterface) and old.in_chained_mode
            if not self._guarded("on_set_chained_mode", lambda: new.set_chained_mode(chained)):
                raise ReloadError(f"it refuses the chained mode ({chained})")

    def _exchange_spec(self, undo: ExitStack) -> None:
        spec, new_spec = self._spec, self._spec_of_new()
        undo.callback(self._sort)
        fields = ["controller"]
        if self._configured:
            fields += [f"{kind}_interface_configuration" for kind in ("command", "state")] + [
                f"required_{kind}_interfaces" for kind in ("command", "state")
            ]
        for attribute in fields:
            undo.callback(setattr, spec, attribute, getattr(spec, attribute))
            setattr(spec, attribute, getattr(new_spec, attribute))
        try:
            self._sort()
        except ChainCycleError as error:
            raise ReloadError(f"it cannot be in a chain of {error}") from error

    def _sort(self) -> None:
        """Bring all controllers into their update order."""
        manager = self._manager
        ordered = manager.chains.in_update_order()
        active = {other.name for other in manager.active_controllers}
        manager.controllers = {other.name: other for other in ordered}
        manager.active_controllers = tuple(other for other in ordered if other.name in active)

    def _activate(self, undo: ExitStack) -> None:
        """Hand over claims, state and goals; the old instance is not deactivated."""
        old, new, spec = self._old, self._new, self._spec
        state = self._guarded("export_state of the running code", old.export_state)
        self._claim(undo)
        resources = self._manager.resource_manager
        try:
            new.state_interfaces = resources.available_states(spec.required_state_interfaces)
        except ClaimError as error:
            raise ReloadError(str(error)) from error
        new.command_interfaces = [
            resources.command_interfaces[name] for name in spec.required_command_interfaces
        ]
        if spec.async_update is not None:
            spec.async_update.separate_interfaces()
        references = [(handle, handle.value) for handle in _exported(new)]
        attributes = attributes_set_by(new, lambda: self._call(new.on_activate))
        # The last references are still valid, though an activation usually resets them.
        for handle, value in references:
            undo.callback(setattr, handle, "value", value)
            handle.value = value
        imports = type(new).import_state is not ControllerInterface.import_state
        if imports and state is not None:
            self._guarded("import_state", lambda: new.import_state(state))
            return
        copy_plain_attributes(old, new, attributes)
        for accept, goal in self._view.active_goals():
            goal.accept_again()
            undo.callback(goal.go_on)
            self._guarded(
                "its callback for accepted goals",
                lambda accept=accept, goal=goal: accept(goal),  # type: ignore[misc]
            )

    def _claim(self, undo: ExitStack) -> None:
        """Claim interfaces that only the new code requires; release those that it does not."""
        resources, name = self._manager.resource_manager, self.name
        held = [handle.name for handle in self._old.command_interfaces]
        added = [each for each in self._spec.required_command_interfaces if each not in held]
        dropped = [each for each in held if each not in self._spec.required_command_interfaces]
        if not added and not dropped:
            return
        if not resources.prepare_command_mode_switch(added, dropped):
            raise ReloadError("the hardware refuses to switch the command interfaces")
        for each in dropped:
            handle = resources.command_interfaces[each]
            undo.callback(setattr, handle, "owner", handle.owner)
            handle.owner = None
        try:
            claimed = resources.claim_command_interfaces(added, name)
        except ClaimError as error:
            raise ReloadError(str(error)) from error
        for handle in claimed:
            undo.callback(setattr, handle, "owner", None)
        undo.callback(resources.perform_command_mode_switch, dropped, added)
        if not resources.perform_command_mode_switch(added, dropped):
            raise ReloadError("the hardware failed to switch the command interfaces")

    # -- first update ------------------------------------------------------------------------------

    def _first_update(self, time_ns: int, period: float) -> ReturnType | None:
        """Run the new instance's first update; if it fails, go back and run the old one's."""
        new = self._new
        del new.__dict__["update"]
        if self._was_deactivated:
            self._settle()
            return new.update(time_ns, period)
        try:
            outcome = new.update(time_ns, period)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - the old code still runs
            self._problem = f"its first update raised {with_origin(error)}"
        else:
            if outcome is not ReturnType.ERROR:
                self._settle()
                return outcome
            self._problem = "its first update returned ERROR"
        if self._spec.async_update is None:
            self._undo.close()
            self._settle()
            return self._old.update(time_ns, period)
        # In a thread of its own, or in lockstep in the cycle; the next cycle triggers the old code.
        with ExitStack() as stack:
            if not self._manager.resource_manager.in_lockstep:
                if not self._manager.cycle_lock.acquire(timeout=_LONGEST_UNDO_WAIT_S):
                    # The cycle waits for this update, to deactivate the controller.
                    self._problem = None
                    self._settle()
                    return ReturnType.ERROR
                stack.callback(self._manager.cycle_lock.release)
            self._undo.close()
        self._settle()
        return ReturnType.OK

    def withdraw(self) -> None:
        """Go back to the old instance, unless the first update has already decided."""
        with self._manager.cycle_lock:
            if not self.is_settled.is_set():
                self._new.__dict__.pop("update", None)
                if not self._was_deactivated:
                    self._problem = "it was reloaded again before its first update"
                    self._undo.close()
                self._settle()

    @property
    def _was_deactivated(self) -> bool:
        """Whether the new instance was deactivated before its first update, so that it stays."""
        return self._new.command_interfaces is not self._claims

    def _settle(self) -> None:
        self.is_settled.set()
        self.on_settled()

    # -- release -----------------------------------------------------------------------------------

    def finish(self) -> str:
        """Release the instance that is no longer used; return what was reloaded, in words.

        Raises:
            ReloadError: The first update failed, and the old code still runs.
        """
        if self._problem is not None:
            self._release_new()
            raise ReloadError(self._problem)
        self._undo.pop_all()
        self._new.__dict__.pop("update", None)
        self._old_view.give_away(self._view)
        self._end(self._old, self._configured)
        self._old_view.close()
        plugins.remember_sources(plugins.CONTROLLERS, self._spec.type)
        modules = self._reloaded.modules if self._reloaded is not None else []
        if len(modules) > _MOST_NAMED:
            return f"{', '.join(modules[:_MOST_NAMED])} and {len(modules) - _MOST_NAMED} others"
        return ", ".join(modules) or "no file has changed"

    def _release_new(self) -> None:
        if self._reloaded is not None:
            self._reloaded.undo()
        if self._new_spec is not None:
            self._end(self._new, self._was_configured)
            self._view.close()

    def _end(self, controller: ControllerInterface, configured: bool) -> None:
        """Call an unused instance's callbacks as for unloading, and log what they raise."""
        # As after a deactivation: code that still runs somewhere cannot command the robot.
        controller.command_interfaces, controller.state_interfaces = [], []
        functions: Sequence[Callable[[], object]] = (
            *((controller.on_cleanup,) if configured else ()),
            controller.on_shutdown,
        )
        for function in functions:
            try:
                function()
            except (Exception, SystemExit) as error:  # noqa: BLE001 - reported, as for unloading
                self._manager.logger.warning(
                    f"Controller '{self.name}': the code that is not used any more raised in "
                    f"{function.__name__}: {with_origin(error)}"
                )


def _nothing() -> None:
    pass


def _exported(controller: ControllerInterface) -> list[StateInterface]:
    if not isinstance(controller, ChainableControllerInterface):
        return []
    return [*controller.reference_interfaces, *controller.exported_state_interfaces]


def _by_kind(
    controller: ControllerInterface,
) -> tuple[list[StateInterface], list[CommandInterface]]:
    """Return the exported states and references of a controller."""
    if not isinstance(controller, ChainableControllerInterface):
        return [], []
    return controller.exported_state_interfaces, controller.reference_interfaces


def _interrupt(thread: int) -> None:
    """Raise SystemExit in another thread, as soon as it runs Python code."""
    import ctypes

    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(SystemExit))


def _place_of(thread: int) -> str | None:
    """Return the user's line that a thread is at, as ``file:line``; None if it has none."""
    frame: FrameType | None = sys._current_frames().get(thread)  # noqa: SLF001 - as documented
    while frame is not None:
        if is_user_code(frame.f_code.co_filename):
            return f"{frame.f_code.co_filename}:{frame.f_lineno}"
        frame = frame.f_back
    return None
