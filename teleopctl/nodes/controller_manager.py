"""``controller_manager/ros2_control_node``: runs the robot's hardware and its controllers."""

from __future__ import annotations

import contextlib
import sys

from teleopctl.errors import TeleopctlError
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    SingleThreadedExecutor,
    get_default_context,
    init,
    try_shutdown,
)

# Seconds for which a busy service thread may keep the control loop from running.
_SWITCH_INTERVAL = 0.001


def main(args: list[str] | None = None) -> int:
    """Run the controller manager until it is interrupted.

    Args:
        args: Command line; None takes the process's.

    Raises:
        TeleopctlError: A controller manager of the same name runs already.
    """
    arguments = sys.argv if args is None else args
    sys.setswitchinterval(_SWITCH_INTERVAL)
    init(args=arguments)
    try:
        _run(arguments)
    finally:
        try_shutdown()
    return 0


def _run(arguments: list[str]) -> None:
    from teleopctl.control.host import ControllerManagerHost

    # Asked before the node announces itself, so that it does not find itself.
    present = _names_in_graph(get_default_context().domain_id)
    executor = SingleThreadedExecutor()
    node = Node(
        "controller_manager",
        allow_undeclared_parameters=True,
        automatically_declare_parameters_from_overrides=True,
    )
    try:
        name = node.get_fully_qualified_name()
        if name in present:
            raise TeleopctlError(
                f"A node named {name} is already running: there cannot be two controller managers",
                hint="stop it first (`teleopctl ps` shows what runs in the background), or give "
                "this one another name with --ros-args -r __node:=NAME",
            )
        executor.add_node(node)
        host = ControllerManagerHost(node, executor, arguments)
        with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
            executor.spin()
        node.get_logger().info("Shutting down the controller manager")
        host.close()
    finally:
        node.destroy_node()


def _names_in_graph(domain: int) -> list[str]:
    """Full names of all nodes, asked of the router, which knows them without having to wait."""
    from teleopctl.wire.graph import query_graph
    from teleopctl.wire.session import RouterNotRunning, open_session

    try:
        session = open_session("client")
    except RouterNotRunning:
        return []
    try:
        return query_graph(session, domain).node_names(include_hidden=True)
    finally:
        session.close()


if __name__ == "__main__":
    sys.exit(main())
