"""Services of the controller manager, of types in controller_manager_msgs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from teleopctl import plugins
from teleopctl.control.controller_manager import LONGEST_CYCLE_S, ControllerManager
from teleopctl.control.controller_spec import ControllerSpec
from teleopctl.control.controllers.base import ControllerInterface
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.hardware_component import HardwareComponent
from teleopctl.control.lifecycle import State
from teleopctl.control.manager_log import NOT_RELOADED
from teleopctl.control.reloading.service import ReloadService
from teleopctl.control.switching import Strictness, SwitchRequest, switch_controller
from teleopctl.errors import BrokenPluginError, RefusedError, UnknownPluginError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message, get_service, to_nanoseconds

if TYPE_CHECKING:
    from teleopctl.node import Node, Service

# Any: message classes are generated at run time from definitions.


def controller_state(manager: ControllerManager, spec: ControllerSpec) -> Any:
    """Return a controller's state as a controller_manager_msgs/ControllerState message."""
    configured = spec.lifecycle_state in (State.INACTIVE, State.ACTIVE)
    commands = list(spec.required_command_interfaces)
    # Any: message classes are generated at run time.
    chain_connections: Any = get_message("controller_manager_msgs/msg/ChainConnection")
    controller = spec.controller
    chainable = controller if isinstance(controller, ChainableControllerInterface) else None
    return get_message("controller_manager_msgs/msg/ControllerState")(
        name=spec.name,
        state=spec.lifecycle_state.label,
        type=spec.type,
        is_async=spec.async_update is not None,
        update_rate=round(spec.controller.update_rate if configured else manager.update_rate),
        claimed_interfaces=commands if spec.lifecycle_state is State.ACTIVE else [],
        required_command_interfaces=commands,
        required_state_interfaces=list(spec.required_state_interfaces),
        is_chainable=chainable is not None,
        is_chained=chainable is not None and chainable.in_chained_mode,
        exported_state_interfaces=_exported_names(chainable.exported_state_interfaces)
        if chainable
        else [],
        reference_interfaces=_exported_names(chainable.reference_interfaces) if chainable else [],
        chain_connections=[
            chain_connections(name=name, reference_interfaces=references)
            for name, references in manager.chains.chain_connections(spec).items()
        ],
    )


def _exported_names(interfaces: Iterable[StateInterface]) -> list[str]:
    """Return the names of exported interfaces without the controller's name."""
    return [interface.name.partition("/")[2] for interface in interfaces]


def hardware_interface(interface: StateInterface) -> Any:
    """Return an interface as a controller_manager_msgs/HardwareInterface message."""
    return get_message("controller_manager_msgs/msg/HardwareInterface")(
        name=interface.name,
        data_type=interface.data_type,
        is_available=interface.available,
        is_claimed=isinstance(interface, CommandInterface) and interface.claimed,
    )


def lifecycle_state_message(state: State) -> Any:
    """Return a lifecycle state as a lifecycle_msgs/State message."""
    return get_message("lifecycle_msgs/msg/State")(id=int(state), label=state.label)


def hardware_component_state(component: HardwareComponent) -> Any:
    """Return a hardware component as a HardwareComponentState message."""
    info = component.hardware.info
    message = get_message("controller_manager_msgs/msg/HardwareComponentState")(
        name=component.name,
        type=info.type,
        is_async=component.is_async,
        rw_rate=component.rw_rate,
        plugin_name=info.hardware_plugin_name,
        state=lifecycle_state_message(component.lifecycle_state),
        command_interfaces=[
            hardware_interface(command) for command in component.command_interfaces
        ],
        state_interfaces=[hardware_interface(state) for state in component.state_interfaces],
    )
    if hasattr(message, "class_type"):  # Jazzy has the plug-in's name twice
        message.class_type = info.hardware_plugin_name
    return message


class ControllerManagerServices:
    """Service servers ``~/list_controllers``, ``~/load_controller`` and so on of a manager.

    ``~/switch_controller`` is offered by `offer_switching`.

    Args:
        node: Node of the controller manager.
        manager: Controller manager that the services call.
    """

    def __init__(self, node: Node, manager: ControllerManager) -> None:
        self._manager = manager
        services: dict[str, tuple[str, Callable[[Any, Any], Any]]] = {
            "list_controllers": ("ListControllers", self._list_controllers),
            "list_controller_types": ("ListControllerTypes", self._list_controller_types),
            "list_hardware_components": ("ListHardwareComponents", self._list_components),
            "list_hardware_interfaces": ("ListHardwareInterfaces", self._list_interfaces),
            "load_controller": ("LoadController", self._by_name(manager.load_controller)),
            "configure_controller": (
                "ConfigureController",
                self._by_name(manager.configure_controller),
            ),
            "cleanup_controller": ("CleanupController", self._by_name(manager.cleanup_controller)),
            "unload_controller": ("UnloadController", self._by_name(manager.unload_controller)),
            "set_hardware_component_state": (
                "SetHardwareComponentState",
                self._set_component_state,
            ),
            "reload_controller_libraries": ("ReloadControllerLibraries", self._reload),
        }
        self._node = node
        self._services = [self._offer(name, *service) for name, service in services.items()]
        self._reload_service = ReloadService(node, manager)

    def offer_switching(self) -> None:
        """Offer ``~/switch_controller``, once controllers can be activated."""
        self._services.append(self._offer("switch_controller", "SwitchController", self._switch))

    def _offer(
        self, name: str, type_name: str, callback: Callable[[Any, Any], Any]
    ) -> Service[Any, Any]:
        return self._node.create_service(
            get_service(f"controller_manager_msgs/srv/{type_name}"),
            f"~/{name}",
            self._guarded(name, callback),
        )

    def _guarded(self, name: str, serve: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """Return a callback that logs exceptions and responds with a failure instead of raising."""

        def answer(request: Any, response: Any) -> Any:
            try:
                return serve(request, response)
            except Exception as error:  # noqa: BLE001 - plug-ins and parameters of users
                text = f"Service '{name}' failed: {type(error).__name__}: {error}"
                self._manager.logger.error(text)
                if hasattr(response, "message"):
                    response.message = text
                return response

        return answer

    @staticmethod
    def _by_name(operation: Callable[[str], bool]) -> Callable[[Any, Any], Any]:
        def serve(request: Any, response: Any) -> Any:
            response.ok = operation(request.name)
            return response

        return serve

    def _list_controllers(self, request: Any, response: Any) -> Any:
        del request
        response.controller = [
            controller_state(self._manager, spec)
            for spec in list(self._manager.controllers.values())
        ]
        return response

    def _list_controller_types(self, request: Any, response: Any) -> Any:
        del request
        names = sorted(plugins.available(plugins.CONTROLLERS))
        response.types = names
        response.base_classes = [_base_class(name) for name in names]
        return response

    def _list_components(self, request: Any, response: Any) -> Any:
        del request
        response.component = [
            hardware_component_state(component)
            for component in self._manager.resource_manager.components.values()
        ]
        return response

    def _list_interfaces(self, request: Any, response: Any) -> Any:
        del request
        resources = self._manager.resource_manager
        response.command_interfaces = [
            hardware_interface(command)
            for _, command in sorted(resources.command_interfaces.items())
        ]
        response.state_interfaces = [
            hardware_interface(state) for _, state in sorted(resources.state_interfaces.items())
        ]
        return response

    def _switch(self, request: Any, response: Any) -> Any:
        try:
            strictness = Strictness(request.strictness)
        except ValueError:
            strictness = Strictness.DEFAULT
        if strictness is Strictness.DEFAULT:
            configured = self._manager.node.parameter("defaults.switch_controller.strictness")
            strictness = Strictness.STRICT if configured == "strict" else Strictness.BEST_EFFORT
        elif strictness in (Strictness.AUTO, Strictness.FORCE_AUTO):
            self._manager.logger.warning(
                f"Controller Manager: {strictness.name} is not currently implemented. Defaulting "
                "to BEST_EFFORT"
            )
            strictness = Strictness.BEST_EFFORT
        timeout_s = to_nanoseconds(request.timeout) / NANOSECONDS_PER_SECOND
        response.ok, response.message = switch_controller(
            self._manager,
            SwitchRequest(
                list(request.activate_controllers),
                list(request.deactivate_controllers),
                strictness,
                bool(request.activate_asap),
                timeout_s if timeout_s > 0.0 else SwitchRequest.timeout_s,
            ),
        )
        return response

    def _set_component_state(self, request: Any, response: Any) -> Any:
        manager = self._manager
        component = manager.resource_manager.components.get(request.name)
        target = _target_state(request.target_state)
        if component is None or target is None:
            what = "component" if component is None else "target state"
            manager.logger.error(
                f"hardware component with name '{request.name}' or its {what} does not exist"
            )
            response.ok = False
            return response
        # The control loop does not wait for a slow read.
        component.pause()
        try:
            if not manager.cycle_lock.acquire(timeout=LONGEST_CYCLE_S):
                manager.logger.error(
                    f"The state of hardware component '{request.name}' was not changed: the "
                    f"control cycle has not ended within {LONGEST_CYCLE_S:g} s"
                )
                response.ok = False
                return response
            try:
                if target is not State.ACTIVE:
                    self._stop_users(component, only_commands=target is State.INACTIVE)
                response.ok = component.change_state(target)
            finally:
                manager.cycle_lock.release()
        finally:
            component.resume()
        response.state = lifecycle_state_message(component.lifecycle_state)
        manager.node.publish_activity()
        return response

    def _stop_users(self, component: HardwareComponent, *, only_commands: bool) -> None:
        """Deactivate the controllers that use a component, before it leaves its state."""
        manager = self._manager
        users = manager.chains.connected(manager.users_of(component, only_commands=only_commands))
        if users:
            manager.logger.warning(
                f"Deactivating the controllers that use hardware '{component.name}': "
                f"[ {' '.join(spec.name for spec in users)} ]"
            )
            manager.stop_controllers(users)

    def _reload(self, request: Any, response: Any) -> Any:
        manager = self._manager
        try:
            _reload_controller_libraries(manager, force_kill=bool(request.force_kill))
        except RefusedError as refusal:
            manager.logger.error(f"{NOT_RELOADED} {refusal.message}")
            response.ok = False
        else:
            response.ok = True
        return response


def _reload_controller_libraries(manager: ControllerManager, *, force_kill: bool) -> None:
    """Import the code of all controllers again, and unload all controllers.

    The code is imported first: if that fails, no controller is stopped or unloaded.

    Raises:
        RefusedError: A controller is active without ``force_kill``, cannot be stopped or unloaded,
            or its code cannot be imported.
    """
    active = [spec.name for spec in manager.active_controllers]
    if active and not force_kill:
        raise RefusedError(f"there are still {len(active)} active controllers: {', '.join(active)}")
    try:
        read_again = plugins.reload(plugins.CONTROLLERS, manager.loaded_types).modules
    except BrokenPluginError as error:
        raise RefusedError(f"of {error.message}") from error
    if active:
        manager.logger.info("Controller manager: Stopping all active controllers")
        stopped, reason = switch_controller(
            manager, SwitchRequest([], active, Strictness.BEST_EFFORT)
        )
        if not stopped:
            raise RefusedError(f"failed to stop active controllers: {reason}")
    for name in list(manager.controllers):
        if not manager.unload_controller(name):
            raise RefusedError(f"failed to unload controller '{name}'")
    if read_again:
        manager.logger.info(f"Modules that were read again: {', '.join(read_again)}")


def _base_class(type_name: str) -> str:
    """Return the class of ros2_control that corresponds to a controller type's base class."""
    try:
        found: type[ControllerInterface] = plugins.load(plugins.CONTROLLERS, type_name)
    except (BrokenPluginError, UnknownPluginError):
        return ControllerInterface.base_class
    return found.base_class


def _target_state(message: Any) -> State | None:
    """Return the state that a lifecycle_msgs/State names by id or by label, or None."""
    for state in (State.UNCONFIGURED, State.INACTIVE, State.ACTIVE, State.FINALIZED):
        if message.id == state or (not message.id and message.label == state.label):
            return state
    return None
