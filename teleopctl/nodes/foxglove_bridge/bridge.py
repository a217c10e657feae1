"""Node of the Foxglove bridge: WebSocket server, graph updates, and requests of clients."""

from __future__ import annotations

import functools
import queue
from collections.abc import Callable
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

import foxglove
from foxglove import ConnectionGraph, Context
from foxglove.websocket import ServerListener, StatusLevel, WebSocketServer

from teleopctl.base import progress
from teleopctl.base.access import Access, host_in_url
from teleopctl.base.token_file import Address, read_or_make_token
from teleopctl.errors import SystemFailureError, TeleopctlError, UnavailableError
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import LogOnce, Node, RcutilsLogger, qos_profile_sensor_data
from teleopctl.nodes.foxglove_bridge.channels import Channels
from teleopctl.nodes.foxglove_bridge.client_topics import ENCODINGS, ClientTopics
from teleopctl.nodes.foxglove_bridge.gate import Gate, inner_addresses
from teleopctl.nodes.foxglove_bridge.remote_parameters import RemoteParameters
from teleopctl.nodes.foxglove_bridge.remote_services import RemoteServices
from teleopctl.nodes.foxglove_bridge.settings import BridgeSettings, allows
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    from foxglove.websocket import ChannelView, Client, ClientChannel, Parameter


class AssetReader:
    """Callable that returns the file of an asset URI (mesh, texture) if an allowlist has the URI.

    Args:
        settings: Settings with the allowlist of asset URIs.
        logger: Logger for refused and missing files.
    """

    def __init__(self, settings: BridgeSettings, logger: RcutilsLogger) -> None:
        self._settings = settings
        self._logger = logger

    def __call__(self, uri: str) -> bytes | None:
        """Return the bytes of the file; None if the URI is not allowed or the file not readable."""
        # Two dots, also written as %2e%2e, could lead out of the package.
        if ".." in unquote(uri) or not allows(self._settings.assets, uri):
            self._logger.warning(f"Asset URI not allowed: {uri}")
            return None
        try:
            return resolve_uri(uri).read_bytes()
        except OSError as error:
            failure: TeleopctlError = SystemFailureError(error.strerror or str(error))
        except TeleopctlError as error:
            failure = error
        self._logger.warning(f"Failed to retrieve asset '{uri}': {failure.message}")
        return None


# Graph changes arrive in bursts; clients are notified of them together, at this period.
_UPDATE_PERIOD_S = 0.25


class FoxgloveBridge(Node):
    """Node ``foxglove_bridge``, which serves the ROS graph to Foxglove over a WebSocket.

    Raises:
        TeleopctlError: A parameter is wrong, or the bridge cannot listen on its address.
    """

    def __init__(self) -> None:
        progress.report(progress.STARTING)
        super().__init__("foxglove_bridge")
        self._settings = settings = BridgeSettings(self)
        context = Context()
        self._channels = Channels(self, settings, context)
        # Tasks that the server's threads pass to the executor: these threads must neither wait for
        # the executor nor call the server.
        self._tasks: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._work = self.create_guard_condition(self._run_tasks)
        self._graph_changed, self._connections_wanted = True, False
        self._listener = _Listener(self, settings)
        self._server, inner = _open_server(self, settings, context, self._listener)
        self._gate = self._open_gate(inner)
        self._services = RemoteServices(self, settings, self._server)
        self.add_graph_callback(self._on_graph_change)
        self.create_timer(_UPDATE_PERIOD_S, self._update)
        if settings.follows_simulated_time:
            self.create_subscription(
                get_message("rosgraph_msgs/msg/Clock"),
                "/clock",
                lambda clock: self._server.broadcast_time(to_nanoseconds(clock.clock)),
                qos_profile_sensor_data,
            )
        self._update()
        self._report_address()

    @property
    def server(self) -> WebSocketServer:
        """WebSocket server of Foxglove's SDK, to which Foxglove clients connect."""
        return self._server

    @property
    def channels(self) -> Channels:
        """Foxglove channels of the ROS topics that clients can subscribe to."""
        return self._channels

    def hand_over(self, task: Callable[[], object]) -> None:
        """Queue a function to be called on the executor's thread; any thread may call this."""
        self._tasks.put(task)
        self._work.trigger()

    def show_connections(self) -> None:
        """Begin to send clients the graph of publishers and subscribers, with the next update."""
        self._connections_wanted = self._graph_changed = True

    def destroy_node(self) -> None:
        """Close the access gate and the server, and destroy the node."""
        self._gate.close()
        self._server.stop()
        super().destroy_node()

    def _open_gate(self, inner: tuple[str, int]) -> Gate:
        settings = self._settings
        refused = LogOnce(self.get_logger().warning)

        def note(why: str) -> None:
            cure = ""
            if why.startswith("Pages"):
                cure = " The parameter allowed_origins admits them."
            refused.note(f"Refused a client: {why}{cure}")

        try:
            token = read_or_make_token(settings.token_file) if settings.token_file else None
            access = Access(settings.address, token, settings.origins)
            return Gate(access, settings.address, settings.port, inner, settings.tls, note)
        except BaseException:
            self._server.stop()
            raise

    def _report_address(self) -> None:
        settings = self._settings
        scheme = "ws" if settings.tls is None else "wss"
        host = f"[{settings.address}]" if ":" in settings.address else settings.address
        url = f"{scheme}://{host}:{self._gate.port}"
        self.get_logger().info(f"Server listening on {url}")
        if settings.token_file is None:
            progress.report(progress.READY)
            return
        name = host_in_url(settings.address)
        address = Address(f"{scheme}://{name}:{self._gate.port}/", settings.token_file)
        self.get_logger().info(f"Clients must present the token of {settings.token_file}")
        if settings.tls is None:
            self.get_logger().warning(
                "Neither messages nor the token are encrypted: give a certificate, or use a tunnel"
            )
        progress.report_ready_at(address)

    def _on_graph_change(self) -> None:
        self._graph_changed = True

    def _run_tasks(self) -> None:
        for _ in range(self._tasks.qsize()):
            task = self._tasks.get_nowait()
            try:
                task()
            except TeleopctlError as error:
                self.get_logger().error(error.message)

    def _update(self) -> None:
        if not self._graph_changed:
            return
        self._graph_changed = False
        graph = self.graph()
        self._channels.update(graph)
        if "services" in self._settings.capability_names:
            self._services.update(graph)
        if "connectionGraph" in self._settings.capability_names and self._connections_wanted:
            self._server.publish_connection_graph(self._connections())

    def _connections(self) -> ConnectionGraph:
        graph, shown, settings = self.graph(), ConnectionGraph(), self._settings
        for topic, _ in graph.topic_names_and_types(settings.includes_hidden):
            if allows(settings.topics, topic):
                publishers = sorted({p.full_name for p in graph.publishers(topic)})
                subscribers = sorted({s.full_name for s in graph.subscriptions(topic)})
                shown.set_published_topic(topic, publishers)
                shown.set_subscribed_topic(topic, subscribers)
        for service, _ in graph.service_names_and_types(settings.includes_hidden):
            servers = sorted({s.full_name for s in graph.servers(service)})
            if servers and allows(settings.services, service):
                shown.set_advertised_service(service, servers)
        return shown


class _Listener(ServerListener):
    """Handler of clients' requests, on the server's threads; logs errors, and sends them."""

    def __init__(self, node: FoxgloveBridge, settings: BridgeSettings) -> None:
        self._node = node
        self._topics = ClientTopics(node, settings)
        self._parameters = RemoteParameters(node, settings)

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self._hand_over(self._node.channels.subscribe, channel.id, client.id)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        self._hand_over(self._node.channels.unsubscribe, channel.id, client.id)

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        try:
            self._topics.advertise(client.id, channel)
        except TeleopctlError as error:
            self._report_error(error.message)

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        self._topics.unadvertise(client.id, client_channel_id)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        try:
            self._topics.publish(client.id, client_channel_id, data)
        except TeleopctlError as error:
            self._report_error(f"Dropping a client's message: {error.message}")

    def on_get_parameters(
        self,
        client: Client,  # noqa: ARG002
        param_names: list[str],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[Parameter]:
        return self._parameters.get(param_names)

    def on_set_parameters(
        self,
        client: Client,  # noqa: ARG002
        parameters: list[Parameter],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[Parameter]:
        try:
            return self._parameters.set(parameters)
        except (TeleopctlError, TypeError, ValueError) as error:
            self._report_error(f"Cannot set parameters: {error}")
            return self._parameters.get([parameter.name for parameter in parameters])

    def on_parameters_subscribe(self, param_names: list[str]) -> None:
        tell = self._node.server.publish_parameter_values
        self._hand_over(self._parameters.watch, param_names, tell)

    def on_parameters_unsubscribe(self, param_names: list[str]) -> None:
        self._hand_over(self._parameters.unwatch, param_names)

    def on_connection_graph_subscribe(self) -> None:
        self._node.show_connections()

    def _hand_over(self, task: Callable[..., object], *arguments: Any) -> None:
        self._node.hand_over(functools.partial(task, *arguments))

    def _report_error(self, text: str) -> None:
        self._node.get_logger().error(text, throttle_duration_sec=1.0)
        self._hand_over(self._node.server.publish_status, text, StatusLevel.Error)


def _open_server(
    node: FoxgloveBridge, settings: BridgeSettings, context: Context, listener: _Listener
) -> tuple[WebSocketServer, tuple[str, int]]:
    """Start the SDK's server on loopback; return the server and its address and port."""
    failure: Exception | None = None
    for host in inner_addresses():
        try:
            server = foxglove.start_server(
                name=node.get_fully_qualified_name(),
                host=host,
                port=0,
                capabilities=settings.capabilities,
                server_listener=listener,
                supported_encodings=list(ENCODINGS),
                asset_handler=(
                    AssetReader(settings, node.get_logger())
                    if "assets" in settings.capability_names
                    else None
                ),
                context=context,
                message_backlog_size=settings.backlog,
            )
        except (OSError, RuntimeError, ValueError) as error:
            failure = error
        else:
            return server, (host, server.port)
    raise UnavailableError(f"Foxglove's SDK cannot listen on loopback: {failure}") from failure
