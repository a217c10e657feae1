"""The broadcaster of batteries: the fields of each, and how they are combined."""

import math

import pytest

from teleopctl.testing import ControlStack, serial_robot

TYPE = "battery_state_broadcaster/BatteryStateBroadcaster"
INTERFACES = (
    "battery_voltage",
    "battery_temperature",
    "battery_current",
    "battery_charge",
    "battery_percentage",
    "battery_power_supply_status",
    "battery_power_supply_health",
    "battery_present",
)


class Batteries:
    """Batteries ``left`` and ``right`` with all interfaces, and their broadcaster."""

    def __init__(self, parameters):
        states = "".join(f'<state_interface name="{name}"/>' for name in (*INTERFACES, "voltage"))
        sensors = "".join(
            f'<sensor name="{name}">{states}</sensor>' for name in ("left", "right", "old")
        )
        self.stack = ControlStack(serial_robot(1, extra_control=sensors))
        self.stack.load_controller("battery", TYPE, parameters)
        self.node = self.stack.nodes["battery"]

    def measure(self, **values):
        for name, value in values.items():
            battery, _, interface = name.partition("_")
            full = f"{battery}/battery_{interface}"
            self.stack.resources.state_interfaces[full].value = value

    def publish(self):
        self.stack.activate("battery")
        self.stack.step()
        (combined,) = self.node.published("~/battery_state")
        (raw,) = self.node.published("~/raw_battery_states")
        return combined, list(raw.battery_states)


def test_each_battery_has_what_its_interfaces_measure_and_nan_for_the_rest():
    batteries = Batteries(
        {
            "batteries": ["left", "right"],
            **{f"interfaces.left.{name}": True for name in INTERFACES[1:]},
            "left.capacity": 4.0,
            "left.location": "tail",
            "right.power_supply_technology": 2,
        }
    )
    batteries.measure(
        left_voltage=12.0,
        left_temperature=30.0,
        left_current=-2.0,
        left_charge=3.0,
        left_percentage=75.0,
        left_power_supply_status=2.0,
        left_power_supply_health=1.0,
        left_present=0.0,
        right_voltage=11.0,
        right_temperature=99.0,
    )
    combined, (left, right) = batteries.publish()
    assert (left.header.frame_id, left.header.stamp.nanosec) == ("left", 10_000_000)
    assert (left.voltage, left.temperature, left.current, left.charge) == (12.0, 30.0, -2.0, 3.0)
    assert (left.percentage, left.capacity, left.location) == (75.0, 4.0, "tail")
    assert left.power_supply_status == left.POWER_SUPPLY_STATUS_DISCHARGING
    assert left.power_supply_health == left.POWER_SUPPLY_HEALTH_GOOD
    assert (left.present, right.present) == (False, True)
    assert right.voltage == 11.0
    assert all(map(math.isnan, (right.temperature, right.charge, right.percentage)))
    assert right.power_supply_technology == right.POWER_SUPPLY_TECHNOLOGY_LION
    assert combined.header.frame_id == ""


def test_combined_means_sums_and_highest_values():
    batteries = Batteries(
        {
            "batteries": ["left", "right"],
            "interfaces.left.battery_temperature": True,
            **{f"interfaces.{name}.battery_charge": True for name in ("left", "right")},
            **{f"interfaces.{one}.battery_power_supply_status": True for one in ("left", "right")},
            **{f"{name}.capacity": 4.0 for name in ("left", "right")},
            **{f"{name}.power_supply_technology": 3 for name in ("left", "right")},
            "left.serial_number": "A1",
            "right.serial_number": "B2",
            "left.minimum_voltage": 10.0,
            "left.maximum_voltage": 14.0,
        }
    )
    batteries.measure(
        left_voltage=13.0,
        right_voltage=11.0,
        left_temperature=30.0,
        left_charge=3.0,
        right_charge=2.5,
        left_power_supply_status=1.0,
        right_power_supply_status=4.0,
    )
    combined, (left, _) = batteries.publish()
    assert left.percentage == (13.0 - 10.0) * 100.0 / (14.0 - 10.0)
    assert (combined.voltage, combined.temperature, combined.charge) == (12.0, 30.0, 5.5)
    assert (combined.percentage, combined.capacity) == (75.0, 8.0)
    assert math.isnan(combined.current)
    assert math.isnan(combined.design_capacity)
    assert combined.power_supply_status == combined.POWER_SUPPLY_STATUS_FULL
    assert combined.power_supply_technology == combined.POWER_SUPPLY_TECHNOLOGY_LIPO
    assert combined.serial_number == "A1, B2, "
    assert combined.present


def test_different_technologies_are_unknown_together():
    batteries = Batteries({"batteries": ["left", "right"], "left.power_supply_technology": 3})
    combined, _ = batteries.publish()
    assert combined.power_supply_technology == combined.POWER_SUPPLY_TECHNOLOGY_UNKNOWN


@pytest.mark.parametrize(("voltage", "present"), [(math.nan, False), (0.0, False), (3.7, True)])
def test_a_battery_without_voltage_is_absent(voltage, present):
    batteries = Batteries({"batteries": ["left"]})
    batteries.measure(left_voltage=voltage)
    _, (left,) = batteries.publish()
    assert left.present is present


def test_the_deprecated_sensor_name_reads_a_voltage():
    batteries = Batteries(
        {"sensor_name": "old", "design_capacity": 100.0, "power_supply_technology": 2}
    )
    batteries.stack.resources.state_interfaces["old/voltage"].value = 24.0
    combined, raw = batteries.publish()
    assert (combined.voltage, combined.design_capacity) == (24.0, 100.0)
    assert combined.power_supply_technology == combined.POWER_SUPPLY_TECHNOLOGY_LION
    assert raw == []
    assert "'sensor_name' parameter is deprecated" in batteries.node.log.texts("warning")[0]


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({}, "No batteries configured."),
        ({"batteries": ["left"], "sensor_name": "old"}, "You cannot use both"),
        ({"batteries": ["left", "left"]}, "must be unique"),
        (
            {"batteries": ["left"], "left.minimum_voltage": 3.0, "left.maximum_voltage": 3.0},
            "Maximum battery voltage level must be greater than minimum voltage level.",
        ),
        (
            {"batteries": ["left"], "left.power_supply_technology": 9},
            "'left.power_supply_technology' with the value 9 must be between 0 and 8",
        ),
    ],
)
def test_wrong_parameters_are_refused(parameters, text):
    batteries = Batteries(parameters)
    assert not batteries.stack.manager.configure_controller("battery")
    assert text in batteries.node.log.texts("error")[0]
