"""Broadcaster of batteries: the state of each, and of all together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.sensor_broadcasters import whole_number
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import get_message, set_stamp

_VOLTAGE, _PERCENTAGE, _PRESENT = "battery_voltage", "battery_percentage", "battery_present"
_ENUMERATIONS = ("power_supply_status", "power_supply_health")
# Interfaces of a battery that the parameters may enable, in the order in which they are claimed.
_OPTIONAL = (
    "battery_temperature",
    "battery_current",
    "battery_charge",
    _PERCENTAGE,
    *(f"battery_{name}" for name in _ENUMERATIONS),
    _PRESENT,
)
_LARGEST_TECHNOLOGY = 8
_LARGEST_BYTE = 255


@dataclass(frozen=True)
class _Battery:
    """Parameters of one battery.

    Attributes:
        name: Prefix of its interfaces.
        interfaces: Interfaces that it has, the voltage first.
        lowest: Voltage at 0 %, V; NaN if unknown.
        highest: Voltage at 100 %, V; NaN if unknown.
    """

    name: str
    interfaces: tuple[str, ...]
    lowest: float = math.nan
    highest: float = math.nan

    @property
    def has_percentage(self) -> bool:
        """Whether the charge is measured, or follows from the voltage."""
        return _PERCENTAGE in self.interfaces or not math.isnan(self.lowest + self.highest)

    def percentage(self, voltage: float) -> float:
        """Return the charge in %, linear between the lowest and the highest voltage."""
        return (voltage - self.lowest) * 100.0 / (self.highest - self.lowest)


class BatteryStateBroadcaster(ControllerInterface):
    """Controller that publishes batteries as sensor_msgs/BatteryState.

    Plug-in type ``battery_state_broadcaster/BatteryStateBroadcaster``.

    ``~/raw_battery_states`` has the state of each of the ``batteries``; ``~/battery_state`` has
    their mean voltage, temperature, current and percentage, their summed charges and capacities,
    and the highest status and health. A battery is present if its voltage is neither NaN nor 0,
    unless an interface has the value.
    """

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the publishers of both topics."""
        none: list[str] = []
        names: list[str] = self.auto_declare("batteries", none, read_only=True)
        sensor = self.auto_declare("sensor_name", "", read_only=True)
        if problem := _problem_of_names(names, sensor):
            self.logger.error(problem)
            return CallbackReturn.ERROR
        # Any: message classes are generated at run time. The messages are reused.
        one: Any = get_message("sensor_msgs/msg/BatteryState")
        array: Any = get_message("control_msgs/msg/BatteryStateArray")
        self._message: Any = one(present=True)
        self._states: list[Any] = [one(present=True) for _ in names]
        self._array: Any = array(battery_states=self._states)
        try:
            self._batteries = [
                self._read_battery(name, state)
                for name, state in zip(names, self._states, strict=True)
            ]
            if sensor:
                self._read_deprecated(sensor)
        except ValueError as error:
            self.logger.error(str(error))
            return CallbackReturn.ERROR
        if names:
            self._combine_properties()
        node, queue = self.get_node(), self.params.publish_queue
        self._publisher = node.create_publisher(one, "~/battery_state", 10)
        self._raw_publisher = node.create_publisher(array, "~/raw_battery_states", 10)
        self._realtime = RealtimePublisher(queue, self._publish)
        self.logger.info("configure successful")
        return None

    def _read_deprecated(self, sensor: str) -> None:
        self.logger.warning(
            "The 'sensor_name' parameter is deprecated and will be removed in future releases. "
            "Please use 'batteries' parameter instead."
        )
        self._batteries = [_Battery(sensor, ("voltage",))]
        self._message.capacity = math.nan
        self._message.design_capacity = self.auto_declare("design_capacity", math.nan)
        self._message.power_supply_technology = self._technology("power_supply_technology")

    def _read_battery(self, name: str, state: Any) -> _Battery:
        """Return a battery of the parameters, and set what its state never changes."""
        read = self.auto_declare
        enabled = [one for one in _OPTIONAL if read(f"interfaces.{name}.{one}", False)]
        lowest = read(f"{name}.minimum_voltage", math.nan)
        highest = read(f"{name}.maximum_voltage", math.nan)
        if _PERCENTAGE not in enabled and lowest >= highest:
            raise ValueError(
                "Maximum battery voltage level must be greater than minimum voltage level."
                f" (battery '{name}': {lowest:g} V and {highest:g} V)"
            )
        state.header.frame_id = name
        for field in ("temperature", "current", "charge", "percentage"):
            setattr(state, field, math.nan)
        for field in ("capacity", "design_capacity"):
            setattr(state, field, read(f"{name}.{field}", math.nan))
        state.power_supply_technology = self._technology(f"{name}.power_supply_technology")
        for field in ("location", "serial_number"):
            setattr(state, field, read(f"{name}.{field}", ""))
        return _Battery(name, (_VOLTAGE, *enabled), lowest, highest)

    def _technology(self, parameter: str) -> int:
        value = self.auto_declare(parameter, 0)
        if not 0 <= value <= _LARGEST_TECHNOLOGY:
            raise ValueError(
                f"Parameter '{parameter}' with the value {value} must be between 0 and "
                f"{_LARGEST_TECHNOLOGY}"
            )
        return value

    def _combine_properties(self) -> None:
        """Set the constant fields of the combined state from those of the batteries."""
        message, states = self._message, self._states
        for field in ("capacity", "design_capacity"):
            setattr(message, field, sum(getattr(state, field) for state in states))
        technologies = {state.power_supply_technology for state in states}
        message.power_supply_technology = technologies.pop() if len(technologies) == 1 else 0
        for field in ("location", "serial_number"):
            setattr(message, field, "".join(f"{getattr(state, field)}, " for state in states))

    def on_cleanup(self) -> None:
        """Destroy the publishers of both topics."""
        for publisher in (self._publisher, self._raw_publisher):
            self.get_node().destroy_publisher(publisher)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the voltage and the enabled interfaces of each battery."""
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL,
            [f"{battery.name}/{one}" for battery in self._batteries for one in battery.interfaces],
        )

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Queue the measured values for publishing."""
        del period
        self._realtime.try_publish((time_ns, [state.value for state in self.state_interfaces]))
        return None

    def _publish(self, value: tuple[int, Sequence[float]]) -> None:
        time_ns, values = value
        numbers = iter(values)
        measured = [
            dict(zip(battery.interfaces, numbers, strict=False)) for battery in self._batteries
        ]
        for battery, state, interfaces in zip(
            self._batteries, self._states, measured, strict=False
        ):
            set_stamp(state.header.stamp, time_ns)
            _fill(state, battery, interfaces)
        self._raw_publisher.publish(self._array)
        message, states = self._message, self._states
        set_stamp(message.header.stamp, time_ns)
        message.voltage = _mean(next(iter(interfaces.values())) for interfaces in measured)
        for field in ("temperature", "current"):
            message_value = _mean(
                one[f"battery_{field}"] for one in measured if f"battery_{field}" in one
            )
            setattr(message, field, message_value)
        charges = [one["battery_charge"] for one in measured if "battery_charge" in one]
        message.charge = sum(charges) if charges else math.nan
        message.percentage = _mean(
            state.percentage
            for battery, state in zip(self._batteries, states, strict=False)
            if battery.has_percentage
        )
        for field in _ENUMERATIONS:
            setattr(message, field, max((getattr(state, field) for state in states), default=0))
        self._publisher.publish(message)


def _problem_of_names(names: Sequence[str], sensor: str) -> str:
    """Return what is wrong with the parameters that name batteries, or an empty string."""
    if sensor and names:
        return (
            "You cannot use both 'sensor_name' and 'batteries' parameters. Please use only "
            "'batteries' going forward."
        )
    if not sensor and not names:
        return "No batteries configured. Set 'batteries' (preferred) or 'sensor_name' (deprecated)."
    if len(set(names)) != len(names):
        return "Value of parameter 'batteries' must be unique"
    return ""


def _fill(state: Any, battery: _Battery, interfaces: dict[str, float]) -> None:
    """Set the measured fields of one battery's state."""
    state.voltage = voltage = interfaces[_VOLTAGE]
    for field in ("temperature", "current", "charge"):
        if (name := f"battery_{field}") in interfaces:
            setattr(state, field, interfaces[name])
    if _PERCENTAGE in interfaces:
        state.percentage = interfaces[_PERCENTAGE]
    elif battery.has_percentage:
        state.percentage = battery.percentage(voltage)
    for field in _ENUMERATIONS:
        value = interfaces.get(f"battery_{field}", 0.0)
        setattr(state, field, whole_number(value, 0, _LARGEST_BYTE, otherwise=0))
    present = interfaces.get(_PRESENT, voltage)
    state.present = not math.isnan(present) and present != 0.0


def _mean(values: Iterable[float]) -> float:
    """Return the mean of values; NaN if there are none."""
    listed = list(values)
    return sum(listed) / len(listed) if listed else math.nan
