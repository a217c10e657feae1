"""Clients of other nodes' parameter services, as ``rclpy.parameter_client``."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Any, TypeAlias
from teleopctl.interfaces import ResponseT, get_message, get_service, snake_case
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.qos import QoSProfile, qos_profile_services_default
from teleopctl.wire import responses_of_nodes

if TYPE_CHECKING:
    from pathlib import Path

    from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterEvent
    from rcl_interfaces.srv import (
        DescribeParameters,
        GetParameters,
        GetParameterTypes,
        ListParameters,
        SetParameters,
        SetParametersAtomically,
    )

    from teleopctl.errors import UnavailableError
    from teleopctl.node.endpoints.client import Client, ResponseFuture
    from teleopctl.node.endpoints.subscription import Subscription
    from teleopctl.node.node_endpoints import NodeEndpoints
    from teleopctl.node.values.future import Future
    from teleopctl.node.values.parameter import Parameter

# Called with the future of the response.
DoneCallback: TypeAlias = Callable[["Future[ResponseT]"], object]

PARAMETER_SERVICES = (
    "DescribeParameters",
    "GetParameters",
    "GetParameterTypes",
    "ListParameters",
    "SetParameters",
    "SetParametersAtomically",
)
"""Types of rcl_interfaces of the six parameter services of a node, in rclpy's order."""

_UNLIMITED_DEPTH = 0


class AsyncParameterClient:
    """Client of the parameter services of another node.

    Each request returns a future of the service's response; a ``callback`` is called with that
    future once it has ended.

    Args:
        node: Node that sends the requests.
        remote_node_name: Name of the node that has the parameters.
        qos_profile: QoS profile of the service clients.
        callback_group: Callback group of the clients; the node's default group if None.
    """

    def __init__(
        self,
        node: NodeEndpoints,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        self.remote_node_name = remote_node_name
        self._node = node
        self._qos_profile = qos_profile
        self._callback_group = callback_group
        self._by_type: dict[str, Client[Any, Any]] = {}

    def _client(self, type_: str) -> Client[Any, Any]:
        # Created when first used: each is visible in the graph, and most users need one of the six.
        if type_ not in self._by_type:
            self._by_type[type_] = self._node.create_client(
                get_service(f"rcl_interfaces/srv/{type_}"),
                f"{self.remote_node_name}/{snake_case(type_)}",
                qos_profile=self._qos_profile,
                callback_group=self._callback_group,
            )
        return self._by_type[type_]

    @property
    def _clients(self) -> list[Client[Any, Any]]:
        return [self._client(type_) for type_ in PARAMETER_SERVICES]

    def services_are_ready(self) -> bool:
        """Return whether the other node offers all six parameter services."""
        return all(client.service_is_ready() for client in self._clients)

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Block until all six parameter services are in the graph; False on timeout or shutdown."""
        deadline = None if timeout_sec is None else time.monotonic() + timeout_sec
        for client in self._clients:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            if not client.wait_for_service(left):
                return False
        return True

    def list_parameters(
        self,
        prefixes: Sequence[str] | None = None,
        depth: int | None = None,
        callback: DoneCallback[ListParameters.Response] | None = None,
    ) -> ResponseFuture[ListParameters.Response]:
        """Request parameter names below prefixes, to a depth (None: unlimited); return a future."""
        return self._send(
            "ListParameters",
            callback,
            prefixes=list(prefixes or ()),
            depth=depth or _UNLIMITED_DEPTH,
        )

    def get_parameters(
        self, names: Sequence[str], callback: DoneCallback[GetParameters.Response] | None = None
    ) -> ResponseFuture[GetParameters.Response]:
        """Request the values of parameters; return a future of the response."""
        return self._send("GetParameters", callback, names=list(names))

    def get_parameter_types(
        self, names: Sequence[str], callback: DoneCallback[GetParameterTypes.Response] | None = None
    ) -> ResponseFuture[GetParameterTypes.Response]:
        """Request the types of parameters; return a future of the response."""
        return self._send("GetParameterTypes", callback, names=list(names))

    def describe_parameters(
        self,
        names: Sequence[str],
        callback: DoneCallback[DescribeParameters.Response] | None = None,
    ) -> ResponseFuture[DescribeParameters.Response]:
        """Request the descriptors of parameters; return a future of the response."""
        return self._send("DescribeParameters", callback, names=list(names))

    def set_parameters(
        self,
        parameters: Sequence[Parameter | ParameterMessage],
        callback: DoneCallback[SetParameters.Response] | None = None,
    ) -> ResponseFuture[SetParameters.Response]:
        """Request to set parameters one by one; return a future of the response."""
        return self._send("SetParameters", callback, parameters=_messages(parameters))

    def set_parameters_atomically(
        self,
        parameters: Sequence[Parameter | ParameterMessage],
        callback: DoneCallback[SetParametersAtomically.Response] | None = None,
    ) -> ResponseFuture[SetParametersAtomically.Response]:
        """Request to set all parameters or none; return a future of the response."""
        return self._send("SetParametersAtomically", callback, parameters=_messages(parameters))

    def delete_parameters(
        self, names: Sequence[str], callback: DoneCallback[SetParameters.Response] | None = None
    ) -> ResponseFuture[SetParameters.Response]:
        """Request to unset dynamically typed parameters; return a future of the response."""
        from teleopctl.node.values.parameter import Parameter

        return self.set_parameters([Parameter(name) for name in names], callback)

    def load_parameter_file(
        self,
        parameter_file: str | Path,
        use_wildcard: bool = False,
        callback: DoneCallback[SetParameters.Response] | None = None,
    ) -> ResponseFuture[SetParameters.Response]:
        """Request to set the parameters of a file one by one; see `parameter_messages`."""
        return self.set_parameters(_messages_of_file(parameter_file, use_wildcard), callback)

    def load_parameter_file_atomically(
        self,
        parameter_file: str | Path,
        use_wildcard: bool = False,
        callback: DoneCallback[SetParametersAtomically.Response] | None = None,
    ) -> ResponseFuture[SetParametersAtomically.Response]:
        """Request to set all parameters of a file or none; see `parameter_messages`."""
        return self.set_parameters_atomically(
            _messages_of_file(parameter_file, use_wildcard), callback
        )

    def on_parameter_event(
        self,
        callback: Callable[[ParameterEvent], object],
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
        **options: Any,  # Any: create_subscription checks them
    ) -> Subscription[ParameterEvent]:
        """Subscribe to ``/parameter_events`` of all nodes; return the subscription.

        Args:
            callback: Called with each event.
            qos_profile: QoS profile of the subscription.
            callback_group: Callback group of the callback; the node's default group if None.
            options: Further options of ``Node.create_subscription``, such as ``raw``.
        """
        return self._node.create_subscription(
            get_message("rcl_interfaces/msg/ParameterEvent"),
            "/parameter_events",
            callback,
            qos_profile,
            callback_group=callback_group,
            **options,
        )

    def _send(
        self, type_: str, callback: DoneCallback[ResponseT] | None, **fields: object
    ) -> ResponseFuture[ResponseT]:
        client = self._client(type_)
        future = client.call_async(client.srv_type.Request(**fields))
        if callback is not None:
            future.add_done_callback(callback)
        return future


def call_parameter_services(
    node: NodeEndpoints,
    remote_node_names: Iterable[str],
    request: Callable[[AsyncParameterClient], ResponseFuture[ResponseT]],
    timeout_sec: float,
) -> dict[str, ResponseT | UnavailableError]:
    """Send a parameter request to several nodes; return the response or error of each by name.

    Example:
        ```python
        call_parameter_services(node, ["/arm"], lambda client: client.list_parameters(), 5.0)
        ```

    Args:
        node: Node that sends the requests; it needs no executor.
        remote_node_names: Names of the nodes that have the parameters.
        request: Function that sends a request with a node's client, and returns the future.
        timeout_sec: Longest wait for all nodes together, in seconds of wall time.

    Returns:
        The response of each node, or an `UnavailableError` if the node did not respond.

    Raises:
        ExternalShutdownException: The context was shut down during the wait.
    """
    futures = {name: request(AsyncParameterClient(node, name)) for name in remote_node_names}
    return responses_of_nodes(futures, timeout_sec)


def _messages_of_file(path: str | Path, use_wildcard: bool) -> list[ParameterMessage]:
    from teleopctl.node.values.parameter_file import parameter_messages

    return list(parameter_messages(path, use_wildcard).values())


def _messages(parameters: Sequence[Parameter | ParameterMessage]) -> list[ParameterMessage]:
    from teleopctl.node.values.parameter import Parameter

    return [p.to_parameter_msg() if isinstance(p, Parameter) else p for p in parameters]
