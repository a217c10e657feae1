"""Parameter services and parameter events of a node.

Source: rclpy's parameter services, also for the order of declaration, which determines the entity
IDs of a node. For an unknown name, get, get types and describe respond with an empty list.
"""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service, snake_case
from teleopctl.node.parameters.store import ParameterStore, result
from teleopctl.node.values.exceptions import ParameterNotDeclaredException
from teleopctl.node.values.parameter import Parameter, ParameterType
from teleopctl.node.values.qos import qos_profile_parameters

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from rcl_interfaces.msg import ParameterEvent

    from teleopctl.node.node_endpoints import NodeEndpoints


class ParameterService:
    """Servers of a node's six parameter services."""

    def __init__(self, node: NodeEndpoints, store: ParameterStore) -> None:
        self._node = node
        self._store = store
        handlers: tuple[tuple[str, Callable[[Any, Any], Any]], ...] = (
            ("DescribeParameters", self._describe),
            ("GetParameters", self._get),
            ("GetParameterTypes", self._get_types),
            ("ListParameters", self._list),
            ("SetParameters", self._set),
            ("SetParametersAtomically", self._set_atomically),
        )
        for type_, handler in handlers:
            node.create_service(
                get_service(f"rcl_interfaces/srv/{type_}"),
                f"~/{snake_case(type_)}",
                handler,
                qos_profile=qos_profile_parameters,
            )

    def _describe(self, request: Any, response: Any) -> Any:
        try:
            response.descriptors = [self._descriptor(name) for name in request.names]
        except ParameterNotDeclaredException as error:
            self._node.get_logger().warning(f"Failed to describe parameters: {error.message}")
        return response

    def _descriptor(self, name: str) -> Any:
        descriptor = self._store.descriptor(name)
        parameter = self._store.find(name)
        # A parameter declared by type keeps the descriptor's type while it has no value.
        if parameter is not None and parameter.type_ != ParameterType.NOT_SET:
            descriptor.type = int(parameter.type_)
        return descriptor

    def _parameters(
        self, names: list[str], what: str, *, with_value: bool = False
    ) -> list[Parameter]:
        found: list[Parameter] = []
        for name in names:
            parameter = self._store.find(name)
            if parameter is None and not self._store.allow_undeclared:
                self._node.get_logger().warning(
                    f"Failed to get {what}: Invalid access to undeclared parameter(s): ['{name}']"
                )
                return []
            if with_value and parameter is not None and self._store.is_uninitialized(name):
                self._node.get_logger().warning(
                    f"Failed to get {what}: The parameter '{name}' is not initialized"
                )
                return []
            found.append(parameter or Parameter(name))
        return found

    def _get(self, request: Any, response: Any) -> Any:
        parameters = self._parameters(request.names, "parameters", with_value=True)
        response.values = [parameter.get_parameter_value() for parameter in parameters]
        return response

    def _get_types(self, request: Any, response: Any) -> Any:
        parameters = self._parameters(request.names, "parameter types")
        response.types = [int(parameter.type_) for parameter in parameters]
        return response

    def _list(self, request: Any, response: Any) -> Any:
        names, prefixes = self._store.list_names(request.prefixes, request.depth)
        response.result.names = names
        response.result.prefixes = prefixes
        return response

    def _set(self, request: Any, response: Any) -> Any:
        results = []
        for message in request.parameters:
            parameter, refusal = _read(message)
            results.append(
                refusal if parameter is None else self._store.set_atomically([parameter])
            )
        response.results = results
        return response

    def _set_atomically(self, request: Any, response: Any) -> Any:
        parameters = []
        for message in request.parameters:
            parameter, refusal = _read(message)
            if parameter is None:
                response.result = refusal
                return response
            parameters.append(parameter)
        response.result = self._store.set_atomically(parameters)
        return response


def _read(message: Any) -> tuple[Parameter | None, Any]:
    """Return the parameter of a message and None; None and a failed result if it is malformed."""
    try:
        return Parameter.from_parameter_msg(message), None
    except (ValueError, TypeError, TeleopctlError) as error:
        return None, result(False, f"parameter '{message.name}' is malformed: {error}")


def parameter_event(
    node_name: str,
    stamp: Time,
    new: list[Parameter],
    changed: list[Parameter],
    deleted: list[Parameter],
) -> ParameterEvent:
    """Return the ``ParameterEvent`` message for new, changed and deleted parameters."""
    message: type[ParameterEvent] = get_message("rcl_interfaces/msg/ParameterEvent")
    return message(
        stamp=stamp,
        node=node_name,
        new_parameters=[parameter.to_parameter_msg() for parameter in new],
        changed_parameters=[parameter.to_parameter_msg() for parameter in changed],
        deleted_parameters=[
            Parameter(parameter.name, ParameterType.NOT_SET).to_parameter_msg()
            for parameter in deleted
        ],
    )
