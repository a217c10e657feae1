"""Rates and groups of hardware components, as ros2_control has them."""

import pytest

from teleopctl.control.lifecycle import ReturnType, State
from teleopctl.control.services import hardware_component_state
from teleopctl.robot import RobotDescription
from teleopctl.testing import ControlStack
from tests.control.fakes import FAILURE, TYPE, recorded_robot

GROUP = "<group>arm</group>"


def hardware(stack, name="H1"):
    return stack.resources.components[name].hardware


def states(stack):
    return [component.lifecycle_state for component in stack.resources.components.values()]


def loaded(*components):
    """Return a stack whose components are loaded and not started."""
    stack = ControlStack()
    description = RobotDescription.from_urdf(recorded_robot(*components))
    stack.resources.load_and_initialize_components(description)
    return stack


class TestRates:
    def test_a_50_hz_component_under_100_hz_is_read_every_second_cycle_with_twice_the_period(self):
        stack = ControlStack(recorded_robot(('rw_rate="50"', ""), ("", "")))
        stack.step(6)
        assert hardware(stack).reads == hardware(stack).writes == [0.02] * 3
        assert hardware(stack, "H2").reads == [0.01] * 6

    @pytest.mark.parametrize(("rate", "count"), [(1, 1), (10, 10), (30, 33), (40, 50), (90, 100)])
    def test_a_rate_that_is_no_divisor_takes_the_nearest_cycles(self, rate, count):
        stack = ControlStack(recorded_robot((f'rw_rate="{rate}"', "")))
        stack.step(100)
        reads = hardware(stack).reads
        assert len(reads) == pytest.approx(count, abs=1)
        assert reads[0] == pytest.approx(1 / rate)
        assert all(period > 0.0 for period in reads)

    def test_a_component_is_written_at_once_after_its_activation(self):
        stack = ControlStack(recorded_robot(('rw_rate="10"', "")))
        component = stack.resources.components["H1"]
        stack.step(3)
        component.change_state(State.INACTIVE)
        component.change_state(State.ACTIVE)
        stack.step()
        assert hardware(stack).writes == [0.1, 0.1]
        assert hardware(stack).reads == [0.1]

    @pytest.mark.parametrize("attribute", ["", 'rw_rate="0"', 'rw_rate="100"', 'rw_rate="300"'])
    def test_no_rate_and_one_above_the_managers_are_the_managers(self, attribute):
        stack = ControlStack(recorded_robot((attribute, "")))
        stack.step(4)
        assert hardware(stack).reads == [0.01] * 4
        assert hardware_component_state(stack.resources.components["H1"]).rw_rate == 100
        warned = any("its rw_rate, 300 Hz, is above" in text for text in stack.log.texts("warning"))
        assert warned == ("300" in attribute)

    def test_the_list_of_components_has_their_rates(self):
        stack = ControlStack(recorded_robot(('rw_rate="50"', "")))
        assert hardware_component_state(stack.resources.components["H1"]).rw_rate == 50


class TestErrors:
    def test_deactivate_returned_from_a_read_is_an_error(self):
        stack = ControlStack(recorded_robot(("", "")))
        hardware(stack).outcomes["read"] = ReturnType.DEACTIVATE
        stack.step()
        assert states(stack) == [State.UNCONFIGURED]
        assert any(
            "DEACTIVATE returned from read cycle is treated the same as ERROR." in text
            for text in stack.log.texts("warning")
        )

    def test_an_error_leaves_other_components_alone(self):
        stack = ControlStack(recorded_robot(("", ""), ("", "")))
        hardware(stack).outcomes["read"] = ReturnType.ERROR
        stack.step()
        assert states(stack) == [State.UNCONFIGURED, State.ACTIVE]


class TestGroups:
    @pytest.mark.parametrize("failing", ["H1", "H3"])
    @pytest.mark.parametrize("operation", ["read", "write"])
    def test_an_error_in_one_member_makes_all_members_unconfigured(self, failing, operation):
        stack = ControlStack(recorded_robot(("", GROUP), ("", ""), ("", GROUP)))
        for name, joint in (("first", 1), ("other", 2), ("last", 3)):
            stack.load_controller(name, TYPE, {"commands": [f"joint{joint}/position"]})
            stack.activate(name)
        hardware(stack, failing).outcomes[operation] = ReturnType.ERROR
        stack.step()
        assert states(stack) == [State.UNCONFIGURED, State.ACTIVE, State.UNCONFIGURED]
        assert [spec.name for spec in stack.manager.active_controllers] == ["other"]
        for name in ("H1", "H3"):
            assert hardware(stack, name).calls.count("error") == 1
        assert any("of the same group 'arm'" in text for text in stack.log.texts("error"))

    def test_deactivate_of_one_member_makes_all_members_inactive(self):
        stack = ControlStack(recorded_robot(("", GROUP), ("", GROUP)))
        stack.load_controller("moving", TYPE, {"commands": ["joint1/position"]})
        stack.load_controller("watching", TYPE, {"states": ["joint1/position"]})
        stack.activate("moving", "watching")
        hardware(stack, "H2").outcomes["write"] = ReturnType.DEACTIVATE
        stack.step()
        assert states(stack) == [State.INACTIVE] * 2
        assert [spec.name for spec in stack.manager.active_controllers] == ["watching"]

    def test_all_members_are_configured_before_one_is_activated(self):
        stack = loaded(("", GROUP), ("", GROUP))
        calls: list[str] = []
        for name in ("H1", "H2"):
            hardware(stack, name).calls = calls
        assert stack.resources.start_components({}) == []
        assert calls == ["configure", "configure", "activate", "activate"]
        assert states(stack) == [State.ACTIVE] * 2

    def test_no_member_stays_active_if_one_cannot_be_activated(self):
        stack = loaded(("", GROUP), ("", GROUP), ("", ""))
        hardware(stack, "H2").outcomes["activate"] = FAILURE
        assert stack.resources.start_components({}) == [("H2", State.ACTIVE)]
        assert states(stack) == [State.INACTIVE, State.INACTIVE, State.ACTIVE]
        assert any("group 'arm' is not active, since 'H2'" in e for e in stack.log.texts("error"))

    def test_no_member_is_activated_if_one_cannot_be_configured(self):
        stack = loaded(("", GROUP), ("", GROUP))
        hardware(stack, "H2").outcomes["configure"] = FAILURE
        assert stack.resources.start_components({}) == [("H2", State.INACTIVE)]
        assert states(stack) == [State.INACTIVE, State.UNCONFIGURED]


class TestStart:
    def test_components_get_their_initial_states(self):
        stack = loaded(("", ""), ("", ""), ("", ""))
        initial = {"H1": State.UNCONFIGURED, "H2": State.INACTIVE}
        assert stack.resources.start_components(initial) == []
        assert states(stack) == [State.UNCONFIGURED, State.INACTIVE, State.ACTIVE]

    def test_an_unknown_component_is_named(self):
        stack = loaded(("", ""))
        stack.resources.start_components({"H7": State.INACTIVE})
        (text,) = stack.log.texts("warning")
        assert text.startswith(
            "Hardware component 'H7' is unknown, therefore not set in 'inactive' state."
        )

    def test_a_component_that_fails_is_named_and_the_others_start(self):
        stack = loaded(("", ""), ("", ""))
        hardware(stack).outcomes["activate"] = FAILURE
        assert stack.resources.start_components({}) == [("H1", State.ACTIVE)]
        assert states(stack) == [State.INACTIVE, State.ACTIVE]
        text = "Failed to set the initial state of the component : 'H1' to 'active'"
        assert stack.log.texts("error")[-1] == text


@pytest.mark.parametrize("stops", [True, False])
def test_a_parameter_keeps_the_controllers_of_hardware_that_deactivates_itself(stops):
    stack = ControlStack(recorded_robot(("", "")))
    parameter = "defaults.deactivate_controllers_on_hardware_self_deactivate"
    stack.node.declare_parameter(parameter, stops)
    stack.load_controller("moving", TYPE, {"commands": ["joint1/position"]})
    stack.activate("moving")
    hardware(stack).outcomes["write"] = ReturnType.DEACTIVATE
    stack.step()
    assert states(stack) == [State.INACTIVE]
    assert bool(stack.manager.active_controllers) is not stops
