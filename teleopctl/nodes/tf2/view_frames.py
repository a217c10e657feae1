"""``tf2_tools view_frames``: the tree of frames as files, after five seconds."""

from __future__ import annotations

import argparse
import sys

from teleopctl.node import Node, init, parse_ros_arguments
from teleopctl.nodes.tf2.frames_view import WAIT_S, view_frames
from teleopctl.tf import TF_STATIC_TOPIC, TF_TOPIC


def main(args: list[str] | None = None) -> int:
    """Record transforms, and write the frame tree as PDF and Graphviz files.

    Args:
        args: Command line; None takes the process's.

    Raises:
        TeleopctlError: No frame was heard of, or a file cannot be written.
    """
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="view_frames", description="Write the tree of frames as a graph and as pictures."
    )
    parser.add_argument(
        "-t", "--wait-time", type=float, default=WAIT_S, help="seconds to listen (%(default)s)"
    )
    parser.add_argument("-o", "--output", help="name of the files without their endings")
    parser.add_argument("--tf_topic", default=TF_TOPIC, help="topic of moving frames")
    parser.add_argument("--tf_static_topic", default=TF_STATIC_TOPIC, help="topic of fixed frames")
    options = parser.parse_args(parse_ros_arguments(words).program)
    with init(args=words), Node("view_frames", start_parameter_services=False) as node:
        logger = node.get_logger()
        files = view_frames(
            node,
            options.output,
            logger.info,
            wait_s=options.wait_time,
            tf_topic=options.tf_topic,
            tf_static_topic=options.tf_static_topic,
        )
        for file in files:
            logger.info(f"Exporting graph in {file} file...")
    return 0
