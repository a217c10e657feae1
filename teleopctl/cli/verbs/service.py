"""``teleopctl service``: services, their types, calls and events, as ``ros2 service``."""

import sys

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Iterator, Sequence
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name, live_graph
from teleopctl.cli.listing import names_of_type, out_names, out_types, types_of
from teleopctl.cli.options import (
    AsJson,
    CountServices,
    HiddenServices,
    ServiceName,
    UseSimTime,
    check_not_negative,
)
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.cli.verbs.topic.qos import QosOptions
from teleopctl.cli.verbs.topic.text import TextOptions
from teleopctl.errors import (
    NotFoundError,
    RefusedError,
    UnavailableError,
    UsageError,
    existing_names_hint,
)
from teleopctl.wire import query_endpoints

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken, Graph


GROUP = VerbGroup(
    "List, call and watch services.",
    {
        "list": Verb(f"{__name__}:list_services", "List the services."),
        "type": Verb(f"{__name__}:service_type", "Print the type of a service."),
        "find": Verb(f"{__name__}:services_of_type", "List the services of a type."),
        "info": Verb(f"{__name__}:service_info", "Show the servers and clients of a service."),
        "call": Verb(
            f"{__name__}:call",
            "Call a service.",
            examples=(
                "teleopctl service call /mujoco_sim/set_pause "
                'mujoco_ros2_control_msgs/srv/SetPause "{paused: true}"',
            ),
        ),
        "echo": Verb(
            f"{__name__}:echo",
            "Print the requests and responses of a service.",
            examples=("teleopctl service echo /add_two_ints --flow-style",),
        ),
    },
    leaves_nothing=True,
)


def list_services(
    show_types: Annotated[
        bool, Option("-t", "--show-types", help="Show the type of each service.")
    ] = False,
    count_services: CountServices = False,
    include_hidden: HiddenServices = False,
    as_json: AsJson = False,
) -> None:
    """List the services."""
    graph = live_graph()
    services = graph.service_names_and_types(include_hidden)
    if as_json:
        console.out_json(
            [
                {"name": name, "types": types, "servers": len(graph.servers(name))}
                for name, types in services
            ]
        )
    else:
        out_names(services, only_count=count_services, show_types=show_types)


def service_type(service_name: ServiceName, as_json: AsJson = False) -> None:
    """Print the type of a service."""
    services = live_graph().service_names_and_types(include_hidden=True)
    out_types(types_of(absolute_name(service_name), services, kind="service"), as_json=as_json)


def services_of_type(
    type_name: Annotated[
        str, Argument(help="The service type.", metavar="TYPE", complete="service_types")
    ],
    count_services: CountServices = False,
    include_hidden: HiddenServices = False,
    as_json: AsJson = False,
) -> None:
    """List the services of a type."""
    services = live_graph().service_names_and_types(include_hidden)
    found = names_of_type(type_name, services, kind="srv")
    out_names(found, only_count=count_services, as_json=as_json)


def service_info(
    service_name: ServiceName,
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="Show each client and server with its QoS.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the types, servers and clients of a service."""
    from teleopctl.cli.verbs.topic.endpoints import endpoint_record, warn_of_type_mismatch

    service = absolute_name(service_name)
    graph = live_graph()
    clients, servers = graph.clients(service), graph.servers(service)
    types = types_of(service, graph.service_names_and_types(include_hidden=True), kind="service")
    if as_json:
        console.out_json(
            {
                "name": service,
                "types": list(types),
                "clients": [endpoint_record(endpoint) for endpoint in clients],
                "servers": [endpoint_record(endpoint) for endpoint in servers],
            }
        )
    else:
        console.out_lines(_lines(types, clients, servers, verbose=verbose))
    console.flush()
    warn_of_type_mismatch(service, [*servers, *clients])


def _lines(
    types: Sequence[str],
    clients: Sequence["EndpointToken"],
    servers: Sequence["EndpointToken"],
    *,
    verbose: bool,
) -> Iterator[str]:
    from teleopctl.cli.verbs.topic.endpoints import endpoint_lines

    end = [""] if verbose else []
    yield from (f"Type: {types[0] if len(types) == 1 else list(types)}", *end)
    for title, role, endpoints in (("Clients", "CLIENT", clients), ("Services", "SERVER", servers)):
        yield from (f"{title} count: {len(endpoints)}", *end)
        if verbose:
            for endpoint in endpoints:
                yield from endpoint_lines(endpoint, "Service", role)


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
        Option("-r", "--rate", help="Call repeatedly at this rate.", metavar="HZ"),
    ] = None,
    stdin: Annotated[bool, Option("--stdin", help="Read the request from standard input.")] = False,
    timeout: Annotated[
        float | None,
        Option("--timeout", help="Give up after this many seconds.", metavar="SECONDS"),
    ] = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a response.")] = False,
    *,
    qos: QosOptions,
) -> None:
    """Call a service, once or at a rate, and print the responses; wait for a missing server.

    Waits for a server if there is none. Requests on Zenoh have no QoS: its options have no effect.
    """
    import time

    from teleopctl.cli.messages import message_from_values, service_class_named, yaml_documents
    from teleopctl.interfaces import message_to_dict
    from teleopctl.wire import ServiceRequest, close_session, open_session

    del qos
    if rate is not None and rate <= 0:
        raise RefusedError("rate must be greater than zero")
    check_not_negative(timeout=timeout)
    if stdin and values is not None:
        raise UsageError("--stdin replaces the request argument; give one of them")
    service_class = service_class_named(service_type)
    text = sys.stdin.read() if stdin else "{}" if values is None else values
    requests = [message_from_values(service_class.Request, each) for each in yaml_documents(text)]
    service = absolute_name(service_name)
    session = open_session("client")
    try:
        _wait_for_server(
            query_endpoints(session, service), service, service_class.TYPE_NAME, timeout
        )
        while True:
            for request in requests:
                started = time.monotonic()
                if not as_json:
                    console.out_text(f"requester: making request: {request!r}\n")
                    console.flush()
                sent = ServiceRequest(session, service_class, service, request)
                response = sent.wait_for_response(timeout)
                if response is None:
                    raise UnavailableError(
                        f"Timed out waiting for response from service {service} "
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
    finally:
        close_session(session)


def _explain(graph: "Graph", name: str, type_name: str) -> str:
    """Return a hint while waiting: existing services, of the type if there are any."""
    services = {
        other: types
        for other, types in graph.service_names_and_types()
        if graph.servers(other) and other != name
    }
    fitting = [other for other, types in services.items() if type_name in types]
    kind = f" of {type_name}" if fitting else ""
    hint = existing_names_hint("services", [name], fitting or services, services)
    return f"No service '{name}'{kind} yet. {hint}"


def _wait_for_server(
    graph: "Graph", name: str, type_name: str, longest_wait_s: float | None
) -> None:
    """Wait for a server of a service, with a notice.

    Raises:
        UnavailableError: The service has another type or another version of the type, or no server
            came within the time.
    """
    if not graph.servers(name):
        from teleopctl.cli.command_node import brief_node
        from teleopctl.cli.waiting import wait_with_notice
        from teleopctl.node import validate_absolute_name
        from teleopctl.wire import EntityKind

        validate_absolute_name(name, is_service=True)
        console.note("waiting for service to become available...")
        with brief_node() as node:
            if not wait_with_notice(
                lambda wait_s: node.wait_for_match(EntityKind.SS, name, None, 1, wait_s),
                longest_wait_s,
                lambda: _explain(node.graph(), name, type_name),
            ):
                raise UnavailableError(f"No server for '{name}' came within {longest_wait_s:g} s")
            graph = node.graph()
    servers = graph.servers(name, type_name)
    if not servers:
        other = graph.servers(name)[0].type_name
        raise UnavailableError(
            f"'{name}' has the type {other}, not {type_name}",
            hint=f"teleopctl service call {name} {other}",
        )
    from teleopctl.interfaces import type_hash

    ours = type_hash(type_name)
    if all(server.type_hash != ours for server in servers):
        raise UnavailableError(
            f"The server of '{name}' ({servers[0].full_name}) means another version of "
            f"{type_name}: the type hashes differ",
            hint="Does ROS_DISTRO name its distribution?",
        )


def echo(
    service_name: ServiceName,
    service_type: Annotated[
        str | None,
        Argument(help="Type; by default the one in the graph.", complete="service_types"),
    ] = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object an event.")] = False,
    use_sim_time: UseSimTime = False,
    *,
    text: TextOptions,
    qos: QosOptions,
) -> None:
    """Print the introspection events (requests and responses) of a service until Ctrl-C.

    Service introspection must be enabled on the client or the server, by parameters of the node or
    rclpy's configure_introspection. Ends on Ctrl-C.
    """
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.messages import service_class_named
    from teleopctl.cli.verbs.topic.text import json_value
    from teleopctl.node import SingleThreadedExecutor, qos_profile_services_default
    from teleopctl.wire import EntityKind

    service = absolute_name(service_name)
    service_class = service_class_named(service_type or _type_of(service))
    style = text.style(as_json=as_json)

    # Any: event of any service.
    def receive(event: Any) -> None:
        if as_json:
            console.out_json(json_value(event), compact=True)
        elif text.csv:
            console.out(style.csv(event))
        else:
            console.out_text(f"{style.event(event)}---")
        console.flush()

    topic = f"{service}/_service_event"
    with (
        command_node(use_sim_time=use_sim_time) as node,
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        node.create_subscription(
            service_class.Event, topic, receive, qos.applied_to(qos_profile_services_default)
        )
        event_type = service_class.Event.TYPE_NAME
        if not node.wait_for_match(EntityKind.MP, topic, event_type, 1, 0.0):
            console.note(
                f"No publishers on topic '{topic}'; is service introspection on the client or "
                "server enabled?"
            )
        executor.add_node(node)
        executor.spin()


def _type_of(service: str) -> str:
    """Return the type of a service in the graph.

    Raises:
        NotFoundError: The service has no server or client.
        RefusedError: The service has several types.
    """
    known = live_graph().service_names_and_types(include_hidden=True)
    try:
        types = types_of(service, known, kind="service")
    except NotFoundError as error:
        raise NotFoundError(f"Cannot find type for '{service}'", hint=error.hint) from error
    if len(types) > 1:
        raise RefusedError(
            f"More than one type associated with service '{service}'",
            hint=f"Give the type explicitly: {' or '.join(types)}.",
        )
    return types[0]
