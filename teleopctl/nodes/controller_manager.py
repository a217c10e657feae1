"""Executable ``controller_manager/ros2_control_node``: hardware and controllers of a robot."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from teleopctl.base import progress
from teleopctl.errors import TeleopctlError
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    SingleThreadedExecutor,
    init,
    try_shutdown,
)
from teleopctl.nodes.single_instance import require_single_instance

if TYPE_CHECKING:
    from teleopctl.node import Executor

# Seconds for which a busy service thread may keep the control loop from running; the thread's work
# takes no longer than with Python's 5 ms.
_SWITCH_INTERVAL = 0.0001


def main(args: list[str] | None = None) -> int:
    """Run the node ``controller_manager`` until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        TeleopctlError: A controller manager of the same name runs already.
    """
    arguments = sys.argv if args is None else args
    init(args=arguments, publishes_after_signal=True)
    try:
        with (
            controller_manager(arguments) as executor,
            contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        ):
            executor.spin()
    finally:
        try_shutdown()
    return 0


@contextlib.contextmanager
def controller_manager(
    arguments: Sequence[str],
    *,
    is_process: bool = True,
    prepare: Callable[[Node], object] = lambda _: None,
    on_failure: Callable[[TeleopctlError], object] | None = None,
    simulation_started: threading.Event | None = None,
) -> Iterator[Executor]:
    """Context manager that makes a controller manager and its executor, and ends the manager.

    Args:
        arguments: Command line with the manager's ROS arguments.
        is_process: Whether they are those of the whole process.
        prepare: Called with the manager's node before the robot description is received.
        on_failure: See `ControllerManagerNode`.
        simulation_started: See `ControllerManagerNode`.

    Raises:
        TeleopctlError: A controller manager of the same name runs already, or a parameter is
            invalid.
    """
    from teleopctl.control import ControllerManagerNode

    progress.report(progress.STARTING, part=progress.CONTROL)
    sys.setswitchinterval(_SWITCH_INTERVAL)
    executor = SingleThreadedExecutor()
    node = Node(
        "controller_manager",
        cli_args=None if is_process else list(arguments),
        use_global_arguments=is_process,
        allow_undeclared_parameters=True,
        automatically_declare_parameters_from_overrides=True,
    )
    try:
        require_single_instance(node)
        prepare(node)
        executor.add_node(node)
        manager_node = ControllerManagerNode(
            node,
            executor,
            arguments,
            on_failure=on_failure,
            simulation_started=simulation_started,
        )
        try:
            yield executor
        finally:
            node.get_logger().info("Shutting down the controller manager")
            manager_node.close()
    finally:
        node.destroy_node()


if __name__ == "__main__":
    sys.exit(main())
