"""A turtle of turtlesim: its motion, its pen, and its topics, services and action."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionServer, CancelResponse, Node, QoSProfile
from teleopctl.nodes.turtlesim.board import SIZE, Board, Colour, Pen

TICK_S = 0.016
"""Period of the simulation, s, and the time by which a turtle moves in it."""

DEPTH = 7
"""Depth of the topics of turtlesim."""

# A turtle stops this long after its last command.
_COMMAND_NS = 1_000_000_000
# Difference from the goal, rad, at which a rotation is done, and its speed, rad/s.
_ROTATION_TOLERANCE, _ROTATION_SPEED = 0.02, 1.0

# Any, here and below: message classes are generated at run time from definitions.


def normalize_angle(angle: float) -> float:
    """Return an angle from -pi to pi, rad."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


class _Teleport(NamedTuple):
    """Request to put a turtle elsewhere: from where it is, or to a place on the board."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0
    distance: float = 0.0
    is_relative: bool = False


class Turtle:
    """Turtle with its interfaces, all below its name: ``cmd_vel``, ``pose``, ``set_pen`` and so on.

    Args:
        node: Node of the simulation.
        name: Name of the turtle.
        x: Place from the board's left side, m.
        y: Place from the board's upper side, m.
        theta: Direction, rad from the x axis, counter-clockwise.
        look: Which picture it has.
        is_holonomic: Returns whether turtles move sideways too.

    Attributes:
        x: See the arguments.
        y: See the arguments.
        theta: See the arguments.
        look: See the arguments.
        pen: Pen with which the turtle draws.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        x: float,
        y: float,
        theta: float,
        look: int,
        is_holonomic: Callable[[], bool],
    ) -> None:
        self._node = node
        self._is_holonomic = is_holonomic
        self.x, self.y, self.theta = x, y, theta
        self.look = look
        self.pen = Pen()
        self._forward = self._sideways = self._turning = 0.0
        self._commanded_ns = node.get_clock().now().nanoseconds
        self._teleports: list[_Teleport] = []
        self._goal: Any = None
        self._goal_start = 0.0
        self._pose: Any = get_message("turtlesim/msg/Pose")()
        self._colour: Any = get_message("turtlesim/msg/Color")()
        self._rotation: Any = get_action("turtlesim/action/RotateAbsolute")
        qos = QoSProfile(depth=DEPTH)
        self._commands = node.create_subscription(
            get_message("geometry_msgs/msg/Twist"), f"{name}/cmd_vel", self._on_command, qos
        )
        self._poses = node.create_publisher(type(self._pose), f"{name}/pose", qos)
        self._colours = node.create_publisher(type(self._colour), f"{name}/color_sensor", qos)
        self._services = [
            node.create_service(get_service(f"turtlesim/srv/{kind}"), f"{name}/{service}", serve)
            for kind, service, serve in (
                ("SetPen", "set_pen", self._set_pen),
                ("TeleportRelative", "teleport_relative", self._teleport_relative),
                ("TeleportAbsolute", "teleport_absolute", self._teleport_absolute),
            )
        ]
        self._server = ActionServer(
            node,
            self._rotation,
            f"{name}/rotate_absolute",
            None,
            handle_accepted_callback=self._begin_rotation,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def destroy(self) -> None:
        """Remove the turtle's interfaces from the node; a rotation is aborted."""
        if self._goal is not None:
            self._goal.abort(self._rotated())
            self._goal = None
        self._server.destroy()
        for service in self._services:
            self._node.destroy_service(service)
        self._node.destroy_publisher(self._poses)
        self._node.destroy_publisher(self._colours)
        self._node.destroy_subscription(self._commands)

    # --- what others send -------------------------------------------------------------------------

    def _on_command(self, twist: Any) -> None:
        if not self._is_finite(twist.linear.x, twist.linear.y, twist.angular.z):
            return
        self._commanded_ns = self._node.get_clock().now().nanoseconds
        self._forward = twist.linear.x
        if self._is_holonomic():
            self._sideways = twist.linear.y
        self._turning = twist.angular.z
        if self._goal is not None:
            self._node.get_logger().warning(
                "Velocity command received during rotation goal. Aborting goal"
            )
            self._goal.abort(self._rotated())
            self._goal = None

    def _is_finite(self, *values: float) -> bool:
        """Return whether values are numbers; else log that they are ignored."""
        if all(map(math.isfinite, values)):
            return True
        self._node.get_logger().warning(f"Ignored, since it is not finite: {[*values]}")
        return False

    def _set_pen(self, request: Any, response: Any) -> Any:
        if request.off:
            self.pen = self.pen._replace(is_on=False)
        else:
            self.pen = Pen(Colour(request.r, request.g, request.b), request.width or 1)
        return response

    def _teleport_relative(self, request: Any, response: Any) -> Any:
        if self._is_finite(request.angular, request.linear):
            self._teleports.append(
                _Teleport(theta=request.angular, distance=request.linear, is_relative=True)
            )
        return response

    def _teleport_absolute(self, request: Any, response: Any) -> Any:
        if self._is_finite(request.x, request.y, request.theta):
            self._teleports.append(_Teleport(request.x, request.y, request.theta))
        return response

    def _begin_rotation(self, goal: Any) -> None:
        if self._goal is not None:
            self._node.get_logger().warning(
                "Rotation goal received before a previous goal finished. Aborting previous goal"
            )
            self._goal.abort(self._rotated())
        self._goal = goal
        self._goal_start = self.theta
        if not goal.is_cancel_requested:
            goal.executing()

    def _rotated(self) -> Any:
        return self._rotation.Result(delta=normalize_angle(self._goal_start - self.theta))

    # --- motion -----------------------------------------------------------------------------------

    def tick(self, board: Board) -> bool:
        """Move by `TICK_S`, draw on the board, publish; return whether the turtle has moved."""
        begin = (self.x, self.y, self.theta)
        for teleport in self._teleports:
            self._teleport(teleport, board)
        self._teleports.clear()
        if self._goal is not None:
            self._rotate()
        if self._node.get_clock().now().nanoseconds - self._commanded_ns > _COMMAND_NS:
            self._stop()
        before = (self.x, self.y)
        self.theta = normalize_angle(self.theta + self._turning * TICK_S)
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        self.x += (cos * self._forward - sin * self._sideways) * TICK_S
        self.y -= (cos * self._sideways + sin * self._forward) * TICK_S
        if not (0.0 <= self.x <= SIZE and 0.0 <= self.y <= SIZE):
            self._node.get_logger().warning(
                f"Oh no! I hit the wall! (Clamping from [x={self.x:f}, y={self.y:f}])"
            )
            self.x, self.y = (min(max(value, 0.0), SIZE) for value in (self.x, self.y))
        self._publish(board)
        if (self.x, self.y) != before:
            board.line(before, (self.x, self.y), self.pen)
        return (self.x, self.y, self.theta) != begin

    def _teleport(self, teleport: _Teleport, board: Board) -> None:
        before = (self.x, self.y)
        if teleport.is_relative:
            self.theta += teleport.theta
            self.x += math.cos(self.theta) * teleport.distance
            self.y -= math.sin(self.theta) * teleport.distance
        else:
            self.x = teleport.x
            self.y = max(0.0, SIZE - teleport.y)
            self.theta = teleport.theta
        board.line(before, (self.x, self.y), self.pen)

    def _rotate(self) -> None:
        """Turn towards the goal of a rotation, or end the rotation."""
        goal = self._goal
        if goal.is_cancel_requested:
            self._node.get_logger().info("Rotation goal canceled")
            goal.canceled(self._rotated())
        else:
            remaining = normalize_angle(normalize_angle(goal.request.theta) - self.theta)
            goal.publish_feedback(self._rotation.Feedback(remaining=remaining))
            if abs(remaining) >= _ROTATION_TOLERANCE:
                self._forward = self._sideways = 0.0
                self._turning = math.copysign(_ROTATION_SPEED, remaining)
                self._commanded_ns = self._node.get_clock().now().nanoseconds
                return
            self._node.get_logger().info("Rotation goal completed successfully")
            goal.succeed(self._rotated())
        self._goal = None
        self._stop()

    def _stop(self) -> None:
        self._forward = self._sideways = self._turning = 0.0

    def _publish(self, board: Board) -> None:
        pose, colour = self._pose, self._colour
        pose.x, pose.y, pose.theta = self.x, SIZE - self.y, self.theta
        pose.linear_velocity = math.hypot(self._forward, self._sideways)
        pose.angular_velocity = self._turning
        self._poses.publish(pose)
        colour.r, colour.g, colour.b = board.colour_at(self.x, self.y)
        self._colours.publish(colour)
