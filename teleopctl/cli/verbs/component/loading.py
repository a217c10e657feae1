"""``teleopctl component load`` and ``unload``."""

import time

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.component.containers import ContainerName, Timeout, find_container
from teleopctl.cli.waiting import wait_aloud
from teleopctl.errors import NotFoundError, RefusedError, UnavailableError, UsageError
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import ServiceUnavailableError
from teleopctl.packages import find_component

if TYPE_CHECKING:
    from teleopctl.node import Client, Node

_REACHED_WITHIN_S = 2.0
_AGAIN_AFTER_S = 0.05

PackageName = Annotated[
    str, Argument(help="The package that brings it.", complete="component_packages")
]
PluginName = Annotated[
    str, Argument(help="Its type, such as composition::Talker.", complete="component_types")
]
NodeName = Annotated[str | None, Option("-n", "--node-name", help="The node's name.")]
Namespace = Annotated[str | None, Option("--node-namespace", help="The node's namespace.")]
LogLevel = Annotated[
    str | None, Option("--log-level", help="The level of its logger, by name or number.")
]
Remaps = Annotated[
    list[str] | None,
    Option("-r", "--remap-rule", help="Another name, as FROM:=TO.", metavar="RULE"),
]
Parameters = Annotated[
    list[str] | None,
    Option("-p", "--parameter", help="A parameter, as NAME:=VALUE.", metavar="PARAMETER"),
]
ExtraArguments = Annotated[
    list[str] | None,
    Option("-e", "--extra-argument", help="For the container, as NAME:=VALUE.", metavar="ARGUMENT"),
]


def load(
    container_name: ContainerName,
    package_name: PackageName,
    plugin_name: PluginName,
    node_name: NodeName = None,
    node_namespace: Namespace = None,
    log_level: LogLevel = None,
    remap_rules: Remaps = None,
    parameters: Parameters = None,
    extra_arguments: ExtraArguments = None,
    quiet: Annotated[bool, Option("-q", "--quiet", help="Print number and name alone.")] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Load a component into a container."""
    request = load_request(
        package_name,
        plugin_name,
        node_name=node_name,
        node_namespace=node_namespace,
        log_level=log_level,
        remap_rules=remap_rules,
        parameters=parameters,
        extra_arguments=extra_arguments,
    )
    with command_node(session_mode="client") as node:
        container = find_container(node, container_name)
        response = load_component(node, container, request, timeout)
    number, name = int(response.unique_id), response.full_node_name
    if as_json:
        console.out_json({"container": container, "id": number, "node": name})
    elif quiet:
        console.out(f"{number}  {name}")
    else:
        console.out(f"Loaded component {number} into '{container}' container node as '{name}'")


def unload(
    container_name: ContainerName,
    component_ids: Annotated[
        list[str],
        Argument(help="Their numbers, as list prints them.", complete="component_ids"),
    ],
    quiet: Annotated[bool, Option("-q", "--quiet", help="Print the numbers alone.")] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Unload components from a container."""
    for text in component_ids:
        if not text.isdecimal():
            raise UsageError(f"'{text}' is no number of a component")
    class_ = get_service("composition_interfaces/srv/UnloadNode")
    with command_node(session_mode="client") as node:
        container = find_container(node, container_name)
        client = node.create_client(class_, f"{container}/_container/unload_node")
        for number in map(int, component_ids):
            answer = _answer(client, class_.Request(unique_id=number), container, timeout)
            if not answer.success:
                raise RefusedError(
                    f"Failed to unload component {number} from '{container}' container node\n"
                    f"    {answer.error_message}",
                    hint=f"`teleopctl component list {container}` prints those that there are.",
                )
            if as_json:
                console.out_json({"container": container, "id": number}, compact=True)
            elif quiet:
                console.out(str(number))
            else:
                console.out(f"Unloaded component {number} from '{container}' container node")
            console.flush()


# Any, here and below: requests and responses of composition_interfaces.
def load_request(
    package_name: str,
    plugin_name: str,
    *,
    node_name: str | None,
    node_namespace: str | None,
    log_level: str | None,
    remap_rules: list[str] | None,
    parameters: list[str] | None,
    extra_arguments: list[str] | None,
) -> Any:
    """Return the LoadNode request for a component.

    Raises:
        UsageError: A rule, a parameter or a level is malformed.
    """
    for rule in remap_rules or ():
        _parted(rule, "remapping rule")
    return get_service("composition_interfaces/srv/LoadNode").Request(
        package_name=package_name,
        plugin_name=plugin_name,
        node_name=node_name or "",
        node_namespace=node_namespace or "",
        log_level=0 if log_level is None else _level(log_level),
        remap_rules=remap_rules or [],
        parameters=[_parameter(text, "parameter") for text in parameters or ()],
        extra_arguments=[_parameter(text, "extra argument") for text in extra_arguments or ()],
    )


def load_component(node: "Node", container: str, request: Any, timeout_s: float | None) -> Any:
    """Load a component into a container; its constructor may take long.

    Raises:
        RefusedError: It cannot.
        UnavailableError: It does not answer.
    """
    class_ = get_service("composition_interfaces/srv/LoadNode")
    client = node.create_client(class_, f"{container}/_container/load_node")
    response = _answer(client, request, container, timeout_s)
    if not response.success:
        message: str = response.error_message
        raise RefusedError(
            f"Failed to load component: {message[:1].upper()}{message[1:]}", hint=_hint(request)
        )
    return response


def _answer(
    client: "Client[Any, Any]", request: Any, container: str, timeout_s: float | None
) -> Any:
    deadline = time.monotonic() + _REACHED_WITHIN_S
    while True:
        future = client.call_async(request)
        wait_aloud(
            future.wait_until_settled, timeout_s, lambda: f"waiting for {container} to answer..."
        )
        try:
            response = future.wait_for_response(0.0)
        except ServiceUnavailableError:
            # A service may stand in the graph a moment before it can be reached.
            if not client.service_is_ready() or time.monotonic() > deadline:
                raise
            time.sleep(_AGAIN_AFTER_S)
            continue
        if response is None:
            raise UnavailableError(f"Container '{container}' did not answer within {timeout_s:g} s")
        return response


def _hint(request: Any) -> str | None:
    """What there is instead, where that is what is wrong."""
    try:
        find_component(request.package_name, request.plugin_name)
    except NotFoundError as error:
        return error.hint
    return None


def _parted(text: str, what: str) -> tuple[str, str]:
    name, assigned, value = text.partition(":=")
    if not assigned or not name:
        raise UsageError(f"malformed {what} '{text}', expected NAME:=VALUE")
    return name, value


def _parameter(text: str, what: str) -> Any:
    from teleopctl.node import parameter_value_from_yaml

    name, value = _parted(text, what)
    message = get_message("rcl_interfaces/msg/Parameter")
    return message(name=name, value=parameter_value_from_yaml(value))


def _level(text: str) -> int:
    from teleopctl.node import severity_from_name

    return int(text) if text.isdecimal() and int(text) < 256 else int(severity_from_name(text))
