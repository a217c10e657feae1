"""Teleop device ``joy``: a gamepad of any machine, by the messages of its ``joy_node``."""

from __future__ import annotations

from typing import Any

from teleopctl.interfaces import deserialize, get_message
from teleopctl.teleop.device import HandSample, TeleopDevice

_DEPTH = 10
# Length of the CDR header and the stamp, which precede all other fields.
_BEFORE_FRAME = 12


class JoyTopic(TeleopDevice):
    """Axes and buttons of the topic ``joy``, by their numbers, as in ``teleop_twist_joy``."""

    mapping = "joy"

    def start(self) -> None:
        """Subscribe to the topic."""
        self._fields = b""
        self._sample = HandSample()
        # Any: message classes are generated at run time from definitions.
        self._type: Any = get_message("sensor_msgs/msg/Joy")
        self._subscription: Any = self.node.create_subscription(
            self._type, "joy", self._received, _DEPTH, raw=True, immediate=True
        )

    def stop(self) -> None:
        """Unsubscribe."""
        self.node.destroy_subscription(self._subscription)

    def _received(self, data: bytes) -> None:
        # Inputs that are held come again and again, with another stamp only.
        fields = data[_BEFORE_FRAME:]
        if fields != self._fields:
            message = deserialize(data, self._type)
            axes = {str(number): float(each) for number, each in enumerate(message.axes)}
            pressed = (str(number) for number, down in enumerate(message.buttons) if down)
            self._sample = HandSample(axes, frozenset(pressed), sequence=self._sample.sequence + 1)
            self._fields = fields
        self.emit(self._sample)
