"""Executable ``controller_manager/ros2_control_node``: hardware and controllers of a robot."""

from __future__ import annotations

import contextlib
import sys

from teleopctl.base import progress
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    SingleThreadedExecutor,
    init,
    try_shutdown,
)
from teleopctl.nodes.single_instance import require_single_instance

# Seconds for which a busy service thread may keep the control loop from running.
_SWITCH_INTERVAL = 0.001


def main(args: list[str] | None = None) -> int:
    """Run the node ``controller_manager`` until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        TeleopctlError: A controller manager of the same name runs already.
    """
    arguments = sys.argv if args is None else args
    sys.setswitchinterval(_SWITCH_INTERVAL)
    init(args=arguments, publishes_after_signal=True)
    try:
        _run(arguments)
    finally:
        try_shutdown()
    return 0


def _run(arguments: list[str]) -> None:
    from teleopctl.control import ControllerManagerNode

    progress.report(progress.STARTING)
    executor = SingleThreadedExecutor()
    node = Node(
        "controller_manager",
        allow_undeclared_parameters=True,
        automatically_declare_parameters_from_overrides=True,
    )
    try:
        require_single_instance(node)
        executor.add_node(node)
        manager_node = ControllerManagerNode(node, executor, arguments)
        with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
            executor.spin()
        node.get_logger().info("Shutting down the controller manager")
        manager_node.close()
    finally:
        node.destroy_node()


if __name__ == "__main__":
    sys.exit(main())
