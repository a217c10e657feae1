"""Teleop device ``joy``: a gamepad of any machine, by the messages of its ``joy_node``."""

from __future__ import annotations

from typing import Any

from teleopctl.interfaces import get_message
from teleopctl.teleop.device import HandSample, TeleopDevice

_DEPTH = 10


class JoyTopic(TeleopDevice):
    """Axes and buttons of the topic ``joy``, by their numbers, as in ``teleop_twist_joy``."""

    mapping = "joy"

    def start(self) -> None:
        """Subscribe to the topic."""
        self._sequence = 0
        # Any, here and below: message classes are generated at run time from definitions.
        kind: Any = get_message("sensor_msgs/msg/Joy")
        self._subscription: Any = self.node.create_subscription(kind, "joy", self._received, _DEPTH)

    def stop(self) -> None:
        """Unsubscribe."""
        self.node.destroy_subscription(self._subscription)

    def _received(self, message: Any) -> None:
        self._sequence += 1
        axes = {str(number): float(value) for number, value in enumerate(message.axes)}
        pressed = frozenset(str(number) for number, down in enumerate(message.buttons) if down)
        self.emit(HandSample(axes=axes, buttons=pressed, sequence=self._sequence))
