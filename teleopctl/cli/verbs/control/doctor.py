"""``teleopctl control doctor``: what keeps controllers from activation or joints from motion."""

import threading
from typing import TYPE_CHECKING

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument
from teleopctl.cli.verbs.control.manager import ManagerOptions
from teleopctl.cli.verbs.doctor.findings import (
    Finding,
    Found,
    print_findings,
    print_findings_as_json,
)
from teleopctl.errors import UnavailableError

if TYPE_CHECKING:
    from teleopctl.cli.verbs.control.diagnosis import ManagerSnapshot
    from teleopctl.control import ControllerManagerClient
    from teleopctl.node import Node
    from teleopctl.wire import Graph

_SERVICES = "services"
_PAUSED = 2  # simulation_interfaces/msg/SimulationState
# Longest wait for a message of a control cycle and for commands that are being published.
_LONGEST_WAIT_S = 1.0


def doctor(
    controller: Annotated[
        str | None, Argument(help="The controller; all by default.", complete="controllers")
    ] = None,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> int:
    """Find what keeps controllers from activation or joints from motion.

    Each finding is followed by the next command to type. The exit status is 1 if a check failed.
    """
    from teleopctl.cli.verbs.control.diagnosis import CHECKS

    found: list[Found] = []
    try:
        with manager.client() as client:
            snapshot = _snapshot(client, controller)
    except UnavailableError as error:
        found.append(Found(_SERVICES, _SERVICES, Finding(error.message, error.hint or "")))
    else:
        found += [
            Found(subject, subject, finding)
            for subject, check in CHECKS.items()
            for finding in check(snapshot, controller)
        ]
    failed = list(dict.fromkeys(one.check for one in found if one.finding.is_error))
    checks = [_SERVICES, *CHECKS]
    if as_json:
        print_findings_as_json(found, checks)
    else:
        print_findings(found, failed, len(checks))
    return 1 if failed else 0


def _snapshot(client: "ControllerManagerClient", controller: str | None) -> "ManagerSnapshot":
    from teleopctl.cli.verbs.control.diagnosis import ManagerSnapshot
    from teleopctl.control import command_ranges

    controllers = client.list_controllers()
    components = client.call("list_hardware_components", "ListHardwareComponents").component
    interfaces = client.call("list_hardware_interfaces", "ListHardwareInterfaces")
    node = client.node
    graph = node.graph()
    received = _Received(node, client.name, _description_topic(graph, client.name))
    snapshot = ManagerSnapshot(client.name, graph=graph)
    for one in controllers:
        if controller in (None, one.name):
            topic = snapshot.topic(one.name, "commands")
            if graph.publishers(topic, _commands_type()):
                received.expect_commands(topic)
    is_paused = _simulation_is_paused(node)
    received.wait(without_values=is_paused)
    return ManagerSnapshot(
        client.name,
        controllers,
        components,
        {
            one.name: bool(one.is_available)
            for one in (*interfaces.command_interfaces, *interfaces.state_interfaces)
        },
        received.values,
        received.is_stopped,
        is_paused,
        graph,
        received.lengths,
        command_ranges(received.description) if received.description else {},
    )


def _description_topic(graph: "Graph", manager: str) -> str:
    """Return the topic from which a manager takes the robot description; empty if unknown."""
    topics = (
        endpoint.name
        for endpoint in graph.endpoints
        if endpoint.kind == "MS" and endpoint.full_name == manager
        if endpoint.name.endswith("robot_description")
    )
    topic = next(topics, "")
    return topic if graph.publishers(topic) else ""


def _commands_type() -> str:
    from teleopctl.cli.verbs.control.diagnosis import COMMANDS_TYPE

    return COMMANDS_TYPE


class _Received:
    """Messages that a controller manager and publishers of commands send within a second."""

    def __init__(self, node: "Node", manager: str, description_topic: str) -> None:
        from teleopctl.interfaces import get_message
        from teleopctl.node import qos_profile_latched

        self.values: dict[str, float] | None = None
        self.is_stopped = False
        self.lengths: dict[str, int] = {}
        self.description = ""
        self._node = node
        self._expected: set[str] = {"values", "stop"}
        self._changed = threading.Condition()
        node.create_subscription(
            get_message("pal_statistics_msgs/msg/Statistics"),
            f"{manager}/introspection_data/full",
            self._take_values,
            1,
            immediate=True,
        )
        node.create_subscription(
            get_message("std_msgs/msg/Bool"),
            f"{manager}/is_stopped",
            self._take_stop,
            qos_profile_latched,
            immediate=True,
        )

        if description_topic:
            self._expected.add("description")
            node.create_subscription(
                get_message("std_msgs/msg/String"),
                description_topic,
                self._take_description,
                qos_profile_latched,
                immediate=True,
            )

    def expect_commands(self, topic: str) -> None:
        """Subscribe to commands that are being published."""
        from teleopctl.interfaces import get_message

        self._expected.add(topic)
        self._node.create_subscription(
            get_message(_commands_type()),
            topic,
            lambda message: self._take_commands(topic, message),
            1,
            immediate=True,
        )

    # Any, here and below: messages of classes that are generated at run time.
    def _take_values(self, message: Any) -> None:
        if self.values is None:
            self.values = {one.name: one.value for one in message.statistics}
            self._arrived("values")

    def _take_stop(self, message: Any) -> None:
        self.is_stopped = bool(message.data)
        self._arrived("stop")

    def _take_description(self, message: Any) -> None:
        self.description = message.data
        self._arrived("description")

    def _take_commands(self, topic: str, message: Any) -> None:
        self.lengths[topic] = len(message.data)
        self._arrived(topic)

    def _arrived(self, what: str) -> None:
        with self._changed:
            self._expected.discard(what)
            self._changed.notify_all()

    def wait(self, *, without_values: bool) -> None:
        """Wait for a message of each kind, at most a second; a paused simulation sends no values.

        Args:
            without_values: Whether no introspection data is expected.
        """
        with self._changed:
            if without_values:
                self._expected.discard("values")
            self._changed.wait_for(lambda: not self._expected, _LONGEST_WAIT_S)


def _simulation_is_paused(node: "Node") -> bool:
    """Return whether a simulation in the graph is paused."""
    from teleopctl.interfaces import get_service

    kind = "simulation_interfaces/srv/GetSimulationState"
    servers = [name for name, types in node.graph().service_names_and_types() if kind in types]
    for name in servers:
        client: Any = node.create_client(get_service(kind), name)
        response = client.call_async(get_service(kind).Request()).wait_for_response(1.0)
        if response is not None and response.state.state == _PAUSED:
            return True
    return False
