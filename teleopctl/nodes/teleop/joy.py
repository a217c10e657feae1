"""Executables of ROS 2's ``joy``: gamepads as messages, and the list of those that are attached.

``joy_node`` gives axes and buttons in the order of the device, ``game_controller_node`` in that of
SDL's game controllers, which is the same for all. Parameters, topics and log lines are those of
ROS 2's package.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from teleopctl.errors import InvalidParameterError, TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.node import ExternalShutdownException, Node, init, spin
from teleopctl.teleop import Joystick, find_joysticks, keep_open, open_joystick

_DEPTH = 10
_MOST_HZ = 1000.0
# Longest time in which the end is noticed, s.
_WAKE_S = 0.2
# The orders of SDL's game controllers.
_CONTROLLER_AXES = (
    *("left_x", "left_y", "right_x", "right_y"),
    *("left_trigger", "right_trigger"),
)
_CONTROLLER_BUTTONS = (
    *("a", "b", "x", "y", "back", "guide", "start", "left_stick", "right_stick"),
    *("left_bumper", "right_bumper", "dpad_up", "dpad_down", "dpad_left", "dpad_right"),
)
_CONTROLLER_BUTTON_COUNT = 21

# Any, here and below: message classes are generated at run time from definitions.


class _Publisher(Node, ABC):
    """Node that publishes the state of a joystick, and waits until one is attached.

    Args:
        name: Name of the node.
        noun: What it opens, in its log.
    """

    def __init__(self, name: str, noun: str) -> None:
        super().__init__(name)
        self._noun = noun
        self._number = int(self._given("device_id", 0, 0, 1e9))
        self._device_name = str(self.declare_parameter("device_name", "").value)
        # Of teleopctl: a device file, or a named pipe with its records.
        self._path = str(self.declare_parameter("dev", "").value)
        self._deadzone = self._given("deadzone", 0.05, 0.0, 1.0)
        rate_hz = self._given("autorepeat_rate", 20.0, 0.0, _MOST_HZ)
        self._repeat_s = 1.0 / rate_hz if rate_hz else 0.0
        self._is_sticky = bool(self.declare_parameter("sticky_buttons", False).value)
        self._coalesce_s = self._given("coalesce_interval_ms", 1, 0, 1e6) / 1000.0
        self._stuck: list[bool] = []
        self._pressed: list[bool] = []
        self._message: Any = get_message("sensor_msgs/msg/Joy")()
        self._message.header.frame_id = "joy"
        self._joys = self.create_publisher(type(self._message), "joy", _DEPTH)
        self.create_subscription(
            get_message("sensor_msgs/msg/JoyFeedback"), "joy/set_feedback", self._feedback, _DEPTH
        )
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="joystick", daemon=True)
        self._thread.start()

    def _given(self, name: str, default: float, least: float, most: float) -> float:
        value = float(self.declare_parameter(name, default).value)
        if not least <= value <= most:
            raise InvalidParameterError(
                f"The parameter '{name}' is {value:g}, and not from {least:g} to {most:g}"
            )
        return value

    @abstractmethod
    def layout(self, joystick: Joystick) -> tuple[list[float], list[bool]]:
        """Return axes and buttons of a joystick in the order of the messages."""

    def destroy_node(self) -> None:
        """Stop reading, and destroy the node."""
        self._ending.set()
        self._thread.join()
        super().destroy_node()

    def _feedback(self, _message: Any) -> None:
        self.get_logger().info("No haptic (rumble) is available", once=True)

    def _run(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            keep_open(
                lambda: open_joystick(self._number, self._device_name, self._path),
                self._publish_all,
                self._report,
                self._ending,
            )

    def _report(self, error: TeleopctlError) -> None:
        hint = f" ({error.hint})" if error.hint else ""
        self.get_logger().warning(f"{error.message}{hint}; waiting for it")

    def _publish_all(self, joystick: Joystick) -> None:
        """Publish each change, and the unchanged state at the repeat rate.

        Raises:
            DeviceError: The joystick is gone.
        """
        name = joystick.name or self._path
        self.get_logger().info(f"Opened {self._noun}: {name}.  deadzone: {self._deadzone:f}")
        self._stuck, self._pressed = [], []
        published_s = time.monotonic()
        while not self._ending.is_set():
            left_s = published_s + self._repeat_s - time.monotonic()
            wait_s = min(max(left_s, 0.0), _WAKE_S) if self._repeat_s else _WAKE_S
            is_new = joystick.read(wait_s)
            if is_new and self._coalesce_s and joystick.buttons == self._pressed:
                # The kernel has an event for each axis of a stick.
                end_s = time.monotonic() + self._coalesce_s
                while (left_s := end_s - time.monotonic()) > 0.0:
                    joystick.read(left_s)
                    if joystick.buttons != self._pressed:
                        break
            is_due = self._repeat_s and time.monotonic() - published_s >= self._repeat_s
            if is_new or is_due:
                published_s = time.monotonic()
                self._publish(joystick)

    def _publish(self, joystick: Joystick) -> None:
        axes, buttons = self.layout(joystick)
        if self._is_sticky:
            before = self._pressed + [False] * (len(buttons) - len(self._pressed))
            stuck = self._stuck + [False] * (len(buttons) - len(self._stuck))
            self._stuck = [
                at != (is_down and not was)
                for at, is_down, was in zip(stuck, buttons, before, strict=True)
            ]
        self._pressed = buttons
        message = self._message
        message.axes = [self._beyond(value) for value in axes]
        message.buttons = [int(each) for each in (self._stuck if self._is_sticky else buttons)]
        message.header.stamp = self.get_clock().now().to_msg()
        self._joys.publish(message)

    def _beyond(self, value: float) -> float:
        size = abs(value)
        if size <= self._deadzone:
            return 0.0
        part = (size - self._deadzone) / (1.0 - self._deadzone)
        return part if value > 0.0 else -part


class JoyNode(_Publisher):
    """Node ``joy_node``: axes and buttons in the order of the device, hats last."""

    def __init__(self) -> None:
        super().__init__("joy_node", "joystick")

    def layout(self, joystick: Joystick) -> tuple[list[float], list[bool]]:
        """Return axes and buttons as the device has them."""
        return list(joystick.axes), list(joystick.buttons)


class GameController(_Publisher):
    """Node ``game_controller_node``: axes and buttons in SDL's order; triggers from 0 to -1."""

    def __init__(self) -> None:
        super().__init__("game_controller_node", "game controller")

    def layout(self, joystick: Joystick) -> tuple[list[float], list[bool]]:
        """Return axes and buttons in SDL's order."""
        sample = joystick.sample(0)
        sign = {name: -1.0 if name.endswith("trigger") else 1.0 for name in _CONTROLLER_AXES}
        axes = [sign[name] * sample.axes.get(name, 0.0) for name in _CONTROLLER_AXES]
        buttons = [name in sample.buttons for name in _CONTROLLER_BUTTONS]
        return axes, buttons + [False] * (_CONTROLLER_BUTTON_COUNT - len(buttons))


def joy_node(args: Sequence[str] | None = None) -> None:
    """Publish the state of a joystick until Ctrl-C or a shutdown."""
    _spin(JoyNode, args)


def game_controller_node(args: Sequence[str] | None = None) -> None:
    """Publish the state of a gamepad in SDL's order until Ctrl-C or a shutdown."""
    _spin(GameController, args)


def _spin(kind: type[JoyNode | GameController], args: Sequence[str] | None) -> None:
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv if args is None else args),
        kind() as node,
    ):
        spin(node)


def joy_enumerate_devices() -> None:
    """Print the joysticks that are attached."""
    sys.stdout.write("Joystick Device ID : Joystick Device Name\n" + "-" * 41 + "\n")
    for each in find_joysticks():
        sys.stdout.write(f"{each.number:18d} : {each.name or each.path}\n")
