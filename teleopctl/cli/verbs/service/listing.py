"""``teleopctl service list``, ``type`` and ``find``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.listing import of_type, out_names, out_types, types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import AsJson, CountServices, HiddenServices, ServiceName
from teleopctl.cli.verb import Argument, Option


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
    found = of_type(type_name, services, kind="srv")
    out_names(found, only_count=count_services, as_json=as_json)
