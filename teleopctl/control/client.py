"""Client of a controller manager's services, for use in other processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import cached_property
from typing import Any, Protocol

from teleopctl.control.manager_log import NOT_RELOADED, ManagerLog
from teleopctl.errors import UnavailableError
from teleopctl.interfaces import (
    AllowableParameterValue,
    from_seconds,
    get_message,
    get_service,
    set_stamp,
)
from teleopctl.node import (
    AsyncParameterClient,
    Client,
    ExternalShutdownException,
    Node,
    Parameter,
    ResponseFuture,
)

STRICT = 2
# The graph wakes a thread that waits for a service; the manager's log is polled with this period.
_POLL_PERIOD_S = 0.1
# Time without a response after which to check that the manager's process runs at all: a call that
# runs users' controllers and hardware may take longer.
_NOT_FROZEN_S = 4.0
# The graph wakes a thread that waits for a restart; Windows delivers signals to running threads.
_WAKE_PERIOD_S = 1.0
# All services of a manager begin together.
_RELOAD_SERVICE_WITHIN_S = 1.0
# Time for the first update and for what the manager does meanwhile, beyond the timeout of a reload.
_FIRST_UPDATE_S = 10.0

# Any: message classes are generated at run time from definitions.


class GraphEndpoint(Protocol):
    """Interface of a publisher, subscription, server or client in the graph."""

    @property
    def kind(self) -> str:
        """``SS`` for a server, ``MS`` for a subscription."""

    @property
    def name(self) -> str:
        """Name of the topic or service."""

    @property
    def full_name(self) -> str:
        """Full name of the endpoint's node."""


def controller_managers(endpoints: Iterable[GraphEndpoint]) -> list[str]:
    """Return the full names of the controller managers in a graph that have services, sorted."""
    return sorted(
        endpoint.name.removesuffix("/list_controllers")
        for endpoint in endpoints
        if endpoint.kind == "SS" and endpoint.name.endswith("/list_controllers")
    )


def managers_of_same_robot(endpoints: Collection[GraphEndpoint], manager: str) -> dict[str, str]:
    """Return other controller managers that take the same robot description, with its topic.

    They command the same joints. Managers of several robots have a description each.

    Args:
        endpoints: Endpoints in the ROS graph.
        manager: Full name of the controller manager.
    """

    def descriptions(of: str) -> set[str]:
        return {
            endpoint.name
            for endpoint in endpoints
            if endpoint.kind == "MS" and endpoint.full_name == of
            if endpoint.name.endswith("robot_description")
        }

    return {
        other: min(shared)
        for other in controller_managers(endpoints)
        if other != manager and (shared := descriptions(other) & descriptions(manager))
    }


class ControllerManagerUnavailableError(UnavailableError):
    """Raised when a controller manager's services are missing or do not respond."""


class ControllerManagerClient:
    """Client of a controller manager's services, with retries and logged error causes.

    Args:
        node: Node that sends the requests.
        manager: Name of the controller manager; a relative name is in the node's namespace.
        call_timeout: Timeout of each attempt of a call, in seconds.
        attempts: Number of attempts for each call.

    Attributes:
        node: Node that sends the requests.
        name: Full name of the controller manager.
    """

    def __init__(
        self, node: Node, manager: str, *, call_timeout: float = 10.0, attempts: int = 3
    ) -> None:
        self.node = node
        self._call_timeout = call_timeout
        self._attempts = attempts
        self._clients: dict[str, Client[Any, Any]] = {}
        self._called_ns = 0
        self.name = (
            manager if manager.startswith("/") else f"{node.get_namespace().rstrip('/')}/{manager}"
        )
        self._parameters = AsyncParameterClient(node, self.name)

    def _client(self, service: str, type_name: str) -> Client[Any, Any]:
        if service not in self._clients:
            self._clients[service] = self.node.create_client(
                get_service(type_name), f"{self.name}/{service}"
            )
        return self._clients[service]

    def wait(self, timeout: float, *, log_waiting: bool = False) -> None:
        """Wait for the manager's services; raise on timeout (0: none) or a refused description.

        Args:
            timeout: Time limit in seconds; 0 waits for ever.
            log_waiting: Whether to log the awaited service on the node's logger.

        Raises:
            ControllerManagerUnavailableError: The time is over, or the manager refuses the robot
                description, without which it has no services.
            ExternalShutdownException: The context was shut down while waiting.
        """
        client, service = self._list_client, f"{self.name}/list_controllers"
        deadline = time.monotonic() + timeout if timeout else None
        logger = self.node.get_logger()
        while True:
            if client.service_is_ready():
                return
            log = self._log  # subscribes before the log line, after which a user may interrupt
            if log_waiting:
                logger.info(f"waiting for service {service} to become available...")
            left = 10.0 if deadline is None else min(10.0, deadline - time.monotonic())
            if self._is_ready_within(left, client, log):
                return
            if not self.node.context.ok():
                raise ExternalShutdownException
            if deadline is not None and time.monotonic() >= deadline:
                raise ControllerManagerUnavailableError(
                    f"Could not contact service {service}",
                    hint=self._why_unavailable(),
                )
            if log_waiting:
                logger.warning(f"Could not contact service {service}")

    def _is_ready_within(self, seconds: float, client: Client[Any, Any], log: ManagerLog) -> bool:
        deadline = time.monotonic() + seconds
        while True:
            left = deadline - time.monotonic()
            if client.wait_for_service(max(0.0, min(left, _POLL_PERIOD_S))):
                return True
            if log.refusal is not None:
                raise ControllerManagerUnavailableError(
                    f"{self.name} has not accepted the robot description: {log.refusal}"
                )
            if left <= 0 or not self.node.context.ok():
                return False

    @property
    def _list_client(self) -> Client[Any, Any]:
        return self._client("list_controllers", "controller_manager_msgs/srv/ListControllers")

    def sessions(self) -> frozenset[str]:
        """Return the ids of the Zenoh sessions that offer the manager's services."""
        client = self._list_client
        servers = self.node.graph().servers(client.service_name, client.type_name)
        return frozenset(server.zid for server in servers)

    def wait_for_restart(self, sessions: frozenset[str]) -> None:
        """Wait until a Zenoh session other than the given ones offers the manager's services.

        Raises:
            ExternalShutdownException: The context was shut down while waiting.
        """
        context = self.node.context
        while not context.wait_for_change(lambda: bool(self.sessions() - sessions), _WAKE_PERIOD_S):
            if not context.ok():
                raise ExternalShutdownException

    @cached_property
    def _log(self) -> ManagerLog:
        return ManagerLog(self.node, self.name)

    def cause(self, controller: str) -> str | None:
        """Wait up to 3 s for an error logged about a controller since the last call; else None."""
        return self._log.cause(controller, self._called_ns)

    def reload_error(self) -> str | None:
        """Wait up to 3 s for the logged reason why reloading was refused; None if there is none."""
        return self._log.last_error(NOT_RELOADED, self._called_ns)

    def _why_unavailable(self) -> str:
        names = self.node.graph().node_names(include_hidden=True)
        if self.name in names:
            topic = f"{self.name.rpartition('/')[0]}/robot_description"
            if self.node.graph().publishers(topic):
                return (
                    f"{self.name} runs but has no services: it has not accepted the robot "
                    f"description on {topic}; its log says why"
                )
            return (
                f"{self.name} runs but has no services yet: it is waiting for a robot description "
                f"on {topic}, as `teleopctl run robot_state_publisher robot_state_publisher FILE` "
                "publishes it"
            )
        managers = controller_managers(self.node.graph().endpoints)
        if managers:
            return f"there is no {self.name}; running: {', '.join(managers)} (use -c NAME)"
        return (
            "no controller manager is running: start one with `teleopctl launch "
            "controller.yaml` or "
            "`teleopctl launch sim.yaml`"
        )

    def call(self, service: str, type_name: str, **fields: Any) -> Any:
        """Call a manager's service, with retries; return the response, or raise without one.

        Args:
            service: Name of the service, below the manager's name.
            type_name: Service type, in controller_manager_msgs unless a package is given.
            fields: Fields of the request.

        Raises:
            ControllerManagerUnavailableError: No response arrived; if the manager's process is
                suspended, raised after five seconds.
        """
        full_type = type_name if "/" in type_name else f"controller_manager_msgs/srv/{type_name}"
        client = self._client(service, full_type)
        request = get_service(full_type).Request(**fields)
        self._called_ns = time.time_ns()
        return self._call_with_retries(service, lambda: client.call_async(request))

    def _call_with_retries(self, service: str, send: Callable[[], ResponseFuture[Any]]) -> Any:
        for attempt in range(1, self._attempts + 1):
            response = self._response(service, send, self._call_timeout)
            if response is not None:
                return response
            self.node.get_logger().warning(
                f"Failed getting a result from calling {self.name}/{service} in "
                f"{self._call_timeout}. (Attempt {attempt} of {self._attempts}.)"
            )
        raise ControllerManagerUnavailableError(
            f"Could not successfully call service {self.name}/{service} after "
            f"{self._attempts} attempts."
        )

    def _response(
        self, service: str, send: Callable[[], ResponseFuture[Any]], timeout_s: float
    ) -> Any:
        """Send a request; return the response, or None after the timeout."""
        pending, began = send(), time.monotonic()
        if not pending.wait_until_settled(min(_NOT_FROZEN_S, timeout_s)):
            self._check_not_frozen(service)
        return pending.wait_for_response(max(0.0, timeout_s - (time.monotonic() - began)))

    def _check_not_frozen(self, service: str) -> None:
        if self._list_client.is_server_frozen():
            raise ControllerManagerUnavailableError(
                f"{self.name} does not answer {service}: its process does not respond at all.",
                hint="It may be stopped (Ctrl-Z, a debugger, kill -STOP): continue it with kill "
                "-CONT, or end it with `teleopctl stop` and start it again; `teleopctl ps` lists "
                "it with its pid.",
            )

    def execution_times(self) -> Any | None:
        """Request the histograms of execution times; None from a manager of ROS 2 or none at all.

        Returns:
            The response of teleopctl_msgs/GetExecutionTimes.
        """
        service, type_name = "get_execution_times", "teleopctl_msgs/srv/GetExecutionTimes"
        if not self._client(service, type_name).service_is_ready():
            return None
        return self.call(service, type_name)

    def list_controllers(self) -> list[Any]:
        """Request the loaded controllers; return them as ControllerState messages."""
        return list(self.call("list_controllers", "ListControllers").controller)

    def load_controller(self, name: str) -> bool:
        """Request to load a controller; return whether that succeeded."""
        return bool(self.call("load_controller", "LoadController", name=name).ok)

    def configure_controller(self, name: str) -> bool:
        """Request to configure a controller; return whether that succeeded."""
        return bool(self.call("configure_controller", "ConfigureController", name=name).ok)

    def cleanup_controller(self, name: str) -> bool:
        """Request to clean up a controller; return whether that succeeded."""
        return bool(self.call("cleanup_controller", "CleanupController", name=name).ok)

    def unload_controller(self, name: str) -> bool:
        """Request to unload a controller; return whether that succeeded."""
        return bool(self.call("unload_controller", "UnloadController", name=name).ok)

    def reload_controller(self, name: str, timeout: float = 10.0) -> tuple[bool, str, list[str]]:
        """Request to reload a controller's changed code; return the success, a message and files.

        Args:
            name: Name of the controller.
            timeout: Longest time for the import and configuration of the new code, in seconds.

        Returns:
            Whether the new code runs, what was reloaded or why not, and the paths of the files that
            the manager's process has imported for the controller.

        Raises:
            ControllerManagerUnavailableError: No response arrived, or the manager has no such
                service: it is not one of teleopctl.
        """
        service, type_name = "reload_controller", "teleopctl_msgs/srv/ReloadController"
        client = self._client(service, type_name)
        if not client.wait_for_service(_RELOAD_SERVICE_WITHIN_S):
            raise ControllerManagerUnavailableError(
                f"{self.name} has no service {service}: it is not a controller manager of teleopctl"
            )
        request = get_service(type_name).Request(name=name, timeout=_duration(timeout))
        response = self._response(
            service, lambda: client.call_async(request), timeout + _FIRST_UPDATE_S
        )
        if response is None:
            raise ControllerManagerUnavailableError(
                f"{self.name} has not answered {service} within {timeout + _FIRST_UPDATE_S:g} s"
            )
        return bool(response.ok), str(response.message), list(response.files)

    def switch_controllers(
        self,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        *,
        strictness: int = STRICT,
        asap: bool = True,
        timeout: float = 5.0,
    ) -> tuple[bool, str]:
        """Request to activate and deactivate controllers; return the success and a message.

        Waits for the service while the manager has its other services.

        Raises:
            ControllerManagerUnavailableError: No response arrived.
            ExternalShutdownException: The context was shut down while waiting.
        """
        # Offered once the hardware has states: a simulator may build its model for minutes.
        client = self._client("switch_controller", "controller_manager_msgs/srv/SwitchController")
        while not client.wait_for_service(_WAKE_PERIOD_S) and self._list_client.service_is_ready():
            if not self.node.context.ok():
                raise ExternalShutdownException
        response = self.call(
            "switch_controller",
            "SwitchController",
            activate_controllers=list(activate),
            deactivate_controllers=list(deactivate),
            strictness=strictness,
            activate_asap=asap,
            timeout=_duration(timeout),
        )
        return bool(response.ok), str(response.message)

    def set_parameter(self, name: str, value: AllowableParameterValue) -> bool:
        """Set a parameter of the manager's node by service; return whether that succeeded."""
        wanted = [Parameter(name, value=value)]
        response = self._call_with_retries(
            "set_parameters", lambda: self._parameters.set_parameters(wanted)
        )
        return all(result.successful for result in response.results)


def _duration(seconds: float) -> Any:
    duration = get_message("builtin_interfaces/msg/Duration")()
    set_stamp(duration, from_seconds(seconds))
    return duration
