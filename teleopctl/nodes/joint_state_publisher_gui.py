"""Executable ``joint_state_publisher_gui``: joint_state_publisher with sliders on a web page.

The sliders are part of the viewer's page. If a viewer runs already, this node subscribes to its
sliders; otherwise the node serves a page of its own, with the robot and the sliders.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys

from teleopctl.node import (
    Clock,
    ClockType,
    ExternalShutdownException,
    Node,
    SingleThreadedExecutor,
    init,
    parse_ros_arguments,
)
from teleopctl.nodes.joint_state_publisher import JointStatePublisher, read_description
from teleopctl.nodes.rviz2 import add_page_options, report_address

_NAME = "joint_state_publisher_gui"
# Names of the viewer in launch files that start it together with this node, and the seconds within
# which it is in the graph.
_PAGES = ("rviz", "rviz2")
_TIMEOUT_S = 3.0


def main(args: list[str] | None = None) -> int:
    """Run ``joint_state_publisher_gui`` until Ctrl-C, with a page of sliders unless a page runs.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        TeleopctlError: The file cannot be read, a parameter is wrong or the page cannot be opened.
    """
    from teleopctl.viewer import SLIDERS_TOPIC

    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(prog=_NAME)
    parser.add_argument("urdf_file", nargs="?", help="URDF file, instead of the topic")
    add_page_options(parser)
    options = parser.parse_args(parse_ros_arguments(words).program)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=words),
        contextlib.ExitStack() as stack,
    ):
        urdf = read_description(options.urdf_file)
        node = stack.enter_context(JointStatePublisher(urdf, name=_NAME, sources=[SLIDERS_TOPIC]))
        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def look() -> None:
            node.destroy_timer(timer)
            page = _page_of(node) or _viewer_of_this_launch()
            if page is not None:
                node.get_logger().info(
                    f"The sliders are in the panel Joints of the page that {page} serves"
                )
            else:
                executor.add_node(stack.enter_context(_open(node, options)))

        timer = node.create_timer(_TIMEOUT_S, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        executor.spin()
    return 0


def _page_of(node: Node) -> str | None:
    pages = [entry.full_name for entry in node.graph().nodes if entry.name in _PAGES]
    return pages[0] if pages else None


def _viewer_of_this_launch() -> str | None:
    """Return the program of the viewer that the same launch has started; None without one.

    The viewer may have another name, or may not be in the graph yet on a busy machine.
    """
    import psutil

    with contextlib.suppress(psutil.Error):
        for sibling in psutil.Process(os.getppid()).children():
            with contextlib.suppress(psutil.Error):
                words = sibling.cmdline()
                if "teleopctl.nodes" in words and "rviz2" in words:
                    return "rviz2"
    return None


def _open(node: Node, options: argparse.Namespace) -> Node:
    from teleopctl.viewer import load_layout, open_viewer

    viewer, address = open_viewer(
        options.host,
        options.port,
        options.token_file,
        layout=load_layout("sliders"),
        # A launch file's name for this node must not rename the viewer.
        cli_args=["--ros-args", "-r", "__node:=rviz"],
    )
    node.get_logger().info(f"The sliders are at {address.url}")
    report_address(address, open_it=options.open)
    return viewer
