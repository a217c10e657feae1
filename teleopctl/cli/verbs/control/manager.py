"""The controller manager that the verbs of ``control`` call, and their options."""

import os

from teleopctl.base.typed import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Callable,
    Iterator,
    Sequence,
    contextmanager,
)
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verb import Argument, Option, OptionSet
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.control import ControllerManagerClient

RosArgs = Annotated[
    list[str] | None,
    Option(
        "--ros-args",
        rest=True,
        help="Arguments of the verb's own node, such as -r __ns:=/left.",
        metavar="ARG",
    ),
]
ControllerName = Annotated[str, Argument(help="The controller.", complete="controllers")]
TargetState = Annotated[
    str, Argument(help="The state.", choices=("unconfigured", "inactive", "active"))
]
DEFAULT_MANAGER = "controller_manager"
# Seconds to wait for a controller manager. The graph is complete at once, so this covers only the
# services of a busy manager.
_WAIT = 1.0
# A running manager responds within milliseconds; a suspended one is left to the client.
_QUICK_S = 2.0


class ManagerOptions(OptionSet):
    """Options that select the controller manager, and arguments of the node that calls it."""

    controller_manager: Annotated[
        str,
        Option(
            "-c",
            "--controller-manager",
            help="Name of the controller manager's node.",
            metavar="NAME",
            complete="controller_managers",
        ),
    ] = DEFAULT_MANAGER
    ros_args: RosArgs = None

    def client(self) -> "AbstractContextManager[ControllerManagerClient]":
        """Return a context with a client of the controller manager; see `manager_client`."""
        return manager_client(self.controller_manager, self.ros_args)

    # Any: the types of services are made at run time.
    def response(self, service: str, kind: str) -> Any:
        """Call a service of the controller manager whose request has no fields.

        Args:
            service: Name of the service.
            kind: Name of its type in controller_manager_msgs.

        Raises:
            TeleopctlError: As for `manager_client`, or no response arrived.
        """
        type_name = f"controller_manager_msgs/srv/{kind}"
        if not self.ros_args:
            response = quick_response(self.controller_manager, service, type_name)
            if response is not None:
                return response
        with self.client() as client:
            return client.call(service, kind)


@contextmanager
def manager_client(
    name: str, ros_args: Sequence[str] | None = None
) -> "Iterator[ControllerManagerClient]":
    """Wait for a controller manager's services, and yield a client of the manager.

    Launch files often run `ros2 control load_controller …` at the same time as the manager, since
    `ros2 control` waits for it. So in a launch, the wait has no time limit.

    Args:
        name: Name of the controller manager; a relative one is in the namespace of the verb's node.
        ros_args: ROS arguments of the verb's node.

    Raises:
        RouterNotRunning: No router runs.
        ControllerManagerUnavailableError: The manager does not exist, or has no services yet.
    """
    from teleopctl.base import progress
    from teleopctl.control import ControllerManagerClient

    with command_node(session_mode="client", ros_args=ros_args or ()) as node:
        client = ControllerManagerClient(node, name)
        in_a_launch = progress.VARIABLE in os.environ
        client.wait(0.0 if in_a_launch else _WAIT, log_waiting=in_a_launch)
        yield client


def manager_option(manager: str) -> tuple[str, ...]:
    """Return the words of a command line that select a manager; none for the default one.

    Args:
        manager: Full name of the controller manager.
    """
    return () if manager == f"/{DEFAULT_MANAGER}" else ("-c", manager)


def command_line(manager: str, verb: str, *words: str) -> str:
    """Return a command line of ``teleopctl control`` for a manager.

    Args:
        manager: Full name of the controller manager.
        verb: Name of the verb.
        words: Arguments and options of the verb.
    """
    return " ".join(("teleopctl control", verb, *manager_option(manager), *words))


def complete_managers(incomplete: str) -> list[str]:
    """Return completion candidates: the controller managers in the graph."""
    from teleopctl.cli.graph_lookup import live_graph
    from teleopctl.control import controller_managers

    try:
        managers = controller_managers(live_graph().endpoints)
    except TeleopctlError:
        return []
    return [name for name in managers if name.startswith(incomplete)]


def complete_controllers(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the loaded controllers."""
    return _controllers(ctx, incomplete)


def complete_active_controllers(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the active controllers."""
    return _controllers(ctx, incomplete, "active")


def complete_inactive_controllers(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the inactive controllers."""
    return _controllers(ctx, incomplete, "inactive")


def _controllers(ctx: "TypedWords", incomplete: str, state: str | None = None) -> list[str]:
    return _from_manager(
        ctx,
        incomplete,
        "list_controllers",
        "controller_manager_msgs/srv/ListControllers",
        lambda found: [one.name for one in found.controller if state in (None, one.state)],
    )


def complete_loadable_controllers(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the controllers whose types the manager's parameters have."""
    return _from_manager(
        ctx,
        incomplete,
        "list_parameters",
        "rcl_interfaces/srv/ListParameters",
        lambda found: [
            name.removesuffix(".type") for name in found.result.names if name.endswith(".type")
        ],
    )


def complete_hardware_components(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the hardware components."""
    return _from_manager(
        ctx,
        incomplete,
        "list_hardware_components",
        "controller_manager_msgs/srv/ListHardwareComponents",
        lambda found: [one.name for one in found.component],
    )


# Any, here and below: responses, whose classes are created at run time.
def _from_manager(
    ctx: "TypedWords",
    incomplete: str,
    service: str,
    type_name: str,
    names: Callable[[Any], list[str]],
) -> list[str]:
    """Return names in the response of a command line's controller manager that begin with a text.

    Args:
        ctx: Words of the command line.
        incomplete: Beginning of the names.
        service: Name of the manager's service.
        type_name: Full type of the service.
        names: Function that returns the names in a response.
    """
    manager = ctx.params.get("controller_manager") or DEFAULT_MANAGER
    found = quick_response(manager, service, type_name)
    return [] if found is None else [each for each in names(found) if each.startswith(incomplete)]


def quick_response(manager: str, service: str, type_name: str) -> Any | None:
    """Call a service of a manager without a node, once; None if nothing responds.

    Takes half the time of `manager_client`, which waits for the manager and explains its absence.

    Args:
        manager: Name of the controller manager.
        service: Name of the service below the manager's name.
        type_name: Full type of the service.
    """
    from teleopctl.cli.graph_lookup import absolute_name
    from teleopctl.interfaces import get_service, type_hash
    from teleopctl.wire import ServiceRequest, close_session, open_session, query_endpoints

    name = f"{absolute_name(manager)}/{service}"
    try:
        session = open_session("client")
    except TeleopctlError:
        return None
    try:
        servers = query_endpoints(session, name).servers(name, type_name)
        if type_hash(type_name) not in [server.type_hash for server in servers]:
            return None
        kind = get_service(type_name)
        return ServiceRequest(session, kind, name, kind.Request()).wait_for_response(_QUICK_S)
    except TeleopctlError:
        return None
    finally:
        close_session(session)
