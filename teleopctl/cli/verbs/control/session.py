"""A short-lived node that asks a controller manager, and what its verbs are told."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from teleopctl.base import progress
from teleopctl.base.typed import Annotated
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verb import Argument, Option
from teleopctl.control import ControllerManagerClient

ManagerName = Annotated[
    str,
    Option(
        "-c", "--controller-manager", help="Name of the controller manager's node.", metavar="NAME"
    ),
]
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
# Seconds to wait for a manager: it is in the graph or it is not, so only a busy one needs any.
_WAIT = 1.0


@contextmanager
def manager_client(
    name: str, ros_args: Sequence[str] | None = None
) -> Iterator[ControllerManagerClient]:
    """Return a client of a controller manager, once that answers.

    In a launch file `ros2 control load_controller …` often stands beside what starts the manager,
    since `ros2 control` waits for it: so does this there.

    Args:
        name: The manager's name; a relative one is in the namespace of the node that asks.
        ros_args: Of that node.

    Raises:
        RouterNotRunning: No router answers.
        ControllerManagerUnavailableError: There is no such manager, or it has no services yet.
    """
    with command_node(session_mode="client", ros_args=ros_args or ()) as node:
        client = ControllerManagerClient(node, name)
        in_a_launch = progress.VARIABLE in os.environ
        client.wait(0.0 if in_a_launch else _WAIT, patient=in_a_launch)
        yield client
