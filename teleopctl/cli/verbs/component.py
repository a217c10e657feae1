"""``teleopctl component``: components and their containers, as ``ros2 component``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, OptionSet, Verb, VerbGroup
from teleopctl.errors import (
    NotFoundError,
    RefusedError,
    TeleopctlError,
    UnavailableError,
    UsageError,
    did_you_mean,
    existing_names_hint,
)
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.node import Client, Node
    from teleopctl.wire import Graph


GROUP = VerbGroup(
    "Load nodes into containers.",
    {
        "types": Verb(f"{__name__}:list_types", "List the components that can be loaded."),
        "list": Verb(f"{__name__}:list_containers", "List the loaded components."),
        "load": Verb(
            f"{__name__}:load",
            "Load a component into a container.",
            examples=(
                "teleopctl component load /ComponentManager composition composition::Talker "
                "-n alice -r chatter:=said",
            ),
        ),
        "unload": Verb(f"{__name__}:unload", "Unload components from a container."),
        "standalone": Verb(
            f"{__name__}:standalone",
            "Run a component in a container of its own.",
            examples=("teleopctl component standalone composition composition::Talker",),
        ),
    },
)


ContainerName = Annotated[str, Argument(help="The container.", complete="containers")]
Timeout = Annotated[
    float | None, Option("--timeout", help="Give up after this many seconds.", metavar="SECONDS")
]

# Longest wait for containers' lists, which they return at once.
_LONGEST_WAIT_S = 5.0
_SERVICES = {"load_node": "LoadNode", "unload_node": "UnloadNode", "list_nodes": "ListNodes"}


def list_containers(
    container_name: Annotated[
        str | None, Argument(help="Container; by default all.", complete="containers")
    ] = None,
    containers_only: Annotated[
        bool, Option("--containers-only", help="Print the names of the containers alone.")
    ] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Print the loaded components of one container or all, or the containers' names only."""
    from teleopctl.cli.command_node import command_node

    with command_node(session_mode="client") as node:
        if container_name:
            names = [find_container(node, container_name)]
        else:
            names = container_names(query_graph(node.context.session))
        answers = {} if containers_only else loaded_components(node, names, timeout)
    failures = [answer for answer in answers.values() if isinstance(answer, TeleopctlError)]
    if container_name and failures:
        raise failures[0]
    found = {name: list(_components(answers.get(name))) for name in names}
    if as_json:
        console.out_json(
            names
            if containers_only
            else [
                {"container": name, "components": [{"id": i, "node": n} for i, n in components]}
                for name, components in found.items()
            ]
        )
    elif container_name:
        console.out_lines(f"{number}  {node}" for number, node in found[names[0]])
    else:
        for name, components in found.items():
            console.out(name)
            console.out_lines(f"  {number}  {node}" for number, node in components)
    console.flush()
    for failure in failures:
        console.warn(failure.message)


def container_names(graph: "Graph") -> list[str]:
    """Return the full names of the component containers in a graph, sorted."""
    return [
        name
        for name in dict.fromkeys(graph.node_names(include_hidden=True))
        if all(
            graph.servers(f"{name}/_container/{service}", f"composition_interfaces/srv/{type_}")
            for service, type_ in _SERVICES.items()
        )
    ]


def find_container(node: "Node", name: str) -> str:
    """Return the full name of a component container; raise an error if the graph has none.

    Raises:
        NotFoundError: The graph has no container of that name.
    """
    full_name = absolute_name(name)
    known = container_names(query_graph(node.context.session))
    if full_name not in known:
        raise NotFoundError(
            f"Unable to find container node '{full_name}'",
            hint=existing_names_hint("containers", [full_name], known),
        )
    return full_name


# Any: responses of composition_interfaces, or errors.
def loaded_components(node: "Node", names: list[str], timeout_s: float | None) -> dict[str, Any]:
    """Call list_nodes of containers; return each response or error by container name."""
    from teleopctl.cli.command_node import call_all
    from teleopctl.interfaces import get_service

    class_ = get_service("composition_interfaces/srv/ListNodes")
    longest_s = _LONGEST_WAIT_S if timeout_s is None else timeout_s
    return call_all(node, class_, "_container/list_nodes", names, class_.Request(), longest_s)


def _components(answer: Any) -> list[tuple[int, str]]:
    if answer is None or isinstance(answer, TeleopctlError):
        return []
    return list(zip(map(int, answer.unique_ids), answer.full_node_names, strict=True))


def list_types(
    package_name: Annotated[
        str | None, Argument(help="Package; by default all.", complete="packages")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the components that can be loaded, by package."""
    from teleopctl.packages import list_components, package_names

    types = {
        package: [component.type_name for component in components]
        for package, components in list_components().items()
    }
    if package_name is None:
        if as_json:
            console.out_json(types)
            return
        for package, names in types.items():
            console.out(package)
            console.out_lines(f"  {name}" for name in names)
        return
    if package_name not in types and package_name not in package_names():
        raise NotFoundError(
            f"Unable to find package '{package_name}'",
            hint=did_you_mean(package_name, types),
        )
    names = types.get(package_name, [])
    if as_json:
        console.out_json(names)
    else:
        console.out_lines(names)


_REACHED_WITHIN_S = 2.0
_AGAIN_AFTER_S = 0.05

PackageName = Annotated[
    str, Argument(help="Package of the component.", complete="component_packages")
]
PluginName = Annotated[
    str, Argument(help="Its type, such as composition::Talker.", complete="component_types")
]


class ComponentOptions(OptionSet):
    """Options of a component that is loaded: name, remapping rules, parameters and so on."""

    node_name: Annotated[str | None, Option("-n", "--node-name", help="The node's name.")] = None
    node_namespace: Annotated[
        str | None, Option("--node-namespace", help="The node's namespace.")
    ] = None
    log_level: Annotated[
        str | None, Option("--log-level", help="Log level of the component, by name or number.")
    ] = None
    remap_rules: Annotated[
        list[str] | None,
        Option("-r", "--remap-rule", help="Remapping, as FROM:=TO.", metavar="RULE"),
    ] = None
    parameters: Annotated[
        list[str] | None,
        Option("-p", "--parameter", help="A parameter, as NAME:=VALUE.", metavar="PARAMETER"),
    ] = None
    extra_arguments: Annotated[
        list[str] | None,
        Option(
            "-e", "--extra-argument", help="For the container, as NAME:=VALUE.", metavar="ARGUMENT"
        ),
    ] = None

    # Any: a request of composition_interfaces.
    def request(self, package_name: str, plugin_name: str) -> Any:
        """Return the LoadNode request for a component.

        Raises:
            UsageError: A remapping rule, a parameter or the log level is malformed.
        """
        from teleopctl.interfaces import get_service

        for rule in self.remap_rules or ():
            _name_and_value(rule, "remapping rule")
        return get_service("composition_interfaces/srv/LoadNode").Request(
            package_name=package_name,
            plugin_name=plugin_name,
            node_name=self.node_name or "",
            node_namespace=self.node_namespace or "",
            log_level=0 if self.log_level is None else _log_level(self.log_level),
            remap_rules=self.remap_rules or [],
            parameters=[_parameter(text, "parameter") for text in self.parameters or ()],
            extra_arguments=[
                _parameter(text, "extra argument") for text in self.extra_arguments or ()
            ],
        )


def load(
    container_name: ContainerName,
    package_name: PackageName,
    plugin_name: PluginName,
    *,
    options: ComponentOptions,
    quiet: Annotated[bool, Option("-q", "--quiet", help="Print number and name alone.")] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Load a component into a container."""
    from teleopctl.cli.command_node import command_node

    request = options.request(package_name, plugin_name)
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
    from teleopctl.cli.command_node import command_node
    from teleopctl.interfaces import get_service

    for text in component_ids:
        if not text.isdecimal():
            raise UsageError(f"'{text}' is not a component number")
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
def load_component(node: "Node", container: str, request: Any, timeout_s: float | None) -> Any:
    """Load a component into a container; return the response, or raise an error if it fails.

    Raises:
        RefusedError: The container cannot load the component.
        UnavailableError: The container does not respond.
    """
    from teleopctl.interfaces import get_service

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
    import time

    from teleopctl.cli.waiting import wait_with_notice
    from teleopctl.node import ServiceUnavailableError

    deadline = time.monotonic() + _REACHED_WITHIN_S
    while True:
        future = client.call_async(request)
        wait_with_notice(
            future.wait_until_settled, timeout_s, lambda: f"waiting for {container} to answer..."
        )
        try:
            response = future.wait_for_response(0.0)
        except ServiceUnavailableError:
            # A service may be in the graph a moment before it can be reached.
            if not client.service_is_ready() or time.monotonic() > deadline:
                raise
            time.sleep(_AGAIN_AFTER_S)
            continue
        if response is None:
            raise UnavailableError(f"Container '{container}' did not answer within {timeout_s:g} s")
        return response


def _hint(request: Any) -> str | None:
    """Return a hint with existing names if the package or component is unknown; None otherwise."""
    from teleopctl.packages import find_component

    try:
        find_component(request.package_name, request.plugin_name)
    except NotFoundError as error:
        return error.hint
    return None


def _name_and_value(text: str, what: str) -> tuple[str, str]:
    name, assigned, value = text.partition(":=")
    if not assigned or not name:
        raise UsageError(f"malformed {what} '{text}', expected NAME:=VALUE")
    return name, value


def _parameter(text: str, what: str) -> Any:
    from teleopctl.interfaces import get_message
    from teleopctl.node import parameter_value_from_yaml

    name, value = _name_and_value(text, what)
    message = get_message("rcl_interfaces/msg/Parameter")
    return message(name=name, value=parameter_value_from_yaml(value))


def _log_level(text: str) -> int:
    from teleopctl.node import severity_from_name

    return int(text) if text.isdecimal() and int(text) < 256 else int(severity_from_name(text))


def standalone(
    package_name: PackageName,
    plugin_name: PluginName,
    *,
    options: ComponentOptions,
    container_name: Annotated[
        str | None,
        Option("-c", "--container-node-name", help="Container name; by default a new one."),
    ] = None,
    timeout: Timeout = None,
) -> int:
    """Run a component in a container of its own, until Ctrl-C.

    The container runs in the process of this command.
    """
    import threading
    import uuid

    from teleopctl.cli.command_node import command_node
    from teleopctl.nodes.execute import execute
    from teleopctl.packages import find_executable
    from teleopctl.wire import ensure_router

    request = options.request(package_name, plugin_name)
    ensure_router()
    name = container_name or f"standalone_container_{uuid.uuid4().hex[:12]}"
    failures: list[TeleopctlError] = []
    container = find_executable("rclpy_components", "component_container", builtin=True)
    with command_node(session_mode="client") as node:
        words = (node, absolute_name(name), request, timeout, failures)
        loader = threading.Thread(target=_load, args=words, name="loader")
        loader.start()
        status = execute(container, ["--ros-args", "-r", f"__node:={name}"])
    # The container has ended, so the loader ends too.
    loader.join()
    if failures:
        raise failures[0]
    return status


# Any: a request of composition_interfaces.
def _load(
    node: "Node",
    container: str,
    request: Any,
    timeout_s: float | None,
    failures: list[TeleopctlError],
) -> None:
    """Load the component when the container is ready; shut the container down if that fails."""
    from teleopctl.interfaces import get_service
    from teleopctl.node import (
        ExternalShutdownException,
        ServiceUnavailableError,
        get_default_context,
    )

    class_ = get_service("composition_interfaces/srv/LoadNode")
    client = node.create_client(class_, f"{container}/_container/load_node")
    try:
        if client.wait_for_service():
            load_component(node, container, request, timeout_s)
    except (ExternalShutdownException, ServiceUnavailableError):
        pass  # Ctrl-C has ended the container
    except TeleopctlError as error:
        failures.append(error)
        get_default_context().try_shutdown()
    finally:
        node.context.try_shutdown()


# Longest wait for completion candidates, in seconds.
_LONGEST_COMPLETION_S = 1.0


def complete_containers(incomplete: str) -> list[str]:
    """Return completion candidates: the full names of component containers."""
    from teleopctl.cli.graph_lookup import live_graph

    try:
        return [name for name in container_names(live_graph()) if name.startswith(incomplete)]
    except TeleopctlError:
        return []


def complete_packages(incomplete: str) -> list[str]:
    """Return completion candidates: the packages with components."""
    from teleopctl.packages import list_components

    return [name for name in list_components() if name.startswith(incomplete)]


def complete_types(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the components of the package on the command line."""
    from teleopctl.packages import list_components

    components = list_components().get(ctx.params.get("package_name") or "", ())
    return [each.type_name for each in components if each.type_name.startswith(incomplete)]


def complete_ids(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: numbers of components in the container on the command line."""
    from teleopctl.cli.command_node import command_node

    try:
        with command_node(session_mode="client") as node:
            name = find_container(node, ctx.params.get("container_name") or "")
            answer = loaded_components(node, [name], _LONGEST_COMPLETION_S)[name]
    except TeleopctlError:
        return []
    numbers = [] if isinstance(answer, TeleopctlError) else map(str, answer.unique_ids)
    return [number for number in numbers if number.startswith(incomplete)]
