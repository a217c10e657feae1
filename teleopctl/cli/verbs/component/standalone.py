"""``teleopctl component standalone``."""

import threading
import uuid

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli.command_node import command_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.component.containers import Timeout
from teleopctl.cli.verbs.component.loading import (
    ExtraArguments,
    LogLevel,
    Namespace,
    NodeName,
    PackageName,
    Parameters,
    PluginName,
    Remaps,
    load_component,
    load_request,
)
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    ServiceUnavailableError,
    get_default_context,
)
from teleopctl.packages import find_executable


def standalone(
    package_name: PackageName,
    plugin_name: PluginName,
    node_name: NodeName = None,
    node_namespace: Namespace = None,
    log_level: LogLevel = None,
    remap_rules: Remaps = None,
    parameters: Parameters = None,
    extra_arguments: ExtraArguments = None,
    container_name: Annotated[
        str | None,
        Option("-c", "--container-node-name", help="The container's name; otherwise a new one."),
    ] = None,
    timeout: Timeout = None,
) -> int:
    """Run a component in a container of its own, until Ctrl-C.

    The container is this process.
    """
    from teleopctl.nodes.execute import execute
    from teleopctl.wire import ensure_router

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
    ensure_router()
    name = container_name or f"standalone_container_{uuid.uuid4().hex[:12]}"
    failures: list[TeleopctlError] = []
    container = find_executable("rclpy_components", "component_container", builtin=True)
    with command_node(session_mode="client") as node:
        words = (node, absolute_name(name), request, timeout, failures)
        loader = threading.Thread(target=_load, args=words, name="loader")
        loader.start()
        status = execute(container, ["--ros-args", "-r", f"__node:={name}"])
    # It has nobody to wait for any more.
    loader.join()
    if failures:
        raise failures[0]
    return status


# Any: a request of composition_interfaces.
def _load(
    node: Node,
    container: str,
    request: Any,
    timeout_s: float | None,
    failures: list[TeleopctlError],
) -> None:
    """Load the component once the container is there, and end the container where that fails."""
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
