"""Asynchronous hardware components and controllers: in lockstep the same each time, else threads.

Without threads, as in simulation, what they compute in a cycle holds from the next one on.
"""

import math
import threading
from typing import TYPE_CHECKING, cast

import pytest

from teleopctl.control.lifecycle import ReturnType, State
from teleopctl.control.services import (
    ControllerManagerServices,
    controller_state,
    hardware_component_state,
)
from teleopctl.interfaces import get_service
from teleopctl.testing import ControlStack
from tests.control.fakes import FOLLOWER, LOCKSTEP, TYPE, recorded_robot

if TYPE_CHECKING:
    from teleopctl.node import Node

ASYNC = 'is_async="true"'
POSITION = "joint1/position"


def hardware(stack, name="H1"):
    return stack.resources.components[name].hardware


def component(stack, name="H1"):
    return stack.resources.components[name]


def names_of_threads():
    return {thread.name for thread in threading.enumerate()}


def follow(stack, **parameters):
    """Load and activate an asynchronous `Follower` of joint1 with the given parameters."""
    given = {"is_async": True, "commands": [POSITION], "states": [POSITION], **parameters}
    controller = stack.load_controller("follow", FOLLOWER, given)
    stack.activate("follow")
    return controller


@pytest.fixture
def stack():
    return ControlStack(recorded_robot(("", "")))


@pytest.fixture
def threaded():
    """Return a function that makes a stack with threads for its asynchronous hardware."""
    made = []

    def make(*components):
        stack = ControlStack(recorded_robot(*(components or (("", ""),))))
        stack.resources.set_lockstep(False)
        made.append(stack)
        return stack

    yield make
    for stack in made:
        for name in stack.resources.components:
            hardware(stack, name).gate.set()
        for spec in stack.manager.controllers.values():
            getattr(spec.controller, "gate", threading.Event()).set()
        stack.manager.shutdown()


class TestHardwareInLockstep:
    def test_states_are_those_of_the_cycle_before(self):
        stack = ControlStack(recorded_robot((ASYNC, ""), ("", "")))
        seen = []
        for _ in range(3):
            stack.step()
            seen.append((stack.state("joint1/position"), stack.state("joint2/position")))
        assert seen == [(0.0, 1.0), (1.0, 2.0), (2.0, 3.0)]

    def test_controllers_know_of_a_jump_when_they_see_the_states_after_it(self):
        stack = ControlStack(recorded_robot((ASYNC, "")))
        resources, seen = stack.resources, []
        hardware(stack).state_jumped = True
        for time_ns in range(3):
            resources.read(time_ns, 0.01)
            seen.append((stack.state(POSITION), resources.take_state_jumped()))
        assert seen == [(0.0, False), (1.0, True), (2.0, False)]

    def test_commands_are_written_in_the_cycle_after(self):
        stack = ControlStack(recorded_robot((ASYNC, "")))
        stack.load_controller("direct", FOLLOWER, {"commands": [POSITION]})
        stack.activate("direct")
        stack.step(3)
        assert hardware(stack).written == [[7.0], [100.0], [200.0]]

    def test_an_error_is_found_in_the_next_cycle(self):
        stack = ControlStack(recorded_robot((ASYNC, "")))
        stack.load_controller("user", TYPE, {"commands": [POSITION]})
        stack.activate("user")
        hardware(stack).outcomes["write"] = ReturnType.ERROR
        stack.step()
        assert component(stack).lifecycle_state is State.ACTIVE
        stack.step()
        assert component(stack).lifecycle_state is State.UNCONFIGURED
        assert not stack.manager.active_controllers
        assert not stack.resources.state_interfaces[POSITION].available

    def test_deactivate_from_a_write_makes_it_inactive(self):
        stack = ControlStack(recorded_robot((ASYNC, "")))
        hardware(stack).outcomes["write"] = ReturnType.DEACTIVATE
        stack.step(2)
        assert component(stack).lifecycle_state is State.INACTIVE
        count = len(hardware(stack).reads)
        stack.step(2)
        assert len(hardware(stack).reads) == count + 2
        assert len(hardware(stack).writes) == 1

    def test_it_has_a_rate_of_its_own(self):
        stack = ControlStack(recorded_robot((f'{ASYNC} rw_rate="50"', "")))
        stack.step(6)
        assert hardware(stack).reads == hardware(stack).writes == [0.02] * 3
        state = hardware_component_state(component(stack))
        assert (state.is_async, state.rw_rate) == (True, 50)

    def test_states_of_a_configuration_hold_at_once(self):
        stack = ControlStack(recorded_robot((ASYNC, "")))
        component(stack).change_state(State.UNCONFIGURED)
        hardware(stack).state_interfaces[POSITION].value = 5.0
        component(stack).change_state(State.INACTIVE)
        assert stack.state(POSITION) == 5.0
        assert stack.resources.state_interfaces[POSITION].available

    def test_the_log_says_so(self):
        stack = ControlStack(recorded_robot((ASYNC, "")))
        stack.resources.set_lockstep(True)
        assert stack.log.texts("info")[-1].startswith("Hardware 'H1' is asynchronous in lockstep")

    def test_hardware_that_triggers_the_cycles_is_read_in_them(self):
        stack = ControlStack(recorded_robot((f'{ASYNC} rw_rate="50"', ""), plugin=LOCKSTEP))
        stack.step(2)
        assert hardware(stack).reads == [0.01] * 2
        assert not hardware_component_state(component(stack)).is_async
        assert any(
            "without its rw_rate of 50 Hz and is_async: its states trigger the cycles" in text
            for text in stack.log.texts("warning")
        )

    @pytest.mark.parametrize(("lockstep", "is_async"), [("true", False), ("false", True)])
    def test_the_simulators_states_trigger_the_cycles_unless_asked_otherwise(
        self, lockstep, is_async
    ):
        tags = f'<param name="lockstep">{lockstep}</param>'
        robot = recorded_robot((ASYNC, tags), plugin="gz_ros2_control/GazeboSimSystem")
        stack = ControlStack(robot)
        assert hardware_component_state(component(stack)).is_async is is_async


class TestHardwareInThreads:
    def test_a_read_that_takes_long_delays_no_cycle(self, threaded):
        stack = threaded((ASYNC, ""))
        hardware(stack).gate.clear()
        stack.step(3)
        assert any(
            "async trigger is still in progress for hardware interface : 'H1'" in text
            for text in stack.log.texts("warning")
        )
        hardware(stack).gate.set()
        assert component(stack).wait_until_idle()
        assert hardware(stack).reads == [0.01]
        assert stack.state(POSITION) == 0.0
        stack.step()
        assert stack.state(POSITION) == 1.0
        # The period of the next read is the time since the trigger of the last one.
        assert component(stack).wait_until_idle()
        assert hardware(stack).reads == [0.01, 0.03]
        assert hardware(stack).threads == {"hardware H1"}

    def test_a_transition_waits_for_the_running_read(self, threaded):
        stack = threaded((ASYNC, ""))
        hardware(stack).gate.clear()
        stack.step()
        change = threading.Thread(target=component(stack).change_state, args=[State.INACTIVE])
        change.start()
        assert "deactivate" not in hardware(stack).calls
        hardware(stack).gate.set()
        change.join(10.0)
        assert hardware(stack).calls[-1] == "deactivate"
        assert component(stack).lifecycle_state is State.INACTIVE

    def test_cycles_go_on_while_a_request_for_a_state_waits_for_a_read(self, threaded):
        stack = threaded((ASYNC, ""))
        ControllerManagerServices(cast("Node", stack.node), stack.manager)
        hardware(stack).gate.clear()
        stack.step()
        service = get_service("controller_manager_msgs/srv/SetHardwareComponentState")
        request = service.Request(name="H1")
        request.target_state.label = "inactive"
        response = service.Response()
        call = threading.Thread(
            target=stack.node.call,
            args=["~/set_hardware_component_state", request, response],
        )
        call.start()
        stack.step(5)
        hardware(stack).gate.set()
        call.join(10.0)
        assert response.ok
        assert component(stack).lifecycle_state is State.INACTIVE
        stack.step()
        assert component(stack).wait_until_idle()
        assert len(hardware(stack).reads) == 2

    def test_the_thread_ends_when_the_component_is_unconfigured(self, threaded):
        stack = threaded((ASYNC, ""))
        stack.step()
        assert "hardware H1" in names_of_threads()
        component(stack).change_state(State.UNCONFIGURED)
        assert "hardware H1" not in names_of_threads()
        component(stack).change_state(State.ACTIVE)
        stack.step()
        assert component(stack).wait_until_idle()
        assert hardware(stack).reads == [0.01, 0.01]

    def test_a_detached_thread_reads_at_its_rate_without_cycles(self, threaded):
        properties = '<properties><async scheduling_policy="detached"/></properties>'
        stack = threaded((f'{ASYNC} rw_rate="100"', "", properties))
        stack.step()
        for _ in range(3):
            assert hardware(stack).has_read.acquire(timeout=10.0)
        assert component(stack).wait_until_idle()
        stack.step()
        assert stack.state(POSITION) >= 3.0


class TestControllersInLockstep:
    def test_commands_hold_from_the_next_cycle_on(self, stack):
        follow(stack)
        stack.step(3)
        assert hardware(stack).written == [[7.0], [100.0], [200.0]]

    def test_states_are_those_of_the_cycle(self, stack):
        controller = follow(stack)
        stack.step(3)
        assert controller.states == [[1.0], [2.0], [3.0]]

    def test_commands_of_a_slower_controller_hold_from_the_next_cycle_on(self, stack):
        controller = follow(stack, update_rate=50)
        stack.step(5)
        assert controller.periods == pytest.approx([0.02] * 3)
        written = [values[0] for values in hardware(stack).written]
        assert written == [7.0, 100.0, 100.0, 200.0, 200.0]

    def test_commands_of_the_deactivation_hold(self, stack):
        follow(stack)
        stack.step(2)
        stack.deactivate("follow")
        stack.step()
        assert hardware(stack).written[-1] == [-7.0]
        assert stack.resources.command_interfaces[POSITION].owner is None

    @pytest.mark.parametrize("outcome", ["ERROR", "raise"])
    def test_a_failed_update_stops_the_controller_in_the_next_cycle(self, stack, outcome):
        follow(stack, failing=["update", outcome])
        stack.step()
        assert stack.manager.active_controllers
        stack.step()
        assert not stack.manager.active_controllers
        text = "Controller 'follow' raised in update: RuntimeError: update on purpose"
        assert any(text in line for line in stack.log.texts("warning")) == (outcome == "raise")

    def test_after_a_jump_old_commands_are_discarded(self, stack):
        follow(stack)
        stack.step(2)
        hardware(stack).state_jumped = True
        stack.step()
        assert math.isnan(hardware(stack).written[-1][0])
        stack.step()
        assert hardware(stack).written[-1] == [300.0]

    def test_a_stopped_robot_is_not_commanded(self, stack):
        controller = follow(stack)
        stack.step(2)
        updates = controller.updates
        stack.manager.robot_stop.hold("operator")
        stack.step(20)
        assert controller.updates == updates
        stopped = stack.command(POSITION)
        stack.step(5)
        assert stack.command(POSITION) == stopped
        stack.manager.robot_stop.hold("")
        stack.step(2)
        assert controller.updates == updates + 2

    def test_the_list_of_controllers_has_it(self, stack):
        follow(stack)
        stack.load_controller("direct", TYPE)
        stack.activate("direct")
        specs = stack.manager.controllers.values()
        assert [controller_state(stack.manager, spec).is_async for spec in specs] == [True, False]
        assert any("Asynchronous in lockstep" in text for text in stack.nodes["follow"].log.texts())

    def test_it_can_be_configured_again_without(self, stack):
        follow(stack)
        stack.deactivate("follow")
        stack.nodes["follow"].declare_parameter("is_async", False)
        assert stack.manager.configure_controller("follow")
        stack.activate("follow")
        stack.step()
        assert hardware(stack).written[-1] == [100.0]

    @pytest.mark.parametrize(
        ("parameter", "value", "error"),
        [
            ("scheduling_policy", "detached", "not supported to run asynchronously in detached"),
            ("scheduling_policy", "fifo", "must be synchronized, got 'fifo'"),
            ("thread_priority", 100, "must be between 0 and 99, got 100"),
        ],
    )
    def test_bad_thread_parameters_are_refused(self, stack, parameter, value, error):
        parameters = {"is_async": True, f"async_parameters.{parameter}": value}
        stack.load_controller("follow", FOLLOWER, parameters)
        assert not stack.manager.configure_controller("follow")
        assert error in stack.log.texts("error")[-1]


class TestControllersInThreads:
    def test_an_update_that_takes_long_delays_no_cycle(self, threaded):
        stack = threaded()
        controller = follow(stack)
        controller.gate.clear()
        stack.step(4)
        written = [values[0] for values in hardware(stack).written]
        assert written == [7.0] * 4
        update = stack.manager.controllers["follow"].async_update
        assert (update.total_triggers, update.failed_triggers) == (4, 3)
        said = stack.nodes["follow"].log.texts("warning")
        assert said[-1] == "The controller missed 3 update cycles out of 4 total triggers."
        controller.gate.set()
        assert update.wait_until_idle()
        assert controller.threads == {"controller follow"}
        stack.step()
        assert hardware(stack).written[-1] == [100.0]

    def test_a_deactivation_waits_for_the_running_update(self, threaded):
        stack = threaded()
        controller = follow(stack)
        controller.gate.clear()
        stack.step()
        stop = threading.Thread(target=stack.deactivate, args=["follow"])
        stop.start()
        # The control cycle goes on while the request waits.
        stack.step()
        assert "deactivate" not in controller.calls
        controller.gate.set()
        stop.join(10.0)
        assert controller.calls[-2:] == ["update", "deactivate"]
        assert stack.command(POSITION) == -7.0

    def test_the_thread_ends_when_the_controller_is_unloaded(self, threaded):
        stack = threaded()
        follow(stack)
        stack.step()
        assert "controller follow" in names_of_threads()
        stack.deactivate("follow")
        assert stack.manager.unload_controller("follow")
        assert "controller follow" not in names_of_threads()
