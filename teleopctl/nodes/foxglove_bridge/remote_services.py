"""Services of the ROS graph for Foxglove clients."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from foxglove import MessageSchema, Schema, Service, ServiceRequest, ServiceSchema

from teleopctl.errors import TeleopctlError, UnavailableError, UnsupportedError
from teleopctl.interfaces import complete_definition_text, deserialize, get_service, serialize
from teleopctl.node import Client, Node, add_type_from_graph
from teleopctl.nodes.foxglove_bridge.settings import BridgeSettings, allows

if TYPE_CHECKING:
    from foxglove.websocket import WebSocketServer

    from teleopctl.wire import Graph

# Seconds until a client receives the error that the service does not respond; a thread waits.
_LONGEST_CALL_S = 30.0
_LONGEST_LEARNING_S = 2.0


class RemoteServices:
    """Services of the ROS graph, offered to Foxglove clients, whose calls are forwarded.

    Args:
        node: Node that calls the services.
        settings: Settings with the services that clients may call.
        server: Foxglove server that offers the services.
    """

    def __init__(self, node: Node, settings: BridgeSettings, server: WebSocketServer) -> None:
        self._node = node
        self._settings = settings
        self._server = server
        self._types: dict[str, str] = {}
        self._lock = threading.Lock()
        self._clients: dict[str, Client[Any, Any]] = {}

    def update(self, graph: Graph) -> None:
        """Offer new services of the ROS graph to Foxglove clients, and withdraw removed ones."""
        wanted = {
            name: graph.servers(name)[0].type_name
            for name, _ in graph.service_names_and_types(self._settings.includes_hidden)
            if graph.servers(name) and allows(self._settings.services, name)
        }
        gone = [name for name, type_name in self._types.items() if wanted.get(name) != type_name]
        if gone:
            self._server.remove_services(gone)
            for name in gone:
                del self._types[name]
                self._forget(name)
        offered = []
        for name in sorted(wanted.keys() - self._types.keys()):
            self._types[name] = wanted[name]
            offered.append(
                Service(name, schema=self._schema(graph, wanted[name]), handler=self._call)
            )
        if offered:
            self._server.add_services(offered)

    def _schema(self, graph: Graph, type_name: str) -> ServiceSchema:
        try:
            add_type_from_graph(self._node, type_name, graph, _LONGEST_LEARNING_S)
            request, response = (
                MessageSchema(
                    encoding="cdr",
                    schema=Schema(
                        name=name,
                        encoding="ros2msg",
                        data=complete_definition_text(name).encode(),
                    ),
                )
                for name in (f"{type_name}_Request", f"{type_name}_Response")
            )
        except TeleopctlError as error:
            self._node.get_logger().warning(f"{type_name}: {error.message}")
            return ServiceSchema(type_name)
        return ServiceSchema(type_name, request=request, response=response)

    def _call(self, request: ServiceRequest) -> bytes:
        """Forward a client's call, on a thread of the server; errors are sent to the client."""
        if request.encoding != "cdr":
            raise UnsupportedError(f"Requests are written as cdr, not as '{request.encoding}'")
        client = self._client(request.service_name)
        message_class = client.srv_type.Request
        # For a type without fields, ROS 2 sends a byte that Foxglove's definition does not have.
        is_empty = not message_class.get_fields_and_field_types()
        message = message_class() if is_empty else deserialize(request.payload, message_class)
        response = client.call_async(message).wait_for_response(_LONGEST_CALL_S)
        if response is None:
            raise UnavailableError(
                f"{request.service_name} did not answer within {_LONGEST_CALL_S:g} s"
            )
        return bytes(serialize(response))

    def _client(self, name: str) -> Client[Any, Any]:
        # Created on the first call: each client is in the graph, and most services are never
        # called.
        with self._lock:
            if name not in self._clients:
                service_class = get_service(self._types[name])
                self._clients[name] = self._node.create_client(service_class, name)
            return self._clients[name]

    def _forget(self, name: str) -> None:
        with self._lock:
            client = self._clients.pop(name, None)
        if client is not None:
            self._node.destroy_client(client)
