"""``controller_manager/unspawner``: deactivates and unloads controllers."""

from __future__ import annotations

import argparse
import sys

from teleopctl.control import ControllerManagerClient
from teleopctl.errors import TeleopctlError
from teleopctl.node import ExternalShutdownException, Node, init, parse_ros_arguments, try_shutdown


def main(args: list[str] | None = None) -> int:
    """Run the unspawner, and return the exit status.

    Args:
        args: Command line; None takes the process's.
    """
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="unspawner", description="Deactivate and unload controllers."
    )
    parser.add_argument("controller_names", nargs="+", metavar="NAME", help="controllers")
    parser.add_argument(
        "-c",
        "--controller-manager",
        default="controller_manager",
        metavar="NAME",
        help="name of the controller manager's node",
    )
    parser.add_argument("--switch-timeout", type=float, default=5.0, metavar="S")
    options = parser.parse_args(parse_ros_arguments(words).program)
    names: list[str] = options.controller_names
    init(args=words, session_mode="client")
    node = Node(f"unspawner_{names[0]}", start_parameter_services=False)
    logger = node.get_logger()
    try:
        client = ControllerManagerClient(node, options.controller_manager)
        client.wait(10.0)
        active = [
            controller.name
            for controller in client.list_controllers()
            if controller.name in names and controller.state == "active"
        ]
        if active and client.switch_controllers((), active, timeout=options.switch_timeout)[0]:
            logger.info("Deactivated controller")
        for name in names:
            if not client.unload_controller(name):
                logger.error("Failed to unload controller")
                return 1
            logger.info("Unloaded controller")
    except ExternalShutdownException:
        return 1
    except TeleopctlError as error:
        logger.fatal(error.message)
        if error.hint:
            logger.info(error.hint)
        return 1
    finally:
        node.destroy_node()
        try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
