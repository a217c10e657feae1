"""Executable ``teleop_node`` of ``teleop_twist_joy``: drives a mobile robot by a gamepad.

A gamepad's axes and buttons come from ``joy``; axes times scales are published on ``cmd_vel``
while a button is held. Parameters and log lines are those of ROS 2's package.
"""

from __future__ import annotations

import contextlib
import sys
from typing import Any

from teleopctl.interfaces import get_message
from teleopctl.node import ExternalShutdownException, Node, init, spin

_DEPTH = 10
_UNUSED = -1
_NORMAL, _TURBO = "", "_turbo"
# Default number of each axis of the gamepad, and the scales of those in use.
_AXES = {
    "linear": {"x": 5, "y": _UNUSED, "z": _UNUSED},
    "angular": {"yaw": 2, "pitch": _UNUSED, "roll": _UNUSED},
}
_SCALES = {_NORMAL: 0.5, _TURBO: 1.0}
# Field of a Twist for each axis.
_FIELDS = {"x": "x", "y": "y", "z": "z", "yaw": "z", "pitch": "y", "roll": "x"}


class TwistJoy(Node):
    """Node that converts ``sensor_msgs/msg/Joy`` to velocity commands.

    Axes that are not in use have the number -1.
    """

    def __init__(self) -> None:
        super().__init__("teleop_twist_joy_node")
        self._is_stamped = bool(self.declare_parameter("publish_stamped_twist", False).value)
        self.declare_parameter("frame", "teleop_twist_joy")
        kind = "TwistStamped" if self._is_stamped else "Twist"
        # Any, here and below: message classes are generated at run time from definitions.
        self._class: Any = get_message(f"geometry_msgs/msg/{kind}")
        self._commands = self.create_publisher(self._class, "cmd_vel", _DEPTH)
        self.create_subscription(get_message("sensor_msgs/msg/Joy"), "joy", self._on_joy, _DEPTH)
        self.declare_parameter("require_enable_button", True)
        self.declare_parameter("enable_button", 5)
        self.declare_parameter("enable_turbo_button", _UNUSED)
        self.declare_parameter("inverted_reverse", False)
        for part, axes in _AXES.items():
            for axis, number in axes.items():
                self.declare_parameter(f"axis_{part}.{axis}", number)
                for mode, scale in _SCALES.items():
                    default = 0.0 if number == _UNUSED else scale
                    self.declare_parameter(f"scale_{part}{mode}.{axis}", default)
        self._has_stopped = False
        self._log_settings()

    # Any: the type of a parameter's value is the parameter's.
    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _log_settings(self) -> None:
        log = self.get_logger().info
        turbo = self._value("enable_turbo_button")
        if self._value("require_enable_button"):
            log(f"Teleop enable button {self._value('enable_button')}.")
        if turbo >= 0:
            log(f"Turbo on button {turbo}.")
        if self._value("inverted_reverse"):
            log("Teleop enable inverted reverse.")
        for part, axes in _AXES.items():
            for axis in sorted(axes):
                number = self._value(f"axis_{part}.{axis}")
                if number == _UNUSED:
                    continue
                scale = self._value(f"scale_{part}.{axis}")
                log(f"{part.capitalize()} axis {axis} on {number} at scale {scale:f}.")
                if turbo >= 0:
                    scale = self._value(f"scale_{part}_turbo.{axis}")
                    log(f"Turbo for {part} axis {axis} is scale {scale:f}.")

    def _on_joy(self, joy: Any) -> None:
        turbo = self._value("enable_turbo_button")
        if turbo >= 0 and _is_pressed(joy, turbo):
            self._drive(joy, _TURBO)
        elif not self._value("require_enable_button") or _is_pressed(
            joy, self._value("enable_button")
        ):
            self._drive(joy, _NORMAL)
        elif not self._has_stopped:
            # One standstill, at once: another source may command the robot then.
            self._publish(self._class())
            self._has_stopped = True

    def _drive(self, joy: Any, mode: str) -> None:
        message = self._class()
        twist = message.twist if self._is_stamped else message
        for part, axes in _AXES.items():
            for axis in axes:
                number = self._value(f"axis_{part}.{axis}")
                if 0 <= number < len(joy.axes):
                    scale = self._value(f"scale_{part}{mode}.{axis}")
                    setattr(getattr(twist, part), _FIELDS[axis], joy.axes[number] * scale)
        if twist.linear.x < 0.0 and self._value("inverted_reverse"):
            twist.angular.z = -twist.angular.z
        self._publish(message)
        self._has_stopped = False

    def _publish(self, message: Any) -> None:
        if self._is_stamped:
            message.header.stamp = self.get_clock().now().to_msg()
            message.header.frame_id = self._value("frame")
        self._commands.publish(message)


def _is_pressed(joy: Any, button: int) -> bool:
    return 0 <= button < len(joy.buttons) and bool(joy.buttons[button])


def main(args: list[str] | None = None) -> None:
    """Convert gamepad messages to velocity commands until Ctrl-C or a shutdown."""
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv if args is None else args),
        TwistJoy() as node,
    ):
        spin(node)
