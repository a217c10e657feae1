"""State and command interfaces: values that hardware and controllers share.

An interface is one float with a name. Hardware and controllers hold the same object and read and
write its ``value``: one attribute access, no lookup, no lock (there is one control thread).
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
        prefix_name: The joint, sensor or gpio.
        interface_name: What is measured.
        data_type: The type that the robot description gives it.
        initial_value: Value until the hardware's first read.

    Attributes:
        name: Prefix and interface name, ``joint_1/position``.
        value: The present value; NaN while unknown.
        available: Whether its hardware can be used now.
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
        owner: Name of the controller that has claimed it, or None.
        next_owner: Who is to claim it in the switch that is being prepared, or None.
    """

    __slots__ = ("next_owner", "owner")

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

    @property
    def claimed(self) -> bool:
        """Whether a controller has claimed the interface."""
        return self.owner is not None
