"""``ros2service.api``. Services of the graph, and their classes."""

from typing import Any

from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rosidl_runtime_py import get_service_interfaces
from rosidl_runtime_py.utilities import get_service

from teleopctl.errors import TeleopctlError

__all__ = [
    "get_service_class",
    "get_service_names",
    "get_service_names_and_types",
    "service_type_completer",
]

# Any, here and below: a Node, or a node of ros2cli; a service class.


def get_service_names_and_types(
    *, node: Any, include_hidden_services: bool = False
) -> list[tuple[str, list[str]]]:
    """Return the services of the graph with their types."""
    return [
        (name, types)
        for name, types in node.get_service_names_and_types()
        if include_hidden_services or not topic_or_service_is_hidden(name)
    ]


def get_service_names(*, node: Any, include_hidden_services: bool = False) -> list[str]:
    """Return the names of the services of the graph."""
    found = get_service_names_and_types(node=node, include_hidden_services=include_hidden_services)
    return [name for name, _ in found]


def get_service_class(node: Any, service_name: str, include_hidden_services: bool) -> Any:
    """Return the class of a service of the graph.

    Args:
        node: Node for the queries of the graph.
        service_name: Full name of the service.
        include_hidden_services: Whether to find hidden services.

    Raises:
        RuntimeError: The service is not in the graph, or has several types or an unknown one.
    """
    known = dict(
        get_service_names_and_types(node=node, include_hidden_services=include_hidden_services)
    )
    if service_name not in known:
        raise RuntimeError(f"Cannot find type for '{service_name}'")
    types = known[service_name]
    if len(types) > 1:
        raise RuntimeError(f"More than one type associated with service '{service_name}'")
    try:
        return get_service(types[0])
    except (AttributeError, ModuleNotFoundError, ValueError, TeleopctlError) as error:
        raise RuntimeError(f"The service type '{types[0]}' is invalid") from error


def service_type_completer(**_: object) -> list[str]:
    """Return the names of all service types."""
    return [
        f"{package}/{name}" for package, names in get_service_interfaces().items() for name in names
    ]
