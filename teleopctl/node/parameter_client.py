"""A client of another node's parameters, with the names of ``rclpy.parameter_client``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces.store import get_service
from teleopctl.node.endpoints.client import Client
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.parameter import Parameter
from teleopctl.node.values.parameter_file import parameter_messages
from teleopctl.node.values.qos import QoSProfile, qos_profile_services_default

if TYPE_CHECKING:
    from teleopctl.node.node_endpoints import NodeEndpoints
    from teleopctl.node.values.future import Future

# Called with the future of the response.
DoneCallback = Callable[["Future"], object]

_UNLIMITED_DEPTH = 0


class AsyncParameterClient:
    """Asks another node for its parameters, and sets them.

    Each request returns a future of the service's response; a ``callback`` is called with that
    future once it has ended.

    Args:
        node: The node that asks.
        remote_node_name: Name of the node whose parameters they are.
        qos_profile: Quality of service of the clients.
        callback_group: For multi-threaded executors.
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

        def client(type_: str, service: str) -> Client:
            return node.create_client(
                get_service(f"rcl_interfaces/srv/{type_}"),
                f"{remote_node_name}/{service}",
                qos_profile=qos_profile,
                callback_group=callback_group,
            )

        self._list = client("ListParameters", "list_parameters")
        self._get = client("GetParameters", "get_parameters")
        self._get_types = client("GetParameterTypes", "get_parameter_types")
        self._describe = client("DescribeParameters", "describe_parameters")
        self._set = client("SetParameters", "set_parameters")
        self._set_together = client("SetParametersAtomically", "set_parameters_atomically")

    @property
    def _clients(self) -> tuple[Client, ...]:
        return (
            self._list,
            self._get,
            self._get_types,
            self._describe,
            self._set,
            self._set_together,
        )

    def services_are_ready(self) -> bool:
        """Tell whether the other node offers all of its parameter services."""
        return all(client.service_is_ready() for client in self._clients)

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Wait for the services; False when the time, in seconds for all of them, ran out."""
        import time

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
        callback: DoneCallback | None = None,
    ) -> Future:
        """Ask for the names below prefixes, down to a depth (None: without limit)."""
        request = self._list.srv_type.Request(depth=depth or _UNLIMITED_DEPTH)
        request.prefixes = list(prefixes or ())
        return _send(self._list, request, callback)

    def get_parameters(self, names: Sequence[str], callback: DoneCallback | None = None) -> Future:
        """Ask for values."""
        return _send(self._get, self._get.srv_type.Request(names=list(names)), callback)

    def get_parameter_types(
        self, names: Sequence[str], callback: DoneCallback | None = None
    ) -> Future:
        """Ask for types."""
        return _send(self._get_types, self._get_types.srv_type.Request(names=list(names)), callback)

    def describe_parameters(
        self, names: Sequence[str], callback: DoneCallback | None = None
    ) -> Future:
        """Ask for descriptors."""
        return _send(self._describe, self._describe.srv_type.Request(names=list(names)), callback)

    def set_parameters(
        self, parameters: Sequence[Any], callback: DoneCallback | None = None
    ) -> Future:
        """Set parameters one by one; each is a :class:`Parameter` or its message."""
        request = self._set.srv_type.Request(parameters=_messages(parameters))
        return _send(self._set, request, callback)

    def set_parameters_atomically(
        self, parameters: Sequence[Any], callback: DoneCallback | None = None
    ) -> Future:
        """Set all parameters or none; each is a :class:`Parameter` or its message."""
        request = self._set_together.srv_type.Request(parameters=_messages(parameters))
        return _send(self._set_together, request, callback)

    def delete_parameters(
        self, names: Sequence[str], callback: DoneCallback | None = None
    ) -> Future:
        """Take the values of parameters away, which only dynamically typed ones let happen."""
        return self.set_parameters([Parameter(name) for name in names], callback)

    def load_parameter_file(
        self,
        parameter_file: str | Path,
        use_wildcard: bool = False,
        callback: DoneCallback | None = None,
    ) -> Future:
        """Set what a parameter file holds, one by one; see :func:`parameter_messages`."""
        return self.set_parameters(
            list(parameter_messages(parameter_file, use_wildcard).values()), callback
        )

    def load_parameter_file_atomically(
        self,
        parameter_file: str | Path,
        use_wildcard: bool = False,
        callback: DoneCallback | None = None,
    ) -> Future:
        """Set all that a parameter file holds, or nothing; see :func:`parameter_messages`."""
        return self.set_parameters_atomically(
            list(parameter_messages(parameter_file, use_wildcard).values()), callback
        )

    def on_parameter_event(
        self,
        callback: Callable[[Any], Any],
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Any:
        """Subscribe to the changes of all nodes' parameters; returns the subscription."""
        from teleopctl.interfaces.store import get_message

        return self._node.create_subscription(
            get_message("rcl_interfaces/msg/ParameterEvent"),
            "/parameter_events",
            callback,
            qos_profile,
            callback_group=callback_group,
        )


def _send(client: Client, request: Any, callback: DoneCallback | None) -> Future:
    future = client.call_async(request)
    if callback is not None:
        future.add_done_callback(callback)
    return future


def _messages(parameters: Sequence[Any]) -> list[Any]:
    return [p.to_parameter_msg() if isinstance(p, Parameter) else p for p in parameters]
