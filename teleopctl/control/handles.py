"""State and command interfaces: values that hardware and controllers share.

An interface is one float with a name. Hardware and controllers share the object and read and write
its ``value``: one attribute access, no lookup, no lock, since there is one control thread.
"""

from __future__ import annotations

import math

POSITION = "position"
VELOCITY = "velocity"
ACCELERATION = "acceleration"
EFFORT = "effort"


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
