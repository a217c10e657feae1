"""Broadcaster of any state interfaces, as one list of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import get_message, set_stamp


class StateInterfacesBroadcaster(ControllerInterface):
    """Controller that publishes the values of named state interfaces in each update.

    Plug-in type ``state_interfaces_broadcaster/StateInterfacesBroadcaster``.

    ``~/names`` has the interfaces once, for late subscribers too, and ``~/values`` their values in
    that order.
    """

    def on_init(self) -> CallbackReturn | None:
        """Read the parameter ``interfaces``; return ERROR if it is empty."""
        none: list[str] = []
        self._names: list[str] = self.auto_declare("interfaces", none, read_only=True)
        if not self._names:
            self.logger.error("Parameter 'interfaces' cannot be empty")
            return CallbackReturn.ERROR
        return None

    def on_configure(self) -> CallbackReturn | None:
        """Create the publishers of ``~/names`` and ``~/values``; publish the names."""
        from teleopctl.node import DurabilityPolicy, QoSProfile

        node = self.get_node()
        # Any: message classes are generated at run time. The message of values is reused.
        keys: Any = get_message("control_msgs/msg/Keys")
        values: Any = get_message("control_msgs/msg/Float64Values")
        self._message: Any = values()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        names = node.create_publisher(keys, "~/names", latched)
        self._publisher = node.create_publisher(values, "~/values", 10)
        self._publishers = [names, self._publisher]
        self._realtime = RealtimePublisher(self.params.publish_queue, self._publish)
        message = keys(keys=list(self._names))
        set_stamp(message.header.stamp, self.params.now_ns())
        names.publish(message)
        return None

    def on_cleanup(self) -> None:
        """Destroy the publishers of names and values."""
        for publisher in self._publishers:
            self.get_node().destroy_publisher(publisher)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces that the parameter ``interfaces`` names."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._names)

    def on_activate(self) -> CallbackReturn | None:
        """Return FAILURE if an interface is not of type double."""
        for state in self.state_interfaces:
            if state.data_type != "double":
                self.logger.error(
                    f"State interface '{state.name}' ({state.data_type}) is not of type double. "
                    "The StateInterfacesBroadcaster only supports state interfaces that support "
                    "double datatype."
                )
                return CallbackReturn.FAILURE
        return None

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Queue the present values for publishing."""
        del period
        self._realtime.try_publish((time_ns, [state.value for state in self.state_interfaces]))
        return None

    def _publish(self, value: tuple[int, Sequence[float]]) -> None:
        time_ns, self._message.values = value
        set_stamp(self._message.header.stamp, time_ns)
        self._publisher.publish(self._message)
