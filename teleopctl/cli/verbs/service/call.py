"""``teleopctl service call``."""

import sys
import time

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import brief_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.options import ServiceName
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.topic.qos.options import (
    Depth,
    DurabilityName,
    HistoryName,
    LeaseDuration,
    LivelinessName,
    ProfileName,
    QosWishes,
    ReliabilityName,
)
from teleopctl.cli.waiting import wait_aloud
from teleopctl.cli.words.messages import documents_of, message_with, service_class_named
from teleopctl.cli.words.numbers import check_not_negative
from teleopctl.errors import RefusedError, UnavailableError, UsageError, what_there_is
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.node import Client


def call(
    service_name: ServiceName,
    service_type: Annotated[
        str, Argument(help="Its type, such as std_srvs/srv/Trigger.", complete="service_types")
    ],
    values: Annotated[
        str | None,
        Argument(
            help="The request as YAML; fields left out have their defaults.", complete="prototypes"
        ),
    ] = None,
    rate: Annotated[
        float | None,
        Option("-r", "--rate", help="Call again and again, this often.", metavar="HZ"),
    ] = None,
    stdin: Annotated[bool, Option("--stdin", help="Read the request from standard input.")] = False,
    timeout: Annotated[
        float | None,
        Option("--timeout", help="Give up after this many seconds.", metavar="SECONDS"),
    ] = None,
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
    qos_liveliness: LivelinessName = None,
    qos_liveliness_lease_duration_seconds: LeaseDuration = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a response.")] = False,
) -> None:
    """Call a service.

    Without a server it waits for one.
    """
    from teleopctl.interfaces import message_to_dict
    from teleopctl.node import qos_profile_services_default

    if rate is not None and rate <= 0:
        raise RefusedError("rate must be greater than zero")
    check_not_negative(timeout=timeout)
    if stdin and values is not None:
        raise UsageError("--stdin stands in the place of the request; leave one of them out")
    wishes = QosWishes(
        *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
        *(qos_liveliness, qos_liveliness_lease_duration_seconds),
    )
    service_class = service_class_named(service_type)
    text = sys.stdin.read() if stdin else "{}" if values is None else values
    requests = [message_with(service_class.Request, each) for each in documents_of(text)]
    with brief_node() as node:
        client = node.create_client(
            service_class,
            absolute_name(service_name),
            qos_profile=wishes.applied_to(qos_profile_services_default),
        )
        _wait_for_server(client, timeout)
        while True:
            for request in requests:
                started = time.monotonic()
                if not as_json:
                    console.out_text(f"requester: making request: {request!r}\n")
                    console.flush()
                response = client.call_async(request).wait_for_response(timeout)
                if response is None:
                    raise UnavailableError(
                        f"Timed out waiting for response from service {client.service_name} "
                        f"(timeout: {timeout}s)"
                    )
                if as_json:
                    console.out_json(message_to_dict(response), compact=True)
                else:
                    console.out_text(f"response:\n{response!r}\n")
                console.flush()
                if rate is not None:
                    time.sleep(max(0.0, started + 1.0 / rate - time.monotonic()))
            if rate is None:
                return


def _explain(client: "Client[Any, Any]") -> str:
    """The services that there are; of the type that is called if there are some."""
    graph = client.node.graph()
    services = {
        name: types
        for name, types in graph.service_names_and_types()
        if graph.servers(name) and name != client.service_name
    }
    if here := graph.servers(client.service_name):
        return f"'{client.service_name}' has the type {here[0].type_name}, not {client.type_name}."
    fitting = [name for name, types in services.items() if client.type_name in types]
    name = client.service_name
    kind = f" of {client.type_name}" if fitting else ""
    there_is = what_there_is("services", [name], fitting or services, services)
    return f"No service '{name}'{kind} yet. {there_is}"


def _wait_for_server(client: "Client[Any, Any]", longest_wait_s: float | None) -> None:
    name = client.service_name
    servers = query_graph(client.node.context.session).servers(name, client.type_name)
    if not servers:
        console.note("waiting for service to become available...")
        if not wait_aloud(client.wait_for_service, longest_wait_s, lambda: _explain(client)):
            raise UnavailableError(f"No server for '{name}' came within {longest_wait_s:g} s")
        servers = client.node.graph().servers(name, client.type_name)
    from teleopctl.interfaces import type_hash

    ours = type_hash(client.type_name)
    if servers and all(server.type_hash != ours for server in servers):
        raise UnavailableError(
            f"The server of '{name}' ({servers[0].full_name}) means another version of "
            f"{client.type_name}: the type hashes differ",
            hint="Does ROS_DISTRO name its distribution?",
        )
