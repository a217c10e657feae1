"""``static_transform_publisher``: publishes one static transform, as program or component."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Sequence

from teleopctl.errors import InvalidParameterError, UsageError
from teleopctl.node import ExternalShutdownException, Node, init, parse_ros_arguments, spin
from teleopctl.nodes.argument_parser import ArgumentParser
from teleopctl.tf import (
    StaticTransformBroadcaster,
    Transform,
    normalize,
    quaternion_from_rpy,
    transform_stamped,
)

_OLD_USAGE = (
    "x y z qx qy qz qw frame_id child_frame_id  OR  x y z yaw pitch roll frame_id child_frame_id"
)
_MOVES = ("x", "y", "z")
_TURNS = ("qx", "qy", "qz", "qw")
_ANGLES = ("roll", "pitch", "yaw")


class StaticTransformPublisher(Node):
    """Node of ``static_transform_publisher``: publishes one static transform.

    Args:
        frame_id: Name of the parent frame.
        child_frame_id: Name of the child frame.
        transform: Pose of the child frame in the parent frame.
    """

    def __init__(self, frame_id: str, child_frame_id: str, transform: Transform) -> None:
        # Usually several of these nodes run at once, so each has a unique name.
        super().__init__(f"static_transform_publisher_{os.urandom(6).hex()}")
        self._broadcaster = broadcast(self, frame_id, child_frame_id, transform)


def broadcast(
    node: Node, frame_id: str, child_frame_id: str, transform: Transform
) -> StaticTransformBroadcaster:
    """Publish a static transform from a node, log it, and return the broadcaster."""
    broadcaster = StaticTransformBroadcaster(node)
    stamp = node.get_clock().now().nanoseconds
    broadcaster.sendTransform(transform_stamped(frame_id, child_frame_id, stamp, transform))
    move = "', '".join(f"{value:f}" for value in transform.translation)
    turn = "', '".join(f"{value:f}" for value in transform.rotation)
    node.get_logger().info(
        "Spinning until stopped - publishing transform\n"
        f"translation: ('{move}')\nrotation: ('{turn}')\n"
        f"from '{frame_id}' to '{child_frame_id}'"
    )
    return broadcaster


def main(args: list[str] | None = None) -> int:
    """Run ``static_transform_publisher`` until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        UsageError: The arguments are wrong.
    """
    words = sys.argv[1:] if args is None else args
    program = parse_ros_arguments(words).program
    is_old = is_old_style(program)
    frame_id, child_frame_id, transform = (
        parse_old_style(program) if is_old else parse_new_style(program)
    )
    if frame_id == child_frame_id:
        raise UsageError(
            f"cannot publish static transform from '{frame_id}' to '{child_frame_id}'",
        )
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=words),
        StaticTransformPublisher(frame_id, child_frame_id, transform) as node,
    ):
        if is_old:
            node.get_logger().warning(
                "Old-style arguments are deprecated; see --help for new-style arguments"
            )
        spin(node)
    return 0


def is_old_style(arguments: Sequence[str]) -> bool:
    """Return whether a command line has the positional arguments of old ROS releases."""
    return len(arguments) in (8, 9) and not any(word.startswith("--") for word in arguments)


def parse_old_style(arguments: Sequence[str]) -> tuple[str, str, Transform]:
    """Parse positional arguments; return the parent frame, child frame and transform.

    Raises:
        UsageError: A value is not a number, or the quaternion is zero.
    """
    *texts, frame_id, child_frame_id = arguments
    try:
        x, y, z, *turn = (float(text) for text in texts)
    except ValueError as error:
        raise UsageError(f"{error}", hint=f"Usage: {_OLD_USAGE}") from error
    if len(turn) == len(_TURNS):
        rotation = _unit(turn)
    else:
        yaw, pitch, roll = turn
        rotation = quaternion_from_rpy(roll, pitch, yaw)
    return frame_id, child_frame_id, Transform((x, y, z), rotation)


def parse_new_style(arguments: Sequence[str]) -> tuple[str, str, Transform]:
    """Parse ``--x``-style arguments; return the parent frame, child frame and transform.

    Raises:
        TeleopctlError: An argument is missing or wrong, or both kinds of rotation are given.
        SystemExit: ``--help`` was given.
    """
    parser = ArgumentParser(
        prog="static_transform_publisher",
        description="Publish a static transform, in metres and radians.",
        epilog=f"Old, deprecated arguments: {_OLD_USAGE}",
        allow_abbrev=False,
    )
    for name in (*_MOVES, *_TURNS, *_ANGLES):
        parser.add_argument(f"--{name}", type=float, metavar="NUMBER")
    parser.add_argument("--frame-id", required=True, help="the parent frame")
    parser.add_argument("--child-frame-id", required=True, help="the child frame")
    found = vars(parser.parse_args(list(arguments)))
    x, y, z = (found[name] or 0.0 for name in _MOVES)
    has_quaternion = any(found[name] is not None for name in _TURNS)
    if has_quaternion and any(found[name] is not None for name in _ANGLES):
        parser.error("give the rotation as --qx --qy --qz --qw or as --roll --pitch --yaw")
    if has_quaternion:
        qx, qy, qz, qw = (found[name] for name in _TURNS)
        rotation = _unit([qx or 0.0, qy or 0.0, qz or 0.0, 1.0 if qw is None else qw])
    else:
        roll, pitch, yaw = (found[name] or 0.0 for name in _ANGLES)
        rotation = quaternion_from_rpy(roll, pitch, yaw)
    return found["frame_id"], found["child_frame_id"], Transform((x, y, z), rotation)


def _unit(numbers: Sequence[float]) -> tuple[float, float, float, float]:
    x, y, z, w = numbers
    try:
        return normalize((x, y, z, w))
    except ZeroDivisionError:
        raise UsageError("the quaternion is zero") from None


class StaticTransformBroadcasterNode(Node):
    """Component that publishes one static transform, given by its parameters.

    Raises:
        InvalidParameterError: The two frames are the same, or the quaternion is zero.
    """

    def __init__(self) -> None:
        super().__init__("static_transform_publisher")
        move = (
            self._number("translation.x"),
            self._number("translation.y"),
            self._number("translation.z"),
        )
        turn = (
            self._number("rotation.x"),
            self._number("rotation.y"),
            self._number("rotation.z"),
            self._number("rotation.w", 1.0),
        )
        frame = str(self.declare_parameter("frame_id", "/frame").value)
        child = str(self.declare_parameter("child_frame_id", "/child").value)
        if frame == child:
            raise InvalidParameterError(
                f"cannot publish static transform from '{frame}' to '{child}', exiting"
            )
        try:
            transform = Transform(move, normalize(turn))
        except ZeroDivisionError:
            raise InvalidParameterError("the quaternion is zero") from None
        self._broadcaster = broadcast(self, frame, child, transform)

    def _number(self, name: str, default: float = 0.0) -> float:
        return float(self.declare_parameter(name, default).value)
