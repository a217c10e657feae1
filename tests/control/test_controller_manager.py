"""Loading, configuring, switching and updating controllers."""

import sys

import pytest

from teleopctl.control.controllers.base import InterfaceConfiguration, InterfaceConfigurationType
from teleopctl.control.lifecycle import State
from teleopctl.control.services import ControllerManagerServices
from teleopctl.control.switching import Strictness, SwitchRequest, switch_controller
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.store import get_service
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import ERROR, FAILURE, RETURN_ERROR, TYPE, failing

POSITION = "joint1/position"


@pytest.fixture
def stack():
    return ControlStack(serial_robot())


def add(stack, name, *, configured=True, **parameters):
    controller = stack.load_controller(name, TYPE, parameters)
    if configured:
        assert stack.manager.configure_controller(name)
    return controller


def do_switch(stack, activate=(), deactivate=(), strictness=Strictness.STRICT, *, asap=True):
    return switch_controller(stack.manager, SwitchRequest(activate, deactivate, strictness, asap))


def states(stack):
    return {name: spec.lifecycle_state for name, spec in stack.manager.controllers.items()}


class TestLifeCycle:
    def test_from_load_to_unload(self, stack):
        controller = add(stack, "a", configured=False)
        assert states(stack) == {"a": State.UNCONFIGURED}
        assert stack.manager.configure_controller("a")
        assert states(stack) == {"a": State.INACTIVE}
        stack.step()
        assert controller.updates == 0
        assert do_switch(stack, ["a"])[0]
        assert states(stack) == {"a": State.ACTIVE}
        assert controller.updates == 0
        stack.step(3)
        assert controller.updates == 3
        assert do_switch(stack, [], ["a"])[0]
        stack.step()
        assert controller.updates == 3
        assert stack.manager.unload_controller("a")
        assert states(stack) == {}
        assert controller.calls[-2:] == ["cleanup", "shutdown"]
        assert "a" not in stack.nodes

    def test_a_name_is_loaded_once(self, stack):
        add(stack, "a")
        assert not stack.manager.load_controller("a")
        assert "A controller named 'a' was already loaded" in stack.log.texts("error")[-1]

    def test_a_type_is_needed(self, stack):
        assert not stack.manager.load_controller("a")
        assert stack.log.texts("error") == ["The 'type' param was not defined for 'a'."]

    def test_an_unknown_type_lists_the_known_ones(self, stack):
        stack.node.declare_parameter("a.type", "joint_trajectory_controler/JointTrajectory")
        assert not stack.manager.load_controller("a")
        (error,) = stack.log.texts("error")
        assert error.startswith(
            "Loader for controller 'a' (type 'joint_trajectory_controler/JointTrajectory') not "
            "found. Did you mean joint_trajectory_controller/JointTrajectoryController"
        )
        assert any(
            "joint_trajectory_controller/JointTrajectoryController" in text
            for text in stack.log.texts("info")
        )

    @pytest.mark.parametrize("how", [FAILURE, ERROR, "raise"])
    def test_a_controller_that_cannot_be_initialised_is_not_loaded(self, stack, how):
        stack.node.declare_parameter("a.type", TYPE)
        stack.set_controller_parameters("a", {"failing": failing("init", how)})
        assert not stack.manager.load_controller("a")
        assert states(stack) == {}
        assert stack.nodes == {}

    @pytest.mark.parametrize("how", [FAILURE, ERROR, "raise"])
    def test_a_controller_that_cannot_be_configured_is_unconfigured(self, stack, how):
        add(stack, "a", configured=False, failing=failing("configure", how))
        assert not stack.manager.configure_controller("a")
        assert states(stack) == {"a": State.UNCONFIGURED}

    def test_configuring_again_cleans_up_first(self, stack):
        controller = add(stack, "a")
        assert stack.manager.configure_controller("a")
        assert controller.calls == ["init", "configure", "cleanup", "configure"]

    def test_an_active_controller_is_neither_configured_nor_unloaded(self, stack):
        add(stack, "a")
        do_switch(stack, ["a"])
        assert not stack.manager.configure_controller("a")
        assert not stack.manager.cleanup_controller("a")
        assert not stack.manager.unload_controller("a")
        assert states(stack) == {"a": State.ACTIVE}

    def test_an_interface_asked_for_twice_is_refused(self, stack):
        add(stack, "a", configured=False, commands=[POSITION, POSITION])
        assert not stack.manager.configure_controller("a")

    @pytest.mark.parametrize("rate", ["fast", -1, 10.5, True])
    def test_an_update_rate_that_is_none_is_named(self, stack, rate):
        add(stack, "a", configured=False, update_rate=rate)
        assert not stack.manager.configure_controller("a")
        assert states(stack) == {"a": State.UNCONFIGURED}
        assert "Parameter 'update_rate' must be" in stack.log.texts("error")[-1]

    @pytest.mark.parametrize(
        ("value", "default", "expected"),
        [
            ("joint1", [], "a list"),
            ("fast", 1.0, "a number"),
            (True, 1.0, "a number"),
            (1, False, "true or false"),
            (1.5, 1, "an integer"),
            (5, "", "a string"),
        ],
    )
    def test_a_parameter_of_another_type_is_named(self, stack, value, default, expected):
        controller = add(stack, "a", thing=value)
        with pytest.raises(TeleopctlError, match=f"'thing' must be {expected}, got"):
            controller.auto_declare("thing", default)

    def test_an_integer_serves_as_a_number(self, stack):
        assert add(stack, "a", thing=2).auto_declare("thing", 1.5) == 2.0

    def test_a_controller_that_does_not_know_what_it_needs_is_not_configured(self, stack):
        controller = add(stack, "a", configured=False)
        controller.state_interface_configuration = lambda: 1 / 0
        assert not stack.manager.configure_controller("a")
        assert controller.calls[-1] == "cleanup"
        assert states(stack) == {"a": State.UNCONFIGURED}

    def test_without_a_node_nothing_is_loaded(self, stack):
        def refuse(name):
            raise TeleopctlError(f"cannot read the parameters of {name}")

        stack.node.declare_parameter("a.type", TYPE)
        stack.create_controller_params = refuse
        assert not stack.manager.load_controller("a")
        assert "cannot read the parameters of a" in stack.log.texts("error")[-1]

    def test_fallbacks_that_are_no_list_of_strings_are_refused_in_one_line(self, stack):
        stack.node.declare_parameter("a.type", TYPE)
        stack.node.declare_parameter("a.fallback_controllers", [1, 2])
        assert not stack.manager.load_controller("a")
        assert stack.log.texts("error") == [
            "Could not load controller 'a': Parameter 'a.fallback_controllers' must be a list of "
            "strings, got [1, 2]"
        ]

    def test_a_controller_is_no_fallback_of_itself(self, stack):
        stack.node.declare_parameter("a.type", TYPE)
        stack.node.declare_parameter("a.fallback_controllers", ["a"])
        assert not stack.manager.load_controller("a")


class TestSwitching:
    @pytest.mark.parametrize(
        "strictness", [Strictness.DEFAULT, Strictness.BEST_EFFORT, Strictness.STRICT]
    )
    def test_nothing_to_switch_is_fine_and_unknown_names_are_not(self, stack, strictness):
        assert do_switch(stack, strictness=strictness)[0]
        ok, message = do_switch(stack, ["x"], strictness=strictness)
        assert not ok
        assert "'x' because no controller with this name exists" in message
        assert not do_switch(stack, [], ["x"], strictness=strictness)[0]

    def test_known_and_unknown_names(self, stack):
        add(stack, "a")
        assert not do_switch(stack, ["a", "x"])[0]
        assert states(stack)["a"] is State.INACTIVE
        ok, message = do_switch(stack, ["a", "x"], strictness=Strictness.BEST_EFFORT)
        assert ok
        assert message.splitlines() == [
            "Successfully switched controllers!",
            "Activated controllers: [ a ]",
        ]

    def test_an_unconfigured_controller(self, stack):
        add(stack, "a", configured=False)
        ok, message = do_switch(stack, ["a"])
        assert not ok
        assert "is in 'unconfigured' state" in message
        ok, message = do_switch(stack, ["a"], strictness=Strictness.BEST_EFFORT)
        assert ok
        assert "no controllers need to be activated or deactivated" in message

    def test_active_and_inactive_ones(self, stack):
        add(stack, "a")
        do_switch(stack, ["a"])
        assert "is already active" in do_switch(stack, ["a"])[1]
        add(stack, "b")
        assert "since it is not active" in do_switch(stack, [], ["b"])[1]

    def test_without_a_robot_description_nothing_is_switched(self):
        ok, message = do_switch(ControlStack(), ["a"])
        assert not ok
        assert "Resource Manager is not initialized yet!" in message

    def test_an_interface_has_one_owner(self, stack):
        add(stack, "a", commands=[POSITION])
        add(stack, "b", commands=[POSITION])
        ok, message = do_switch(stack, ["a", "b"])
        assert not ok
        assert "will be used by another controller that is being activated" in message
        assert set(states(stack).values()) == {State.INACTIVE}
        assert do_switch(stack, ["a"])[0]
        ok, message = do_switch(stack, ["b"])
        assert not ok
        assert "is currently claimed by another controller" in message
        assert "'a'" in message
        assert states(stack)["a"] is State.ACTIVE
        assert do_switch(stack, ["b"], ["a"])[0]
        assert states(stack) == {"a": State.INACTIVE, "b": State.ACTIVE}
        assert stack.resources.command_interfaces[POSITION].owner == "b"

    def test_a_controller_can_be_restarted(self, stack):
        controller = add(stack, "a", commands=[POSITION])
        do_switch(stack, ["a"])
        assert do_switch(stack, ["a"], ["a"])[0]
        assert controller.calls[-2:] == ["deactivate", "activate"]
        assert states(stack) == {"a": State.ACTIVE}

    def test_interfaces_that_do_not_exist(self, stack):
        add(stack, "a", commands=["joint9/position"])
        add(stack, "b", states=["joint9/position"])
        assert (
            "the command interface 'joint9/position' is not available" in do_switch(stack, ["a"])[1]
        )
        assert (
            "the state interface 'joint9/position' is not available" in do_switch(stack, ["b"])[1]
        )

    @pytest.mark.parametrize("asap", [True, False])
    @pytest.mark.parametrize("how", [FAILURE, ERROR, "raise"])
    def test_a_failing_activation_frees_what_was_claimed(self, stack, how, asap):
        add(stack, "good", commands=["joint2/position"])
        add(stack, "bad", commands=[POSITION], failing=failing("activate", how))
        ok, message = do_switch(stack, ["good", "bad"], asap=asap)
        assert not ok
        assert "Unable to activate controllers: [ bad ]" in message
        assert states(stack)["good"] is State.INACTIVE
        assert not any(command.claimed for command in stack.resources.command_interfaces.values())
        ok, _ = do_switch(stack, ["good"], strictness=Strictness.BEST_EFFORT, asap=asap)
        assert ok

    def test_hardware_is_told_that_a_strict_switch_came_to_nothing(self, stack):
        told = []
        hardware = stack.resources.components["Hardware"].hardware
        hardware.perform_command_mode_switch = lambda start, stop: told.append((start, stop))
        add(stack, "good", commands=[POSITION])
        add(stack, "bad", failing=failing("activate", FAILURE))
        assert not do_switch(stack, ["good", "bad"])[0]
        assert told == [([POSITION], []), ([], [POSITION])]

    def test_best_effort_keeps_the_others(self, stack):
        add(stack, "good")
        add(stack, "bad", failing=failing("activate", FAILURE))
        ok, _ = do_switch(stack, ["good", "bad"], strictness=Strictness.BEST_EFFORT)
        assert not ok
        assert states(stack) == {"good": State.ACTIVE, "bad": State.INACTIVE}

    @pytest.mark.parametrize("perform", [False, True])
    def test_hardware_may_refuse(self, stack, perform):
        add(stack, "a", commands=[POSITION])
        hardware = stack.resources.components["Hardware"].hardware
        name = "perform_command_mode_switch" if perform else "prepare_command_mode_switch"
        setattr(hardware, name, lambda start, stop: RETURN_ERROR)
        ok, message = do_switch(stack, ["a"])
        assert not ok
        assert states(stack) == {"a": State.INACTIVE}
        if not perform:
            assert message == (
                "Could not switch controllers since prepare command mode switch was rejected."
            )

    def test_a_controller_may_need_all_commands_and_no_state(self, stack):
        controller = add(stack, "a", configured=False)
        every = InterfaceConfiguration(InterfaceConfigurationType.ALL)
        none = InterfaceConfiguration(InterfaceConfigurationType.NONE, ["joint9/position"])
        controller.command_interface_configuration = lambda: every
        controller.state_interface_configuration = lambda: none
        component = stack.resources.components["Hardware"]
        component.change_state(State.UNCONFIGURED)
        assert stack.manager.configure_controller("a")
        assert stack.manager.controllers["a"].required_command_interfaces == ()
        component.change_state(State.ACTIVE)
        assert do_switch(stack, ["a"])[0]
        assert controller.command_interfaces == list(stack.resources.command_interfaces.values())
        assert all(command.owner == "a" for command in controller.command_interfaces)
        assert controller.state_interfaces == []

    def test_a_cycle_that_hangs_does_not_hang_the_switch(self, stack):
        add(stack, "a")
        with stack.manager.cycle_lock:
            ok, message = switch_controller(stack.manager, SwitchRequest(["a"], [], timeout_s=0.01))
        assert not ok
        assert message == "Switch controller timed out after 0.01 seconds!"
        assert states(stack) == {"a": State.INACTIVE}

    def test_inactive_hardware_takes_no_commands(self, stack):
        add(stack, "a", commands=[POSITION])
        stack.resources.components["Hardware"].change_state(State.INACTIVE)
        ok, message = do_switch(stack, ["a"])
        assert not ok
        assert "is in 'inactive' state" in message
        stack.node.declare_parameter(
            "defaults.allow_controller_activation_with_inactive_hardware", True
        )
        assert do_switch(stack, ["a"])[0]


class TestUpdates:
    def test_the_first_period_is_the_nominal_one(self, stack):
        controller = add(stack, "a")
        stack.step(5)
        do_switch(stack, ["a"])
        stack.step(1, period_ns=70_000_000)
        stack.step(1, period_ns=30_000_000)
        assert controller.periods == pytest.approx([0.01, 0.03])

    def test_periods_are_those_of_the_clock_that_triggers_not_of_the_system(self, stack):
        controller = add(stack, "a")
        do_switch(stack, ["a"])
        hour_ns = 3600 * 10**9
        for cycle in range(3):
            stack.cycle.run(cycle * hour_ns, 10**9 + cycle * 20_000_000)
        assert controller.periods == pytest.approx([0.01, 0.02, 0.02])

    @pytest.mark.parametrize("rate", [10, 12, 16, 23, 37, 40, 50, 63, 71, 85, 90])
    def test_slower_controllers(self, stack, rate):
        controller = add(stack, "a", update_rate=rate)
        do_switch(stack, ["a"])
        stack.step(100)
        assert abs(controller.updates - 1 / (round(100 / rate) / 100)) <= 1
        assert controller.periods[0] == pytest.approx(1 / rate, abs=1e-6)
        assert min(controller.periods) > 0

    @pytest.mark.parametrize("rate", [100, 232, 400])
    def test_no_controller_is_faster_than_the_manager(self, stack, rate):
        controller = add(stack, "a", update_rate=rate)
        do_switch(stack, ["a"])
        stack.step(50)
        assert controller.updates == 50

    @pytest.mark.parametrize("how", [RETURN_ERROR, "raise"])
    def test_a_failing_update_stops_only_that_controller(self, stack, how):
        bad = add(stack, "bad", commands=[POSITION], failing=failing("update", how))
        good = add(stack, "good")
        do_switch(stack, ["bad", "good"])
        stack.step(3)
        assert (bad.updates, good.updates) == (1, 3)
        assert states(stack) == {"bad": State.INACTIVE, "good": State.ACTIVE}
        assert stack.resources.command_interfaces[POSITION].owner is None
        expected = "Deactivating controllers : [ bad ] as their update resulted in an error!"
        assert expected in stack.log.texts("error")

    def test_a_fallback_takes_over_in_the_same_cycle(self, stack):
        stack.node.declare_parameter("bad.fallback_controllers", ["fallback"])
        add(stack, "bad", commands=[POSITION], failing=failing("update", "raise"))
        fallback = add(stack, "fallback", configured=False, commands=[POSITION])
        assert "fallback" in do_switch(stack, ["bad"])[1]
        stack.manager.configure_controller("fallback")
        assert do_switch(stack, ["bad"])[0]
        stack.step()
        assert states(stack) == {"bad": State.INACTIVE, "fallback": State.ACTIVE}
        stack.step()
        assert fallback.updates == 1

    def test_a_fallback_that_has_been_cleaned_up_meanwhile_is_not_started(self, stack):
        stack.node.declare_parameter("bad.fallback_controllers", ["fallback"])
        add(stack, "bad", commands=[POSITION], failing=failing("update", "raise"))
        add(stack, "fallback", commands=[POSITION])
        assert do_switch(stack, ["bad"])[0]
        assert stack.manager.cleanup_controller("fallback")
        stack.step()
        assert states(stack) == {"bad": State.INACTIVE, "fallback": State.UNCONFIGURED}

    def test_hardware_that_fails_to_read_stops_its_controllers(self, stack):
        add(stack, "user", states=[POSITION])
        add(stack, "other")
        do_switch(stack, ["user", "other"])
        hardware = stack.resources.components["Hardware"].hardware
        hardware.read = lambda time_ns, period: RETURN_ERROR
        stack.step()
        assert states(stack) == {"user": State.INACTIVE, "other": State.ACTIVE}
        assert stack.resources.components["Hardware"].lifecycle_state is State.UNCONFIGURED


class TestHardwareLoading:
    def test_an_unknown_plugin_is_named(self):
        with pytest.raises(TeleopctlError, match="plugin 'no/Such' not found") as failure:
            ControlStack(serial_robot(plugin="no/Such"))
        assert "mock_components/GenericSystem as its <plugin>" in str(failure.value.hint)

    def test_a_plugin_that_cannot_be_made_is_named(self):
        with pytest.raises(TeleopctlError, match=r"plugin .tests\.control\.fakes:Broken. raised"):
            ControlStack(serial_robot(plugin="tests.control.fakes:Broken"))

    def test_a_plugin_of_the_user_by_class(self):
        stack = ControlStack(serial_robot(plugin="teleopctl.control.hardware.mock:GenericSystem"))
        assert stack.resources.components["Hardware"].lifecycle_state is State.ACTIVE

    def test_a_mimic_joint_in_the_old_form_is_told_with_the_line_that_replaces_it(self):
        follower = (
            '<link name="tip"/><joint name="follower" type="revolute"><parent link="link1"/>'
            '<child link="tip"/><axis xyz="0 0 1"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
        control = (
            '<joint name="follower"><param name="mimic">joint1</param>'
            '<param name="multiplier">-1</param><state_interface name="position"/></joint>'
        )
        stack = ControlStack(serial_robot(joints=1, extra_joints=follower, extra_control=control))
        assert any('<mimic joint="joint1"' in text for text in stack.log.texts("warning"))
        stack.step()
        values = {name: state.value for name, state in stack.resources.state_interfaces.items()}
        assert values == {"joint1/position": 1.1, "follower/position": -1.1}

    def test_availability_follows_the_life_cycle(self, stack):
        component = stack.resources.components["Hardware"]
        interface = stack.resources.command_interfaces[POSITION]
        assert interface.available
        component.change_state(State.INACTIVE)
        assert interface.available
        component.change_state(State.UNCONFIGURED)
        assert not interface.available
        component.change_state(State.FINALIZED)
        assert not component.change_state(State.ACTIVE)


def test_a_request_that_raises_is_answered_with_a_failure(stack):
    ControllerManagerServices(stack.node, stack.manager).offer_switching()
    kind = get_service("controller_manager_msgs/srv/SwitchController")

    def explode(*arguments, **options):
        raise RuntimeError("a plug-in's mistake")

    stack.resources.prepare_command_mode_switch = explode
    add(stack, "a", commands=[POSITION])
    serve = stack.node.endpoints["~/switch_controller"].callback
    response = serve(kind.Request(activate_controllers=["a"], strictness=2), kind.Response())
    assert not response.ok
    assert "a plug-in's mistake" in response.message
    assert not stack.manager.cycle_lock.locked()


CHANGING = """
from changing_helper import STEP
from teleopctl.control import ControllerInterface

class Changing(ControllerInterface):
    version = {version}
    step = STEP

    def update(self, time_ns, period):
        pass
"""


class TestReload:
    """Edits follow one another within one second, and the lengths of the files stay the same."""

    target = "changing_controller:Changing"

    @pytest.fixture
    def save(self, stack, tmp_path, monkeypatch):
        monkeypatch.syspath_prepend(str(tmp_path))
        ControllerManagerServices(stack.node, stack.manager)
        known = set(sys.modules)

        def save(version, step, then=""):
            (tmp_path / "changing_controller.py").write_text(CHANGING.format(version=version))
            (tmp_path / "changing_helper.py").write_text(f"STEP = {step}\n{then}")

        save(1, 1)
        yield save
        for name in set(sys.modules) - known:
            if name.startswith("changing"):
                del sys.modules[name]

    def reload(self, stack, *, force_kill=False):
        kind = get_service("controller_manager_msgs/srv/ReloadControllerLibraries")
        serve = stack.node.endpoints["~/reload_controller_libraries"].callback
        return serve(kind.Request(force_kill=force_kill), kind.Response()).ok

    def load(self, stack):
        controller = stack.load_controller("changing", self.target, {})
        return controller.version, controller.step

    def test_what_is_loaded_next_runs_the_code_of_the_file_and_of_what_it_imports(
        self, stack, save
    ):
        assert self.load(stack) == (1, 1)
        save(2, 3)
        assert self.reload(stack)
        assert stack.manager.controllers == {}
        assert self.load(stack) == (2, 3)

    def test_it_is_read_again_where_none_is_loaded_any_more(self, stack, save):
        assert self.load(stack) == (1, 1)
        assert stack.manager.unload_controller("changing")
        save(1, 2)
        assert self.reload(stack)
        assert self.load(stack) == (1, 2)

    def test_modules_of_others_stay_what_they_are(self, stack, save, monkeypatch):
        save(1, "__import__('json').JSONDecoder")
        others = {name: sys.modules[name] for name in ("json", "teleopctl.control", "tests")}
        self.load(stack)
        assert self.reload(stack)
        assert {name: sys.modules[name] for name in others} == others

    def test_active_controllers_are_stopped_where_that_is_asked(self, stack, save):
        self.load(stack)
        stack.activate("changing")
        assert not self.reload(stack)
        assert "there are still 1 active controllers: changing" in stack.log.texts("error")[-1]
        assert states(stack) == {"changing": State.ACTIVE}
        save(2, 2)
        assert self.reload(stack, force_kill=True)
        assert states(stack) == {}
        assert self.load(stack) == (2, 2)

    def test_broken_code_is_refused_with_its_line_and_nothing_is_stopped(
        self, stack, save, tmp_path
    ):
        self.load(stack)
        stack.activate("changing")
        save(2, 2, then="def (:")
        assert not self.reload(stack, force_kill=True)
        where = f"{tmp_path / 'changing_helper.py'}:2: "
        assert where in stack.log.texts("error")[-1]
        assert "SyntaxError: invalid syntax" in stack.log.texts("error")[-1]
        assert states(stack) == {"changing": State.ACTIVE}
        stack.deactivate("changing")
        stack.manager.unload_controller("changing")
        assert self.load(stack) == (1, 1), "the old code can be loaded"
        stack.manager.unload_controller("changing")
        save(3, 3)
        assert self.reload(stack)
        assert self.load(stack) == (3, 3)

    def test_a_file_that_is_gone_hinders_nobody(self, stack, save, tmp_path):
        self.load(stack)
        (tmp_path / "changing_controller.py").unlink()
        assert self.reload(stack)
        stack.node.declare_parameter("other.type", self.target)
        assert not stack.manager.load_controller("other")
        assert "No module named 'changing_controller'" in stack.log.texts("error")[-1]

    def test_what_is_mended_after_a_failed_load_is_read_again(self, stack, save, tmp_path):
        (tmp_path / "changing_helper.py").write_text("STEPP = 1\n")
        stack.node.declare_parameter("changing.type", self.target)
        assert not stack.manager.load_controller("changing")
        (error,) = stack.log.texts("error")
        assert error.startswith(
            f"Could not load controller 'changing' (type '{self.target}'): "
            f"{tmp_path / 'changing_controller.py'}:2: "
        )
        assert "cannot import name 'STEP' from 'changing_helper'" in error
        save(1, 5)
        assert stack.manager.load_controller("changing")


FAILING = """
from teleopctl.control import ControllerInterface

class Failing(ControllerInterface):
    def __init__(self, params):
        super().__init__(params)
        self.fail("init")

    def fail(self, where):
        if self.auto_declare("where", "") == where:
            [][1]

    def on_init(self):
        self.fail("on_init")

    def on_configure(self):
        self.fail("on_configure")
        if self.auto_declare("where", "") == "in ours":
            self.auto_declare("where", 1.0)

    def on_activate(self):
        self.fail("on_activate")

    def on_deactivate(self):
        self.fail("on_deactivate")

    def on_cleanup(self):
        self.fail("on_cleanup")
"""


class TestCauses:
    """What a user's code raises is reported with its class, its text and the line of its file."""

    @pytest.fixture
    def add_failing(self, stack, tmp_path, monkeypatch):
        monkeypatch.syspath_prepend(str(tmp_path))
        source = tmp_path / "failing_controller.py"
        source.write_text(FAILING)
        line = f"IndexError: list index out of range ({source}:11)"

        def add_failing(where):
            stack.node.declare_parameter("a.type", "failing_controller:Failing")
            stack.set_controller_parameters("a", {"where": where})
            return line

        yield add_failing
        sys.modules.pop("failing_controller", None)

    @pytest.mark.parametrize(("where", "by"), [("init", ""), ("on_init", "on_init raised ")])
    def test_in_its_beginning(self, stack, add_failing, where, by):
        line = add_failing(where)
        assert not stack.manager.load_controller("a")
        expected = f"Could not initialize the controller named 'a': {by}{line}"
        assert stack.log.texts("error")[-1] == expected

    def test_while_it_is_configured(self, stack, add_failing):
        line = add_failing("on_configure")
        assert stack.manager.load_controller("a")
        assert not stack.manager.configure_controller("a")
        expected = f"Could not configure the controller named 'a': on_configure raised {line}"
        assert stack.log.texts("error")[-1] == expected

    def test_of_what_ours_raises_the_line_that_called_it(self, stack, add_failing, tmp_path):
        add_failing("in ours")
        assert stack.manager.load_controller("a")
        assert not stack.manager.configure_controller("a")
        assert f"({tmp_path / 'failing_controller.py'}:19)" in stack.log.texts("error")[-1]

    @pytest.mark.parametrize("strictness", [1, 2])
    def test_the_answer_to_a_switch_tells_it(self, stack, add_failing, strictness):
        line = add_failing("on_activate")
        assert stack.manager.load_controller("a")
        assert stack.manager.configure_controller("a")
        ok, message = do_switch(stack, ["a"], strictness=Strictness(strictness))
        assert not ok
        assert message.endswith(
            f"Unable to activate controllers: [ a ]\na: on_activate raised {line}"
        )
        assert states(stack) == {"a": State.UNCONFIGURED}

    def test_of_a_deactivation_too(self, stack, add_failing):
        line = add_failing("on_deactivate")
        assert stack.manager.load_controller("a")
        assert stack.manager.configure_controller("a")
        assert do_switch(stack, ["a"])[0]
        ok, message = do_switch(stack, [], ["a"])
        assert not ok
        assert message.endswith(f"a: on_deactivate raised {line}")


def raise_system_exit(*_):
    raise SystemExit(3)


class TestStatesAfterFailures:
    """What is reported after a failure is what is."""

    def hardware(self, stack):
        (component,) = stack.resources.components.values()
        return component.hardware

    def test_a_controller_that_ends_the_program_in_its_update_is_stopped(self, stack):
        controller = add(stack, "a", commands=[POSITION])
        assert do_switch(stack, ["a"])[0]
        controller.update = raise_system_exit
        stack.step()
        assert states(stack) == {"a": State.INACTIVE}
        assert stack.manager.active_controllers == ()
        assert stack.resources.command_interfaces[POSITION].owner is None

    @pytest.mark.parametrize("function", ["read", "write"])
    @pytest.mark.parametrize("do", [raise_system_exit, lambda *_: "an error"])
    def test_hardware_that_answers_with_nonsense_has_failed(self, stack, function, do):
        add(stack, "a", commands=[POSITION])
        assert do_switch(stack, ["a"])[0]
        setattr(self.hardware(stack), function, do)
        stack.step(3)
        (component,) = stack.resources.components.values()
        assert component.lifecycle_state is State.UNCONFIGURED
        assert states(stack) == {"a": State.INACTIVE}
        assert len([t for t in stack.log.texts("error") if "Deactivating following" in t]) == 1

    def test_hardware_that_fails_during_a_slow_activation_leaves_nothing_active(self, stack):
        controller = add(stack, "a", commands=[POSITION])

        def activate_while_the_hardware_fails():
            self.hardware(stack).read = raise_system_exit
            stack.step()

        controller.on_activate = activate_while_the_hardware_fails
        ok, message = do_switch(stack, ["a"], asap=False)
        assert not ok
        assert "a: its hardware has failed" in message
        assert states(stack) == {"a": State.INACTIVE}
        assert stack.resources.command_interfaces[POSITION].owner is None
