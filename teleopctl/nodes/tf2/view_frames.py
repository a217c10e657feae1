"""Executable ``tf2_tools view_frames``: writes the tree of tf frames as diagrams."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from teleopctl.base.printable import printable_line
from teleopctl.diagram import Diagram, DiagramBox, Edge, to_svg, write_diagram_files
from teleopctl.errors import UnavailableError, UsageError
from teleopctl.node import Node, init, parse_ros_arguments
from teleopctl.tf import TF_STATIC_TOPIC, TF_TOPIC, KnownFrame, LiveBuffer, TransformListener

WAIT_S = 5.0
"""Seconds for which tf is received, as in tf2_tools."""

# tf2's name of every broadcaster: messages do not hold the name of their publisher.
_NOBODY = "default_authority"


def view_frames(
    node: Node,
    output: str | None,
    log: Callable[[str], object],
    *,
    wait_s: float = WAIT_S,
    tf_topic: str = TF_TOPIC,
    tf_static_topic: str = TF_STATIC_TOPIC,
) -> list[Path]:
    """Receive tf for some seconds, write the tree of frames as files, and return their paths.

    Args:
        node: Node that subscribes to tf; need not be spun.
        output: Path of the files without suffix; None for ``frames_`` and the time, in the current
            folder.
        log: Called with each progress message.
        wait_s: Time for which transforms are received, in seconds of wall time.
        tf_topic: Topic of dynamic transforms.
        tf_static_topic: Topic of static transforms.

    Returns:
        Paths of the ``.gv`` and ``.svg`` file, and of the ``.pdf`` file if Graphviz's ``dot`` is
        installed.

    Raises:
        UsageError: ``wait_s`` is not positive or not finite.
        UnavailableError: No transform was received.
        SystemFailureError: A file cannot be written, or ``dot`` fails.
    """
    if not 0.0 < wait_s < float("inf"):
        raise UsageError(f"The time to listen must be positive, got {wait_s:g}")
    buffer = LiveBuffer(node=node)
    listener = TransformListener(buffer, node, tf_topic=tf_topic, tf_static_topic=tf_static_topic)
    ended = threading.Event()
    node.context.on_shutdown(ended.set)
    try:
        log(f"Listening to tf data for {float(wait_s)} seconds...")
        ended.wait(wait_s)
    finally:
        node.context.forget_on_shutdown(ended.set)
        listener.unregister()
    frames = buffer.known_frames()
    if not frames:
        raise UnavailableError(
            f"No transform on {tf_topic} or {tf_static_topic} within {wait_s:g} s",
            hint="`teleopctl topic info` shows the publishers.",
        )
    base = Path(output or time.strftime("frames_%Y-%m-%d_%H.%M.%S"))
    log("Generating graph...")
    dot = buffer.all_frames_as_dot(node.get_clock().now().nanoseconds)
    return write_diagram_files(base, dot, to_svg(frames_diagram(frames)), log)


def frames_diagram(frames: Sequence[KnownFrame]) -> Diagram:
    """Return a diagram of the tree of tf frames, with rates and buffer lengths."""
    names = dict.fromkeys(name for frame in frames for name in (frame.parent, frame.name))
    boxes = [DiagramBox(f"frame {name}", printable_line(name), "node") for name in names]
    edges = []
    for frame in frames:
        label = f"arrow {frame.name}"
        boxes.append(DiagramBox(label, _text(frame), "label"))
        edges.append(Edge(f"frame {frame.parent}", label))
        edges.append(Edge(label, f"frame {frame.name}"))
    return Diagram(tuple(boxes), tuple(edges))


def _text(frame: KnownFrame) -> str:
    is_known = frame.broadcaster not in ("", _NOBODY)
    lines = [printable_line(frame.broadcaster)] if is_known else []
    if frame.is_static:
        lines.append("static")
    else:
        lines.append(f"{frame.rate:.1f} Hz")
        lines.append(f"{frame.newest_s - frame.oldest_s:.1f} s long")
    return "\n".join(lines)


def main(args: list[str] | None = None) -> int:
    """Run ``view_frames``: write the tree of tf frames as files; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        TeleopctlError: No transform was received, or a file cannot be written.
    """
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="view_frames", description="Write the tree of frames as a graph and as pictures."
    )
    parser.add_argument(
        "-t", "--wait-time", type=float, default=WAIT_S, help="seconds to listen (%(default)s)"
    )
    parser.add_argument("-o", "--output", help="file name without extension")
    parser.add_argument("--tf_topic", default=TF_TOPIC, help="topic of dynamic transforms")
    parser.add_argument(
        "--tf_static_topic", default=TF_STATIC_TOPIC, help="topic of static transforms"
    )
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
