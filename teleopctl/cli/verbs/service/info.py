"""``teleopctl service info``."""

from collections.abc import Iterator, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.listing import types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import AsJson, ServiceName
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.topic.endpoint_text import (
    endpoint_block,
    endpoint_record,
    warn_of_mismatch,
)

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken


def service_info(
    service_name: ServiceName,
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="Show each client and server with its QoS.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Show who serves and calls a service."""
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
    warn_of_mismatch(service, [*servers, *clients])


def _lines(
    types: Sequence[str],
    clients: Sequence["EndpointToken"],
    servers: Sequence["EndpointToken"],
    *,
    verbose: bool,
) -> Iterator[str]:
    end = [""] if verbose else []
    yield from (f"Type: {types[0] if len(types) == 1 else list(types)}", *end)
    for title, role, endpoints in (("Clients", "CLIENT", clients), ("Services", "SERVER", servers)):
        yield from (f"{title} count: {len(endpoints)}", *end)
        if verbose:
            for endpoint in endpoints:
                yield from endpoint_block(endpoint, "Service", role)
