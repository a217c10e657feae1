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


def started(*components, prepare=None):
    """Return a stack whose components are loaded, prepared and then started."""
    stack = ControlStack()
    description = RobotDescription.from_urdf(recorded_robot(*components))
    stack.resources.load_and_initialize_components(description)
    if prepare is not None:
        prepare(stack)
    stack.resources.start_components({})
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
        calls: list[str] = []

        def prepare(stack):
            for name in ("H1", "H2"):
                hardware(stack, name).calls = calls

        stack = started(("", GROUP), ("", GROUP), prepare=prepare)
        assert calls == ["configure", "configure", "activate", "activate"]
        assert states(stack) == [State.ACTIVE] * 2

    def test_no_member_stays_active_if_one_cannot_be_activated(self):
        stack = started(
            ("", GROUP),
            ("", GROUP),
            ("", ""),
            prepare=lambda stack: hardware(stack, "H2").outcomes.update(activate=FAILURE),
        )
        assert states(stack) == [State.INACTIVE, State.INACTIVE, State.ACTIVE]
        assert any("group 'arm' is not active, since 'H2'" in e for e in stack.log.texts("error"))

    def test_no_member_is_activated_if_one_cannot_be_configured(self):
        stack = started(
            ("", GROUP),
            ("", GROUP),
            prepare=lambda stack: hardware(stack, "H2").outcomes.update(configure=FAILURE),
        )
        assert states(stack) == [State.INACTIVE, State.UNCONFIGURED]
