"""Executables ``turtle_teleop_key``, ``mimic`` and ``draw_square``, which steer turtles."""

from __future__ import annotations

import contextlib
import math
import sys
from collections.abc import Callable
from typing import Any

from teleopctl.base.keyboard import DOWN, LEFT, RIGHT, UP, Keyboard, require_keys
from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import (
    ActionClient,
    ExternalShutdownException,
    Node,
    QoSProfile,
    init,
    spin,
)
from teleopctl.nodes.turtlesim.turtle import DEPTH, TICK_S, normalize_angle

# Linear and angular direction of each key.
_DIRECTIONS = {LEFT: (0.0, 1.0), RIGHT: (0.0, -1.0), UP: (1.0, 0.0), DOWN: (-1.0, 0.0)}
# Angle of each key around F, rad.
_ANGLES = {
    "g": 0.0,
    "t": math.pi / 4,
    "r": math.pi / 2,
    "e": 3 * math.pi / 4,
    "d": math.pi,
    "c": -3 * math.pi / 4,
    "v": -math.pi / 2,
    "b": -math.pi / 4,
}
_HELP = """\
Reading from keyboard
---------------------------
Use arrow keys to move the turtle.
Use g|b|v|c|d|e|r|t keys to rotate to absolute orientations. 'f' to cancel a rotation.
'q' to quit.
"""
# draw_square: speeds, m/s and rad/s, the side, m, and the differences at which a goal is reached.
_SPEED, _TURN_SPEED, _SIDE_M = 1.0, 0.4, 2.0
_REACHED_M, _REACHED_RAD, _STOPPED = 0.1, 0.01, 0.0001

# Any, here and below: message classes are generated at run time from definitions.


class TurtleTeleop(Node):
    """Node that moves a turtle by keys: arrows drive it, letters turn it to an angle."""

    def __init__(self) -> None:
        super().__init__("teleop_turtle")
        self.declare_parameter("scale_angular", 2.0)
        self.declare_parameter("scale_linear", 2.0)
        self._twist: Any = get_message("geometry_msgs/msg/Twist")
        self._action: Any = get_action("turtlesim/action/RotateAbsolute")
        self._commands = self.create_publisher(
            self._twist, "turtle1/cmd_vel", QoSProfile(depth=DEPTH)
        )
        self._rotations = ActionClient(self, self._action, "turtle1/rotate_absolute")
        self._goal: Any = None

    def on_key(self, key: str) -> None:
        """Take a key of the terminal; called on the thread that reads them."""
        if key in _DIRECTIONS:
            linear, angular = _DIRECTIONS[key]
            twist = self._twist()
            twist.linear.x = float(self.get_parameter("scale_linear").value) * linear
            twist.angular.z = float(self.get_parameter("scale_angular").value) * angular
            self._commands.publish(twist)
        elif key in _ANGLES:
            sent = self._rotations.send_goal_async(self._action.Goal(theta=_ANGLES[key]))
            sent.add_done_callback(self._on_answer)
        elif key == "f" and self._goal is not None:
            self._goal.cancel_goal_async()
        elif key == "q":
            self.context.try_shutdown()

    def _on_answer(self, future: Any) -> None:
        goal = future.result()
        self._goal = goal if goal is not None and goal.accepted else None


class TurtleMimic(Node):
    """Node that sends the velocity of one turtle to another one."""

    def __init__(self, cli_args: list[str] | None = None) -> None:
        super().__init__("turtle_mimic", cli_args=cli_args)
        qos = QoSProfile(depth=DEPTH)
        self._twist: Any = get_message("geometry_msgs/msg/Twist")
        self._commands = self.create_publisher(self._twist, "output/cmd_vel", qos)
        self.create_subscription(
            get_message("turtlesim/msg/Pose"), "input/pose", self._on_pose, qos
        )

    def _on_pose(self, pose: Any) -> None:
        twist = self._twist()
        twist.linear.x = pose.linear_velocity
        twist.angular.z = pose.angular_velocity
        self._commands.publish(twist)


class DrawSquare(Node):
    """Node that drives a turtle along a square, again and again."""

    def __init__(self) -> None:
        super().__init__("draw_square")
        qos = QoSProfile(depth=DEPTH)
        self._twist: Any = get_message("geometry_msgs/msg/Twist")
        self._commands = self.create_publisher(self._twist, "turtle1/cmd_vel", qos)
        self.create_subscription(
            get_message("turtlesim/msg/Pose"), "turtle1/pose", self._on_pose, qos
        )
        self._pose: Any = None
        self._goal: tuple[float, float, float] | None = None
        self._is_turn = self._is_stopping = False
        empty: Any = get_service("std_srvs/srv/Empty")
        self._reset = self.create_client(empty, "reset")
        self._reset.call_async(empty.Request())
        self.create_timer(TICK_S, self._tick)

    def _on_pose(self, pose: Any) -> None:
        self._pose = pose

    def _tick(self) -> None:
        if self._pose is None:
            return
        if self._goal is None:
            self._set_goal()
        elif not self._is_stopping:
            if self._has_reached():
                self._is_stopping = True
                self._command(0.0, 0.0)
            elif self._is_turn:
                self._command(0.0, _TURN_SPEED)
            else:
                self._command(_SPEED, 0.0)
        elif max(self._pose.linear_velocity, self._pose.angular_velocity) >= _STOPPED:
            self._command(0.0, 0.0)
        else:
            self.get_logger().info("Reached goal")
            self._is_turn, self._is_stopping = not self._is_turn, False
            self._set_goal()

    def _set_goal(self) -> None:
        x, y, theta = self._pose.x, self._pose.y, self._pose.theta
        if self._is_turn:
            theta = normalize_angle(theta + math.pi / 2.0)
        else:
            x, y = x + math.cos(theta) * _SIDE_M, y + math.sin(theta) * _SIDE_M
        self._goal = (x, y, theta)
        self.get_logger().info(f"New goal [{x:f} {y:f}, {theta:f}]")

    def _has_reached(self) -> bool:
        assert self._goal is not None
        x, y, theta = self._goal
        return (
            abs(self._pose.x - x) < _REACHED_M
            and abs(self._pose.y - y) < _REACHED_M
            and abs(normalize_angle(self._pose.theta - theta)) < _REACHED_RAD
        )

    def _command(self, linear: float, angular: float) -> None:
        twist = self._twist()
        twist.linear.x, twist.angular.z = linear, angular
        self._commands.publish(twist)


def turtle_teleop_key(args: list[str] | None = None) -> None:
    """Move a turtle by the keys of the terminal until ``q`` or Ctrl-C.

    Raises:
        UsageError: Standard input is no terminal.
    """
    require_keys("turtle_teleop_key", "/turtle1/cmd_vel")
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv if args is None else args),
        TurtleTeleop() as node,
    ):
        sys.stdout.write(_HELP)
        sys.stdout.flush()
        with Keyboard(node.on_key):
            spin(node)


def mimic(args: list[str] | None = None) -> None:
    """Send the velocity on ``input/pose`` to ``output/cmd_vel`` until Ctrl-C."""
    _run(TurtleMimic, args)


def draw_square(args: list[str] | None = None) -> None:
    """Drive ``turtle1`` along a square until Ctrl-C."""
    _run(DrawSquare, args)


def _run(make: Callable[[], Node], args: list[str] | None) -> None:
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv if args is None else args),
        make() as node,
    ):
        spin(node)
