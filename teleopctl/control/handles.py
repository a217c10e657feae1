"""State and command interfaces: values that hardware and controllers share.

An interface is one float with a name. Hardware and controllers share the object and read and write
its ``value``: one attribute access, no lookup, no lock, since there is one control thread.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

POSITION = "position"
VELOCITY = "velocity"
ACCELERATION = "acceleration"
EFFORT = "effort"
# A measured value is lost after this time, in seconds, and this number of cycles.
_GAP_S = 0.1
_GAP_CYCLES = 2


class StateInterface:
    """Named float that hardware measures or a controller exports, such as ``joint_1/position``.

    Args:
        prefix_name: Name of the joint, sensor or GPIO.
        interface_name: Measured quantity, such as ``position``.
        data_type: Data type in the robot description.
        initial_value: Value until the hardware's first read.

    Attributes:
        name: Prefix and interface name, ``joint_1/position``.
        value: Present value; NaN if unknown.
        available: Whether the interface can be used: its hardware is inactive or active, or the
            controller that exports it is active.
    """

    __slots__ = (
        "available",
        "data_type",
        "initial_value",
        "interface_name",
        "name",
        "prefix_name",
        "value",
    )

    def __init__(
        self,
        prefix_name: str,
        interface_name: str,
        data_type: str = "double",
        initial_value: float = math.nan,
    ) -> None:
        self.prefix_name = prefix_name
        self.interface_name = interface_name
        self.name = f"{prefix_name}/{interface_name}"
        self.data_type = data_type
        self.initial_value = initial_value
        self.value = initial_value
        self.available = False

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}={self.value}>"


class CommandInterface(StateInterface):
    """Named float that one controller at a time can claim and command.

    Attributes:
        owner: Name of the controller that has claimed the interface, or None.
        next_owner: Name of the controller that will claim the interface in the switch being
            prepared, or None.
        is_limited: Whether the last command was clamped to a limit of the joint.
        limited_count: Number of commands that were clamped.
    """

    __slots__ = ("is_limited", "limited_count", "next_owner", "owner")

    def __init__(
        self,
        prefix_name: str,
        interface_name: str,
        data_type: str = "double",
        initial_value: float = math.nan,
    ) -> None:
        super().__init__(prefix_name, interface_name, data_type, initial_value)
        self.owner: str | None = None
        self.next_owner: str | None = None
        self.is_limited = False
        self.limited_count = 0

    @property
    def claimed(self) -> bool:
        """Whether a controller has claimed the interface."""
        return self.owner is not None


class MeasuredValues:
    """Reader of one quantity of all joints of a controller, which keeps the last finite values.

    Args:
        interfaces: State interface of each joint.

    Attributes:
        lost: Sentence without a period on an interface that has had no finite value for a while,
            by `watch`; else empty.
    """

    def __init__(self, interfaces: Sequence[StateInterface]) -> None:
        self._interfaces = interfaces
        self._last = [math.nan] * len(interfaces)
        self._missing = ""
        self._gap_s = 0.0
        self._gap_cycles = 0
        self.lost = ""

    def read(self) -> list[float]:
        """Return the latest finite value of each joint; NaN before a joint's first finite value."""
        if not self._interfaces:
            return []
        self._missing = ""
        values = [interface.value for interface in self._interfaces]
        if math.isfinite(sum(values)):
            self._last = values
            return list(values)
        for index, interface in enumerate(self._interfaces):
            value = interface.value
            if math.isfinite(value):
                self._last[index] = value
            else:
                self._missing = interface.name
        return list(self._last)

    def watch(self, period: float) -> bool:
        """Set `lost` after `read` in a cycle of a period in seconds; return whether it changed.

        A gap of one cycle, or of less than a tenth of a second, is none.
        """
        if not self._missing:
            if not self._gap_cycles:
                return False
            self._gap_s, self._gap_cycles = 0.0, 0
            before, self.lost = self.lost, ""
            return bool(before)
        self._gap_s += period
        self._gap_cycles += 1
        if self.lost or self._gap_cycles < _GAP_CYCLES or self._gap_s < _GAP_S:
            return False
        self.lost = f"Hardware does not measure '{self._missing}': it is not a number"
        return True
