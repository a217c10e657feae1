"""The controller manager that the verbs of ``control`` call, and their options."""

import os
from contextlib import AbstractContextManager, contextmanager

from teleopctl.base import progress
from teleopctl.base.typed import TYPE_CHECKING, Annotated, Callable, Iterator, Sequence
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verb import Argument, Option, OptionSet
from teleopctl.control import ControllerManagerClient, controller_managers
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords

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


@contextmanager
def manager_client(
    name: str, ros_args: Sequence[str] | None = None
) -> Iterator[ControllerManagerClient]:
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
        lambda client: [
            one.name for one in client.list_controllers() if state in (None, one.state)
        ],
    )


def complete_loadable_controllers(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the controllers whose types the manager's parameters have."""

    def loadable(client: ControllerManagerClient) -> list[str]:
        found = client.call("list_parameters", "rcl_interfaces/srv/ListParameters").result.names
        return [name.removesuffix(".type") for name in found if name.endswith(".type")]

    return _from_manager(ctx, incomplete, loadable)


def complete_hardware_components(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the hardware components."""

    def components(client: ControllerManagerClient) -> list[str]:
        found = client.call("list_hardware_components", "ListHardwareComponents").component
        return [one.name for one in found]

    return _from_manager(ctx, incomplete, components)


def _from_manager(
    ctx: "TypedWords", incomplete: str, names: Callable[[ControllerManagerClient], list[str]]
) -> list[str]:
    """Return names from the controller manager of a command line that begin with a text."""
    from teleopctl.cli.completion.candidates import nodes

    manager = ctx.params.get("controller_manager") or DEFAULT_MANAGER
    # The client waits a moment for a missing manager, so the graph is checked first.
    if f"/{manager.removeprefix('/')}" not in nodes(""):
        return []
    try:
        with manager_client(manager) as client:
            found = names(client)
    except TeleopctlError:
        return []
    return [name for name in found if name.startswith(incomplete)]
