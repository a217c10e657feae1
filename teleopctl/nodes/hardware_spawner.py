"""``controller_manager/hardware_spawner``: configure or activate hardware components."""

from __future__ import annotations

import argparse
import sys

from teleopctl.control import ControllerManagerClient
from teleopctl.errors import TeleopctlError, existing_names_hint
from teleopctl.interfaces import get_message
from teleopctl.node import ExternalShutdownException, Node, init, parse_ros_arguments, try_shutdown
from teleopctl.nodes.spawner import add_manager_option

# State ids of lifecycle_msgs/msg/State, and the words of ROS 2's log lines.
_HARDWARE_STATES = {"activated": (3, "active"), "configured": (2, "inactive")}


def main(args: list[str] | None = None) -> int:
    """Run ``controller_manager hardware_spawner``: bring hardware up; return the exit status.

    Unlike ROS 2's, it returns 1 if a component is missing or does not reach the state.

    Args:
        args: Command line; None takes ``sys.argv``.
    """
    words = sys.argv[1:] if args is None else args
    options = _hardware_parser().parse_args(parse_ros_arguments(words).program)
    init(args=words, session_mode="client")
    node = Node("hardware_spawner", start_parameter_services=False)
    try:
        client = ControllerManagerClient(node, options.controller_manager)
        client.wait(options.controller_manager_timeout, log_waiting=True)
        names: list[str] = [name for word in options.component_names for name in word.split()]
        reached = [set_hardware_state(node, client, name, options.action) for name in names]
        return 0 if all(reached) else 1
    except ExternalShutdownException:
        return 1
    except TeleopctlError as error:
        node.get_logger().fatal(error.message)
        if error.hint:
            node.get_logger().info(error.hint)
        return 1
    finally:
        node.destroy_node()
        try_shutdown()


def _hardware_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="hardware_spawner", description="Configure or activate hardware components."
    )
    parser.add_argument(
        "component_names", nargs="+", metavar="COMPONENT", help="hardware components"
    )
    add_manager_option(parser)
    parser.add_argument(
        "--controller-manager-timeout",
        type=float,
        default=0.0,
        metavar="S",
        help="seconds to wait for the controller manager; 0 waits forever",
    )
    wanted = parser.add_mutually_exclusive_group(required=True)
    for option, action, text in (
        ("--activate", "activated", "activate the components, configured first if needed"),
        ("--configure", "configured", "configure the components"),
    ):
        wanted.add_argument(option, dest="action", action="store_const", const=action, help=text)
    return parser


def set_hardware_state(
    node: Node, client: ControllerManagerClient, component: str, action: str
) -> bool:
    """Bring a hardware component to a state; log and return whether it has reached it."""
    logger = node.get_logger()
    there = client.call("list_hardware_components", "ListHardwareComponents").component
    known = [each.name for each in there]
    if component not in known:
        logger.warning(
            "Hardware Component is not loaded - state can not be changed. "
            f"{existing_names_hint('hardware components', [component], known)}"
        )
        return False
    number, label = _HARDWARE_STATES[action]
    target = get_message("lifecycle_msgs/msg/State")(id=number, label=label)
    response = client.call(
        "set_hardware_component_state",
        "SetHardwareComponentState",
        name=component,
        target_state=target,
    )
    if not response.ok:
        logger.warning(
            f"Could not {action} component '{component}'. Service call failed. "
            "Wrong component name?"
        )
    elif response.state != target:
        logger.warning(
            f"Could not {action} component '{component}'. Service call returned ok=True, but "
            f"state: {response.state} is not equal to target state '{target}'."
        )
    else:
        logger.info(f"{action} component '{component}'. Hardware now in state: {response.state}.")
        return True
    return False
