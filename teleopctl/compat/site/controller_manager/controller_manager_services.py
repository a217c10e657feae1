"""``controller_manager.controller_manager_services``: calls of a controller manager's services."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

import rclpy
from controller_manager_msgs import srv
from rcl_interfaces.srv import SetParameters
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter

from teleopctl.control import controller_load_parameters

_LOOKS_EVERY_S = 10.0


_IS_COLORED = sys.stdout.isatty() and "NO_COLOR" not in os.environ


class bcolors:  # noqa: N801 -- spelt so there
    """ANSI escape sequences of colours; empty if standard output is no terminal."""

    MAGENTA = "\033[95m" if _IS_COLORED else ""
    OKBLUE = "\033[94m" if _IS_COLORED else ""
    OKCYAN = "\033[96m" if _IS_COLORED else ""
    OKGREEN = "\033[92m" if _IS_COLORED else ""
    WARNING = "\033[93m" if _IS_COLORED else ""
    FAIL = "\033[91m" if _IS_COLORED else ""
    ENDC = "\033[0m" if _IS_COLORED else ""
    BOLD = "\033[1m" if _IS_COLORED else ""
    UNDERLINE = "\033[4m" if _IS_COLORED else ""


class ServiceNotFoundError(Exception):
    """Raised when a service does not become available in time."""


# Any: requests and responses of whatever service.
def service_caller(
    node: Node,
    service_name: str,
    service_type: Any,
    request: Any,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
    max_attempts: int = 3,
) -> Any:
    """Call a service, and return its response.

    Args:
        node: The node to call it from.
        service_name: Its name; a relative one is in the node's namespace.
        service_type: Its type.
        request: Request message.
        service_timeout: Seconds to wait for it; 0 for as long as it takes.
        call_timeout: Seconds to wait for the response.
        max_attempts: Largest number of calls without a response.

    Raises:
        ServiceNotFoundError: The service did not become available in time.
        RuntimeError: The service does not respond.
    """
    name = node.resolve_service_name(service_name)
    client = node.create_client(service_type, name)
    try:
        while not client.wait_for_service(service_timeout or _LOOKS_EVERY_S):
            if service_timeout:
                raise ServiceNotFoundError(f"Could not contact service {name}")
            node.get_logger().warning(f"Could not contact service {name}")
        for attempt in range(1, max_attempts + 1):
            future = client.call_async(request)
            rclpy.spin_until_future_complete(node, future, timeout_sec=call_timeout)
            if future.done():
                return future.result()
            node.get_logger().warning(
                f"{name} has not responded within {call_timeout} s (attempt {attempt} of "
                f"{max_attempts})"
            )
    finally:
        node.destroy_client(client)
    raise RuntimeError(f"Could not successfully call service {name} after {max_attempts} attempts.")


def list_controllers(
    node: Node,
    controller_manager_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``list_controllers``."""
    name = f"{controller_manager_name}/list_controllers"
    request = srv.ListControllers.Request()
    return service_caller(node, name, srv.ListControllers, request, service_timeout, call_timeout)


def list_controller_types(
    node: Node,
    controller_manager_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``list_controller_types``."""
    kind = srv.ListControllerTypes
    name = f"{controller_manager_name}/list_controller_types"
    return service_caller(node, name, kind, kind.Request(), service_timeout, call_timeout)


def list_hardware_components(
    node: Node,
    controller_manager_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``list_hardware_components``."""
    kind = srv.ListHardwareComponents
    name = f"{controller_manager_name}/list_hardware_components"
    return service_caller(node, name, kind, kind.Request(), service_timeout, call_timeout)


def list_hardware_interfaces(
    node: Node,
    controller_manager_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``list_hardware_interfaces``."""
    kind = srv.ListHardwareInterfaces
    name = f"{controller_manager_name}/list_hardware_interfaces"
    return service_caller(node, name, kind, kind.Request(), service_timeout, call_timeout)


def load_controller(
    node: Node,
    controller_manager_name: str,
    controller_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``load_controller``."""
    name = f"{controller_manager_name}/load_controller"
    request = srv.LoadController.Request(name=controller_name)
    return service_caller(node, name, srv.LoadController, request, service_timeout, call_timeout)


def configure_controller(
    node: Node,
    controller_manager_name: str,
    controller_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``configure_controller``."""
    kind = srv.ConfigureController
    name = f"{controller_manager_name}/configure_controller"
    request = kind.Request(name=controller_name)
    return service_caller(node, name, kind, request, service_timeout, call_timeout)


def cleanup_controller(
    node: Node,
    controller_manager_name: str,
    controller_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``cleanup_controller``."""
    kind = srv.CleanupController
    name = f"{controller_manager_name}/cleanup_controller"
    request = kind.Request(name=controller_name)
    return service_caller(node, name, kind, request, service_timeout, call_timeout)


def unload_controller(
    node: Node,
    controller_manager_name: str,
    controller_name: str,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``unload_controller``."""
    kind = srv.UnloadController
    name = f"{controller_manager_name}/unload_controller"
    request = kind.Request(name=controller_name)
    return service_caller(node, name, kind, request, service_timeout, call_timeout)


def reload_controller_libraries(
    node: Node,
    controller_manager_name: str,
    force_kill: bool,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``reload_controller_libraries``."""
    kind = srv.ReloadControllerLibraries
    name = f"{controller_manager_name}/reload_controller_libraries"
    request = kind.Request(force_kill=force_kill)
    return service_caller(node, name, kind, request, service_timeout, call_timeout)


def set_hardware_component_state(
    node: Node,
    controller_manager_name: str,
    component_name: str,
    lifecyle_state: Any,
    service_timeout: float = 0.0,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``set_hardware_component_state`` with a state of ``lifecycle_msgs``."""
    kind = srv.SetHardwareComponentState
    name = f"{controller_manager_name}/set_hardware_component_state"
    request = kind.Request(name=component_name, target_state=lifecyle_state)
    return service_caller(node, name, kind, request, service_timeout, call_timeout)


def switch_controllers(
    node: Node,
    controller_manager_name: str,
    deactivate_controllers: Sequence[str],
    activate_controllers: Sequence[str],
    strictness: int,
    activate_asap: bool,
    timeout: float,
    call_timeout: float = 10.0,
) -> Any:
    """Call ``switch_controller``; ``timeout`` is that of the switch, in seconds."""
    request = srv.SwitchController.Request(
        activate_controllers=list(activate_controllers),
        deactivate_controllers=list(deactivate_controllers),
        strictness=int(strictness),
        activate_asap=activate_asap,
        timeout=Duration(seconds=timeout).to_msg(),
    )
    name = f"{controller_manager_name}/switch_controller"
    return service_caller(node, name, srv.SwitchController, request, call_timeout=call_timeout)


def get_parameter_from_param_files(
    node: Node,
    controller_name: str,
    namespace: str,
    parameter_files: Sequence[str],
    parameter_name: str,
) -> Any:
    """Return a manager's parameter of a controller from parameter files; None if there is none.

    Args:
        node: Not used; it is there.
        controller_name: The controller's name.
        namespace: Namespace of controller and manager.
        parameter_files: Later ones win.
        parameter_name: Such as ``type``.

    Raises:
        InvalidFileError: A file is missing, or is no parameter file.
    """
    del node
    manager = f"{namespace.rstrip('/')}/controller_manager"
    return controller_load_parameters(controller_name, manager, parameter_files).get(parameter_name)


def set_controller_parameters(
    node: Node,
    controller_manager_name: str,
    controller_name: str,
    parameter_name: str,
    parameter_value: Any,
) -> bool:
    """Set a parameter of a controller at the controller manager; return False if it is rejected."""
    full_name = f"{controller_name}.{parameter_name}"
    request = SetParameters.Request()
    request.parameters = [Parameter(full_name, value=parameter_value).to_parameter_msg()]
    name = f"{controller_manager_name}/set_parameters"
    (result,) = service_caller(node, name, SetParameters, request).results
    if result.successful:
        node.get_logger().info(f"Set '{full_name}' to '{parameter_value}'")
    else:
        node.get_logger().fatal(
            f"Could not set '{full_name}' to '{parameter_value}': {result.reason}"
        )
    return bool(result.successful)


def set_controller_parameters_from_param_files(
    node: Node,
    controller_manager_name: str,
    controller_name: str,
    parameter_files: Sequence[str],
    namespace: str | None = None,
) -> bool:
    """Set a controller's parameter files, and its type if they contain it, at the manager.

    Raises:
        InvalidFileError: A file is missing, or is no parameter file.
    """
    place = (namespace or node.get_namespace()).rstrip("/")
    manager = f"{place}/{controller_manager_name.rpartition('/')[2]}"
    settings = controller_load_parameters(controller_name, manager, parameter_files)
    return all(
        set_controller_parameters(node, controller_manager_name, controller_name, name, value)
        for name, value in settings.items()
    )
