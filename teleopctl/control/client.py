"""Client of a controller manager's services, for other processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

from teleopctl.control.manager_log import NOT_RELOADED, ManagerLog
from teleopctl.errors import UnavailableError
from teleopctl.interfaces import from_seconds, get_message, get_service, set_stamp
from teleopctl.node import (
    AllowableParameterValue,
    AsyncParameterClient,
    Client,
    ExternalShutdownException,
    Node,
    Parameter,
    ResponseFuture,
)

STRICT = 2
# The graph wakes who waits for a service; the manager's log is looked at this often, in seconds.
_LOOK_EVERY_S = 0.1
# After so long without a response it is asked whether the manager's process runs at all: what it
# does for a call, of others' controllers and hardware, may take longer.
_NOT_FROZEN_S = 4.0
# The graph wakes who waits for another manager; Windows delivers signals to who wakes by itself.
_WAKE_EVERY_S = 1.0

# Any stands for messages: their classes are made at run time, from definitions.


class ControllerManagerUnavailableError(UnavailableError):
    """No controller manager of that name answers."""


class ControllerManagerClient:
    """Client of a controller manager's services.

    Args:
        node: The node that asks.
        manager: The manager's name; a relative one is in the node's namespace.
        call_timeout: Seconds for one attempt of one call.
        attempts: How often a call is tried.
    """

    def __init__(
        self, node: Node, manager: str, *, call_timeout: float = 10.0, attempts: int = 3
    ) -> None:
        self._node = node
        self._call_timeout = call_timeout
        self._attempts = attempts
        self._clients: dict[str, Client[Any, Any]] = {}
        self._asked_ns = 0
        self.name = (
            manager if manager.startswith("/") else f"{node.get_namespace().rstrip('/')}/{manager}"
        )
        self._parameters = AsyncParameterClient(node, self.name)

    def _client(self, service: str, type_name: str) -> Client[Any, Any]:
        if service not in self._clients:
            self._clients[service] = self._node.create_client(
                get_service(type_name), f"{self.name}/{service}"
            )
        return self._clients[service]

    def wait(self, timeout: float, *, patient: bool = False) -> None:
        """Wait for the manager's services.

        Args:
            timeout: Seconds; 0 waits for ever.
            patient: Whether to say on the node's logger what is being waited for.

        Raises:
            ControllerManagerUnavailableError: The time is over, or the manager refuses the robot
                description, without which it has no services.
            ExternalShutdownException: The process was told to end meanwhile.
        """
        client, service = self._list_client, f"{self.name}/list_controllers"
        deadline = time.monotonic() + timeout if timeout else None
        logger = self._node.get_logger()
        while True:
            if client.service_is_ready():
                return
            log = self._log  # listens before anything is said: who is told may end the process
            if patient:
                logger.info(f"waiting for service {service} to become available...")
            left = 10.0 if deadline is None else min(10.0, deadline - time.monotonic())
            if self._is_ready_within(left, client, log):
                return
            if not self._node.context.ok():
                raise ExternalShutdownException
            if deadline is not None and time.monotonic() >= deadline:
                raise ControllerManagerUnavailableError(
                    f"Could not contact service {service}",
                    hint=self._why_unavailable(),
                )
            if patient:
                logger.warning(f"Could not contact service {service}")

    def _is_ready_within(self, seconds: float, client: Client[Any, Any], log: ManagerLog) -> bool:
        deadline = time.monotonic() + seconds
        while True:
            left = deadline - time.monotonic()
            if client.wait_for_service(max(0.0, min(left, _LOOK_EVERY_S))):
                return True
            if log.refusal is not None:
                raise ControllerManagerUnavailableError(
                    f"{self.name} has not accepted the robot description: {log.refusal}"
                )
            if left <= 0 or not self._node.context.ok():
                return False

    @property
    def _list_client(self) -> Client[Any, Any]:
        return self._client("list_controllers", "controller_manager_msgs/srv/ListControllers")

    def sessions(self) -> frozenset[str]:
        """Return the Zenoh sessions of the managers of this name; a restarted one has a new one."""
        client = self._list_client
        servers = self._node.graph().servers(client.service_name, client.type_name)
        return frozenset(server.zid for server in servers)

    def wait_for_another(self, sessions: frozenset[str]) -> None:
        """Wait until a manager serves requests in another session than these.

        Raises:
            ExternalShutdownException: The process was told to end meanwhile.
        """
        context = self._node.context
        while not context.wait_for_change(lambda: bool(self.sessions() - sessions), _WAKE_EVERY_S):
            if not context.ok():
                raise ExternalShutdownException

    @cached_property
    def _log(self) -> ManagerLog:
        return ManagerLog(self._node, self.name)

    def cause(self, controller: str) -> str | None:
        """Return the error that was logged since the last call about a controller, or None."""
        return self._log.cause(controller, self._asked_ns)

    def why_not_reloaded(self) -> str | None:
        """Return the logged reason why the last call did not reload the controllers' code, or None.

        None where nothing is heard of it.
        """
        return self._log.last_error(NOT_RELOADED, self._asked_ns)

    def _why_unavailable(self) -> str:
        names = self._node.graph().node_names(include_hidden=True)
        if self.name in names:
            topic = f"{self.name.rpartition('/')[0]}/robot_description"
            if self._node.graph().publishers(topic):
                return (
                    f"{self.name} runs but has no services: it has not accepted the robot "
                    f"description on {topic}; its log says why"
                )
            return (
                f"{self.name} runs but has no services yet: it is waiting for a robot description "
                f"on {topic}"
            )
        managers = sorted(
            token.name.removesuffix("/list_controllers")
            for token in self._node.graph().endpoints
            if token.kind.name == "SS" and token.name.endswith("/list_controllers")
        )
        if managers:
            return f"there is no {self.name}; running: {', '.join(managers)} (use -c NAME)"
        return (
            "no controller manager runs: start one with `teleopctl launch controller.yaml` or "
            "`teleopctl launch sim.yaml`"
        )

    def call(self, service: str, type_name: str, **fields: Any) -> Any:
        """Call a service.

        Args:
            service: Its name below the manager's.
            type_name: Its type, within controller_manager_msgs unless a package is named.
            fields: The request's fields.

        Raises:
            ControllerManagerUnavailableError: There is no answer. Of a manager whose process is
                stopped this is known after five seconds.
        """
        full_type = type_name if "/" in type_name else f"controller_manager_msgs/srv/{type_name}"
        client = self._client(service, full_type)
        request = get_service(full_type).Request(**fields)
        self._asked_ns = time.time_ns()
        return self._insist(service, lambda: client.call_async(request))

    def _insist(self, service: str, send: Callable[[], ResponseFuture[Any]]) -> Any:
        for attempt in range(1, self._attempts + 1):
            pending, began = send(), time.monotonic()
            if not pending.wait_until_settled(min(_NOT_FROZEN_S, self._call_timeout)):
                self._check_not_frozen(service)
            left = self._call_timeout - (time.monotonic() - began)
            response = pending.wait_for_response(max(0.0, left))
            if response is not None:
                return response
            self._node.get_logger().warning(
                f"Failed getting a result from calling {self.name}/{service} in "
                f"{self._call_timeout}. (Attempt {attempt} of {self._attempts}.)"
            )
        raise ControllerManagerUnavailableError(
            f"Could not successfully call service {self.name}/{service} after "
            f"{self._attempts} attempts."
        )

    def _check_not_frozen(self, service: str) -> None:
        if self._list_client.is_server_frozen():
            raise ControllerManagerUnavailableError(
                f"{self.name} does not answer {service}: its process does nothing at all.",
                hint="It may be stopped (Ctrl-Z, a debugger, kill -STOP): continue it with kill "
                "-CONT, or end it with `teleopctl stop` and start it again; `teleopctl ps` lists "
                "it with its pid.",
            )

    def list_controllers(self) -> list[Any]:
        """Return all controllers, as controller_manager_msgs/ControllerState."""
        return list(self.call("list_controllers", "ListControllers").controller)

    def load_controller(self, name: str) -> bool:
        """Load a controller."""
        return bool(self.call("load_controller", "LoadController", name=name).ok)

    def configure_controller(self, name: str) -> bool:
        """Configure a controller."""
        return bool(self.call("configure_controller", "ConfigureController", name=name).ok)

    def cleanup_controller(self, name: str) -> bool:
        """Clean up a controller."""
        return bool(self.call("cleanup_controller", "CleanupController", name=name).ok)

    def unload_controller(self, name: str) -> bool:
        """Unload a controller."""
        return bool(self.call("unload_controller", "UnloadController", name=name).ok)

    def switch_controllers(
        self,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        *,
        strictness: int = STRICT,
        asap: bool = True,
        timeout: float = 5.0,
    ) -> tuple[bool, str]:
        """Switch controllers; return whether that succeeded, and the manager's message."""
        duration = get_message("builtin_interfaces/msg/Duration")()
        set_stamp(duration, from_seconds(timeout))
        response = self.call(
            "switch_controller",
            "SwitchController",
            activate_controllers=list(activate),
            deactivate_controllers=list(deactivate),
            strictness=strictness,
            activate_asap=asap,
            timeout=duration,
        )
        return bool(response.ok), str(response.message)

    def set_parameter(self, name: str, value: AllowableParameterValue) -> bool:
        """Set a parameter of the manager's node."""
        wanted = [Parameter(name, value=value)]
        response = self._insist("set_parameters", lambda: self._parameters.set_parameters(wanted))
        return all(result.successful for result in response.results)
