"""Executable ``teleop_twist_keyboard``: drives a mobile robot by keys, as ROS 2's program does."""

from __future__ import annotations

import contextlib
import sys
from typing import Any

from teleopctl.base.keyboard import Keyboard, require_keys
from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import ExternalShutdownException, Node, init, spin

_DEPTH = 10
# The keys are shown again after this number of changes of the speed.
_HELP_EVERY = 15
_HELP = """
Keys of this terminal are published as Twist or TwistStamped messages, by their places on a US
keyboard.
---------------------------
Moving around:
   u    i    o
   j    k    l
   m    ,    .

For Holonomic mode (strafing), hold down the shift key:
---------------------------
   U    I    O
   J    K    L
   M    <    >

t : up (+z)
b : down (-z)

anything else : stop

q/z : increase/decrease max speeds by 10%
w/x : increase/decrease only linear speed by 10%
e/c : increase/decrease only angular speed by 10%

CTRL-C to quit
"""
# Direction along x, y and z, and about z.
_MOTIONS = {
    "i": (1.0, 0.0, 0.0, 0.0),
    "o": (1.0, 0.0, 0.0, -1.0),
    "j": (0.0, 0.0, 0.0, 1.0),
    "l": (0.0, 0.0, 0.0, -1.0),
    "u": (1.0, 0.0, 0.0, 1.0),
    ",": (-1.0, 0.0, 0.0, 0.0),
    ".": (-1.0, 0.0, 0.0, 1.0),
    "m": (-1.0, 0.0, 0.0, -1.0),
    "O": (1.0, -1.0, 0.0, 0.0),
    "I": (1.0, 0.0, 0.0, 0.0),
    "J": (0.0, 1.0, 0.0, 0.0),
    "L": (0.0, -1.0, 0.0, 0.0),
    "U": (1.0, 1.0, 0.0, 0.0),
    "<": (-1.0, 0.0, 0.0, 0.0),
    ">": (-1.0, -1.0, 0.0, 0.0),
    "M": (-1.0, 1.0, 0.0, 0.0),
    "t": (0.0, 0.0, 1.0, 0.0),
    "b": (0.0, 0.0, -1.0, 0.0),
}
_STANDSTILL = (0.0, 0.0, 0.0, 0.0)
# Factors of the linear and the angular speed.
_FASTER, _SLOWER = 1.1, 0.9
_SPEEDS = {
    "q": (_FASTER, _FASTER),
    "z": (_SLOWER, _SLOWER),
    "w": (_FASTER, 1.0),
    "x": (_SLOWER, 1.0),
    "e": (1.0, _FASTER),
    "c": (1.0, _SLOWER),
}


class TwistKeyboard(Node):
    """Node that publishes velocities on ``cmd_vel`` by the keys of a terminal.

    Raises:
        UsageError: The parameter ``frame_id`` is set without ``stamped``.
    """

    def __init__(self) -> None:
        super().__init__("teleop_twist_keyboard")
        read_only = get_message("rcl_interfaces/msg/ParameterDescriptor")(read_only=True)

        # Any: values of parameters, and messages whose classes are generated at run time.
        def parameter(name: str, default: Any) -> Any:
            return self.declare_parameter(name, default, read_only).value

        self._is_stamped = bool(parameter("stamped", False))
        frame_id = str(parameter("frame_id", ""))
        self._speed = float(parameter("speed", 0.5))
        self._turn = float(parameter("turn", 1.0))
        if frame_id and not self._is_stamped:
            raise UsageError("'frame_id' can only be set when 'stamped' is True")
        kind = "TwistStamped" if self._is_stamped else "Twist"
        self._message: Any = get_message(f"geometry_msgs/msg/{kind}")()
        if self._is_stamped:
            self._message.header.frame_id = frame_id
        self._commands = self.create_publisher(type(self._message), "cmd_vel", _DEPTH)
        self._motion = _STANDSTILL
        self._changes = 0

    @property
    def speeds(self) -> str:
        """Line with the linear and the angular speed."""
        return f"currently:\tspeed {self._speed:.2f}\tturn {self._turn:.2f} "

    def on_key(self, key: str) -> None:
        """Process a key of the terminal, and publish; called on the thread that reads them."""
        if key in _SPEEDS:
            linear, angular = _SPEEDS[key]
            self._speed, self._turn = self._speed * linear, self._turn * angular
            self._changes += 1
            again = self._changes % _HELP_EVERY == 0
            sys.stdout.write(f"{self.speeds}\n{_HELP if again else ''}")
            sys.stdout.flush()
        else:
            self._motion = _MOTIONS.get(key, _STANDSTILL)
        self._publish()

    def stop(self) -> None:
        """Publish zero velocity."""
        self._motion = _STANDSTILL
        self._publish()

    def _publish(self) -> None:
        twist = self._message
        if self._is_stamped:
            twist = self._message.twist
            self._message.header.stamp = self.get_clock().now().to_msg()
        x, y, z, about_z = self._motion
        twist.linear.x, twist.linear.y, twist.linear.z = (self._speed * part for part in (x, y, z))
        twist.angular.z = self._turn * about_z
        self._commands.publish(self._message)


def main(args: list[str] | None = None) -> None:
    """Drive a robot by the keys of the terminal until Ctrl-C.

    Raises:
        UsageError: Standard input is no terminal, or the parameters contradict each other.
    """
    require_keys("teleop_twist_keyboard", "/cmd_vel")
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv if args is None else args, publishes_after_signal=True),
        TwistKeyboard() as node,
    ):
        sys.stdout.write(f"{_HELP}\n{node.speeds}\n")
        sys.stdout.flush()
        with Keyboard(node.on_key):
            try:
                spin(node)
            finally:
                node.stop()
