"""``ros2param.api``. Parameters of other nodes."""

import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import rclpy
from rclpy.node import Node
from rclpy.parameter import (
    Parameter,
    get_parameter_value,
    parameter_dict_from_yaml_file,
    parameter_value_to_python,
)
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterValue

__all__ = [
    "call_describe_parameters",
    "call_get_parameters",
    "call_list_parameters",
    "call_set_parameters",
    "get_parameter_type_string",
    "get_parameter_value",
    "get_value",
    "load_parameter_file",
]

_SERVICES_S = 5.0
_TYPES = {
    Parameter.Type.BOOL: "boolean",
    Parameter.Type.INTEGER: "integer",
    Parameter.Type.DOUBLE: "double",
    Parameter.Type.STRING: "string",
    Parameter.Type.BYTE_ARRAY: "byte array",
    Parameter.Type.BOOL_ARRAY: "boolean array",
    Parameter.Type.INTEGER_ARRAY: "integer array",
    Parameter.Type.DOUBLE_ARRAY: "double array",
    Parameter.Type.STRING_ARRAY: "string array",
    Parameter.Type.NOT_SET: "not set",
}

# Any, here and below: responses of services, and values of parameters.


def get_value(*, parameter_value: "ParameterValue") -> Any:
    """Return the Python value that a message holds; None for one of an unknown type."""
    try:
        return parameter_value_to_python(parameter_value)
    except RuntimeError as error:
        print(f"Runtime error {error} raised")  # noqa: T201 -- ros2param does
        return None


def get_parameter_type_string(parameter_type: int) -> str:
    """Return the name of a parameter's type, such as ``double array``."""
    return _TYPES[Parameter.Type(parameter_type)]


def call_describe_parameters(
    *, node: Node, node_name: str, parameter_names: Sequence[str] | None = None
) -> Any:
    """Return the response with the descriptors of a node's parameters.

    Raises:
        RuntimeError: The node does not offer the services, or does not respond.
    """
    names = parameter_names or []
    return _response(node, node_name, lambda client: client.describe_parameters(names))


def call_get_parameters(*, node: Node, node_name: str, parameter_names: Sequence[str]) -> Any:
    """Return the response with the values of a node's parameters.

    Raises:
        RuntimeError: The node does not offer the services, or does not respond.
    """
    return _response(node, node_name, lambda client: client.get_parameters(parameter_names))


def call_set_parameters(*, node: Node, node_name: str, parameters: Sequence[Any]) -> Any:
    """Set parameters of a node; return the response with a result for each.

    Raises:
        RuntimeError: The node does not offer the services, or does not respond.
    """
    return _response(node, node_name, lambda client: client.set_parameters(parameters))


def call_list_parameters(
    *, node: Node, node_name: str, prefixes: list[str] | None = None
) -> Future[Any] | None:
    """Return the future, which has ended, with the names of a node's parameters.

    Returns:
        None if the node does not offer the services within 5 s.
    """
    client = AsyncParameterClient(node, node_name)
    if not client.wait_for_services(timeout_sec=_SERVICES_S):
        return None
    future = client.list_parameters(prefixes=prefixes)
    _wait(node, future)
    return future


def load_parameter_file(
    *, node: Node, node_name: str, parameter_file: str, use_wildcard: bool
) -> None:
    """Set the parameters of a file at a node, and print the result of each.

    Raises:
        RuntimeError: The node does not offer the services, does not respond, or the file is none.
    """
    parameters = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
    response = _response(
        node, node_name, lambda client: client.load_parameter_file(parameter_file, use_wildcard)
    )
    for name, result in zip(parameters, response.results, strict=True):
        outcome = "successful" if result.successful else "failed"
        reason = f": {result.reason}" if result.reason else ""
        stream = sys.stdout if result.successful else sys.stderr
        print(f"Set parameter {name} {outcome}{reason}", file=stream)


def _response(
    node: Node, node_name: str, request: Callable[[AsyncParameterClient], Future[Any]]
) -> Any:
    client = AsyncParameterClient(node, node_name)
    if not client.wait_for_services(timeout_sec=_SERVICES_S):
        raise RuntimeError(
            f"Wait for service timed out waiting for parameter services for node {node_name}"
        )
    future = request(client)
    _wait(node, future)
    response = future.result()
    if response is None:
        raise RuntimeError(
            f"Exception while calling service of node {node_name}: {future.exception()}"
        )
    return response


def _wait(node: Node, future: Future[Any]) -> None:
    """Wait for a response; a node that is spun already, by a thread or around this call, is not."""
    executor = getattr(node, "executor", None)
    if executor is not None and executor.is_spinning:
        future.wait()
    else:
        rclpy.spin_until_future_complete(node, future)
