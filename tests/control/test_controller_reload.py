"""Reloading the changed code of a controller while it runs."""

import sys
import threading
from importlib.util import cache_from_source
from pathlib import Path

import pytest

from teleopctl import plugins
from teleopctl.control.lifecycle import State
from teleopctl.control.reloading.controller_reload import ControllerReload, ReloadError
from teleopctl.interfaces.store import get_action, get_message
from teleopctl.node import GoalState
from teleopctl.testing import ControlStack, eventually, serial_robot

COMMAND = "joint1/position"

RAMP = """\
from ramp_step import STEP
from std_msgs.msg import Float64

from teleopctl.control import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)


class Ramp(ControllerInterface):
    calls = []

    def on_configure(self):
        self.gain = self.auto_declare("gain", 1.0)
        self.publisher = self.get_node().create_publisher(Float64, "~/value", 10)
        self.input = self.get_node().create_subscription(Float64, "~/start", self.start, 10)

    def on_cleanup(self):
        self.get_node().destroy_publisher(self.publisher)
        self.get_node().destroy_subscription(self.input)

    def start(self, message):
        self.value = message.data

    def command_interface_configuration(self):
        names = ["joint1/position"]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def on_activate(self):
        self.value = 0.0

    def on_deactivate(self):
        self.calls.append("deactivate")

    def export_state(self):
        return {"value": self.value}

    def import_state(self, state):
        self.value = state["value"]

    def update(self, time_ns, period):
        self.value += STEP * self.gain
        self.command_interfaces[0].value = self.value
"""


class Code:
    """Files of a user's controller.

    Attributes:
        folder: Folder of the files.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def save(self, text: str, file: str = "ramp.py") -> None:
        (self.folder / file).write_text(text)

    def edit(self, *changes: tuple[str, str], file: str = "ramp.py") -> None:
        text = (self.folder / file).read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        self.save(text, file)

    def line(self, words: str, file: str = "ramp.py") -> str:
        """Return ``file:line`` of the first line with these words."""
        lines = (self.folder / file).read_text().splitlines()
        number = next(at for at, line in enumerate(lines, 1) if words in line)
        return f"{self.folder / file}:{number}"


@pytest.fixture
def code(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    known = set(sys.modules)
    code = Code(tmp_path)
    code.save("STEP = 0.01\n", "ramp_step.py")
    code.save(RAMP)
    yield code
    for name in set(sys.modules) - known:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]


@pytest.fixture
def stack():
    return ControlStack(serial_robot(joints=2, initial=(0.0, 0.0)))


@pytest.fixture
def ramp(stack, code):
    """The running controller, after ten updates."""
    controller = stack.load_controller("ramp", "ramp:Ramp", {})
    stack.activate("ramp")
    stack.step(10)
    return controller


def controller(stack, name="ramp"):
    return stack.manager.controllers[name].controller


class TestReload:
    def test_the_changed_code_commands_from_the_next_cycle_on(self, stack, code, ramp):
        code.edit(("self.value += STEP", "self.value -= STEP"))
        assert stack.reload_controller("ramp") == "ramp"
        assert stack.command(COMMAND) == pytest.approx(0.09)
        assert controller(stack) is not ramp
        assert controller(stack).lifecycle_state is State.ACTIVE
        assert stack.resources.command_interfaces[COMMAND].owner == "ramp"
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.08)

    def test_a_changed_helper_is_read_with_what_imports_it_and_nothing_else(
        self, stack, code, ramp
    ):
        code.save("shared = object()\n", "ramp_bus.py")
        code.edit(("import STEP", "import STEP\nimport ramp_bus"))
        stack.reload_controller("ramp")
        bus = sys.modules["ramp_bus"]
        code.save("STEP = 0.02\n", "ramp_step.py")
        assert stack.reload_controller("ramp") == "ramp, ramp_step"
        assert stack.command(COMMAND) == pytest.approx(0.13)
        assert sys.modules["ramp_bus"] is bus, "an unchanged module keeps its state"

    def test_a_large_module_is_compiled_outside_of_the_process(self, stack, code, ramp):
        code.save("STEP = 0.02\n" + "# a comment\n" * 1000, "ramp_step.py")
        compiled = Path(cache_from_source(str(code.folder / "ramp_step.py")))
        stack.reload_controller("ramp")
        assert stack.command(COMMAND) == pytest.approx(0.12)
        assert compiled.read_bytes()[4] == 3, "by the hash of the source"
        code.edit(("0.02", "0.03"), file="ramp_step.py")
        stack.reload_controller("ramp")
        assert stack.command(COMMAND) == pytest.approx(0.15)

    def test_without_exported_state_attributes_of_the_activation_keep_their_values(
        self, stack, code
    ):
        cut = RAMP[RAMP.index("    def export_state") : RAMP.index("    def update")]
        code.edit((cut, ""))
        begin = "    def begin(self):\n        self.value, self.all = 0.0, [0.0]\n\n"
        code.edit(("    def on_activate", f"{begin}    def on_activate"))
        code.edit(
            ("        self.value = 0.0\n", "        self.begin()\n        self.seen = None\n")
        )
        seen = "        self.seen = time_ns\n        self.all.append(self.value)\n"
        code.edit(("        self.value += STEP", f"{seen}        self.value += STEP"))
        old = stack.load_controller("ramp", "ramp:Ramp", {})
        stack.activate("ramp")
        stack.step(10)
        code.edit(('"gain", 1.0', '"gain", 2.0'))
        stack.reload_controller("ramp")
        new = controller(stack)
        assert stack.command(COMMAND) == pytest.approx(0.12)
        assert new.gain == 2.0, "an attribute of on_configure is the new code's"
        assert new.all[:11] == old.all
        assert len(old.all) == 11, "the old code's list is another one"
        assert type(new).__name__ == "Ramp"
        code.edit(("self.seen = time_ns\n", "assert self.seen == time_ns - 10_000_000\n"))
        stack.reload_controller("ramp")

    def test_the_old_code_is_released_but_not_deactivated(self, stack, code, ramp):
        code.edit(('"~/start"', '"~/begin"'))
        stack.reload_controller("ramp")
        assert ramp.calls == []
        assert set(stack.nodes["ramp"].endpoints) == {"~/value", "~/begin"}

    def test_its_topics_stay_and_lead_to_the_new_code(self, stack, code, ramp):
        before = dict(stack.nodes["ramp"].endpoints)
        code.edit(("self.value = message.data", "self.value = -message.data"))
        stack.reload_controller("ramp")
        assert stack.nodes["ramp"].endpoints == before
        stack.nodes["ramp"].receive("~/start", get_message("std_msgs/msg/Float64")(data=0.5))
        assert controller(stack).value == -0.5
        stack.deactivate("ramp")
        assert stack.manager.unload_controller("ramp"), "the new code can destroy them"
        assert before["~/start"].callback.__self__ is not ramp

    def test_it_keeps_the_parameters_that_were_set_and_takes_new_defaults(self, stack, code, ramp):
        node = stack.nodes["ramp"]
        code.edit(('"gain", 1.0', '"gain", 3.0'))
        stack.reload_controller("ramp")
        assert node.get_parameter("gain").value == 3.0
        assert stack.command(COMMAND) == pytest.approx(0.13)
        node.set_parameters([node.get_parameter("gain").__class__("gain", value=5.0)])
        code.edit(('"gain", 3.0', '"gain", 2.0'))
        stack.reload_controller("ramp")
        assert node.get_parameter("gain").value == 5.0
        code.edit(('self.auto_declare("gain", 2.0)', '2.0 * self.auto_declare("strength", 1.0)'))
        stack.reload_controller("ramp")
        assert not node.has_parameter("gain")
        assert node.has_parameter("strength")

    def test_parameters_can_be_declared_as_rclpy_does(self, stack, code):
        code.edit(
            ('self.auto_declare("gain", 1.0)', 'self.get_node().declare_parameter("k", 2.0).value')
        )
        stack.load_controller("ramp", "ramp:Ramp", {})
        stack.activate("ramp")
        stack.reload_controller("ramp")
        assert controller(stack).gain == 2.0

    def test_new_interfaces_are_claimed_and_old_ones_released(self, stack, code, ramp):
        code.edit(('"joint1/position"', '"joint2/position"'))
        stack.reload_controller("ramp")
        owners = {name: one.owner for name, one in stack.resources.command_interfaces.items()}
        assert owners == {"joint1/position": None, "joint2/position": "ramp"}
        assert stack.command("joint2/position") == pytest.approx(0.11)

    @pytest.mark.parametrize("state", [State.UNCONFIGURED, State.INACTIVE, State.FINALIZED])
    def test_a_controller_that_does_not_run_is_reloaded_too(self, stack, code, state):
        stack.load_controller("ramp", "ramp:Ramp", {})
        if state is State.INACTIVE:
            assert stack.manager.configure_controller("ramp")
        controller(stack).lifecycle_state = state
        code.edit(("self.value = 0.0", "self.value = 0.7"))
        stack.reload_controller("ramp")
        expected = State.UNCONFIGURED if state is State.FINALIZED else state
        assert controller(stack).lifecycle_state is expected
        stack.activate("ramp")
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.71)

    def test_it_can_be_reloaded_where_nothing_has_changed(self, stack, code, ramp):
        assert stack.reload_controller("ramp") == "no file has changed"
        assert stack.command(COMMAND) == pytest.approx(0.11)

    @pytest.mark.parametrize("kind", ["file", "package"])
    def test_the_code_may_be_a_file_or_a_package_that_is_not_installed(
        self, stack, code, kind, monkeypatch
    ):
        monkeypatch.setattr(sys, "path", [one for one in sys.path if one != str(code.folder)])
        type_name = f"{code.folder / 'ramp.py'}:Ramp"
        if kind == "package":
            code.save('<package format="3"><name>ramps</name></package>', "package.xml")
            points = "{'teleopctl.controllers': ['ramps/Ramp = ramp:Ramp']}"
            code.save(f"from setuptools import setup\nsetup(entry_points={points})", "setup.py")
            monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(code.folder))
            type_name = "ramps/Ramp"
        stack.load_controller("ramp", type_name, {})
        stack.activate("ramp")
        code.edit(("self.value += STEP", "self.value -= STEP"))
        assert stack.reload_controller("ramp") == "ramp"
        assert stack.command(COMMAND) == pytest.approx(-0.01)

    def test_an_unknown_name_is_refused_with_those_that_are_loaded(self, stack, ramp):
        with pytest.raises(
            ReloadError, match="no controller with this name exists; loaded are: ramp"
        ):
            ControllerReload(stack.manager, "rump")


FAULTS = {
    "syntax": ("def on_activate(self):", "def on_activate(self:", "SyntaxError"),
    "import": ("import STEP", "import STEPP", "ImportError"),
    "constructor": ("calls = []", "def __init__(self, p): 1 / 0", "its constructor raised ZeroDiv"),
    "init": ("calls = []", "def on_init(self): 1 / 0", "on_init raised ZeroDivisionError"),
    "configure": ("self.gain = ", "self.gain = 1 / 0 * ", "on_configure raised ZeroDiv"),
    "claims": ("names = [", "names = [1 / 0, ", "command_interface_configuration raised Zero"),
    "activate": ("self.value = 0.0", "1 / 0", "on_activate raised ZeroDivisionError"),
    "state": ('state["value"]', 'state["valu"]', "import_state raised KeyError: 'valu'"),
    "update": ("self.value += STEP", "self.value /= 0", "its first update raised ZeroDiv"),
}


class TestFailure:
    @pytest.mark.parametrize("phase", FAULTS)
    def test_in_any_phase_the_old_code_goes_on_and_file_and_line_are_named(
        self, stack, code, ramp, phase
    ):
        old, new, words = FAULTS[phase]
        code.edit((old, new))
        endpoints = dict(stack.nodes["ramp"].endpoints)
        with pytest.raises(ReloadError, match=words) as failure:
            stack.reload_controller("ramp")
        assert code.line(new) in str(failure.value)
        assert controller(stack) is ramp
        before = stack.command(COMMAND)
        assert before == pytest.approx(0.11 if phase == "update" else 0.10)
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(before + 0.01)
        assert stack.nodes["ramp"].endpoints == endpoints
        code.edit((new, old))
        stack.reload_controller("ramp")
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(before + 0.03)

    def test_a_new_helper_that_is_broken_is_among_the_files_to_watch(self, stack, code, ramp):
        code.save("def (", "ramp_new.py")
        code.edit(("import STEP", "import STEP\nimport ramp_new"))
        with pytest.raises(ReloadError, match="SyntaxError") as failure:
            stack.reload_controller("ramp")
        assert failure.value.file == str(code.folder / "ramp_new.py")

    def test_what_new_code_has_created_is_destroyed_if_it_fails(self, stack, code, ramp):
        code.edit(('"~/start", self.start, 10)', '"~/begin", self.start, 10)\n        1 / 0'))
        before = dict(stack.nodes["ramp"].endpoints)
        with pytest.raises(ReloadError, match="on_configure raised ZeroDivisionError"):
            stack.reload_controller("ramp")
        assert stack.nodes["ramp"].endpoints == before

    def test_a_class_that_was_renamed_is_named_with_its_file(self, stack, code, ramp):
        code.edit(("class Ramp(", "class Ramps("))
        with pytest.raises(ReloadError, match="no attribute 'Ramp'") as failure:
            stack.reload_controller("ramp")
        assert str(code.folder / "ramp.py") in str(failure.value)
        assert "Did you mean Ramps?" in str(failure.value)
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.11)

    def test_a_callback_that_returns_failure_is_named_with_its_line(self, stack, code, ramp):
        code.edit(
            (
                "def on_activate(self):",
                "def on_activate(self):\n        return CallbackReturn.FAILURE",
            )
        )
        code.edit(("    ControllerInterface,", "    CallbackReturn,\n    ControllerInterface,"))
        with pytest.raises(ReloadError, match="on_activate returned FAILURE") as failure:
            stack.reload_controller("ramp")
        assert code.line("def on_activate") in str(failure.value)

    def test_what_a_failed_first_update_commanded_is_taken_back(self, stack, code, ramp):
        code.edit(
            (
                "        self.command_interfaces[0].value = self.value",
                "        self.command_interfaces[0].value = 9.0\n        raise OSError",
            )
        )
        with pytest.raises(ReloadError, match="its first update raised OSError"):
            stack.reload_controller("ramp")
        assert stack.command(COMMAND) == pytest.approx(0.11)

    def test_an_error_of_the_first_update_is_a_failure_and_of_a_later_one_is_the_new_codes(
        self, stack, code, ramp
    ):
        code.edit(("    ControllerInterface,", "    ControllerInterface,\n    ReturnType,"))
        code.edit(
            ("[0].value = self.value", "[0].value = self.value\n        return ReturnType.ERROR")
        )
        with pytest.raises(ReloadError, match="its first update returned ERROR"):
            stack.reload_controller("ramp")
        assert controller(stack) is ramp
        code.edit(
            ("return ReturnType.ERROR", "return ReturnType.ERROR if self.value > 0.125 else None")
        )
        stack.reload_controller("ramp")
        stack.step()
        assert controller(stack).lifecycle_state is State.INACTIVE

    @pytest.mark.parametrize("hang", ["while True: pass", "ramp_event.wait()"])
    def test_code_that_does_not_return_is_named_with_its_line_and_ended_if_it_computes(
        self, stack, code, ramp, hang
    ):
        event = threading.Event()
        sys.modules["ramp_event"] = event  # type: ignore[assignment]
        code.edit(("self.gain = ", f"import ramp_event\n        {hang}\n        self.gain = "))
        reload = ControllerReload(stack.manager, "ramp")
        outcome: list[ReloadError] = []

        def prepare() -> None:
            try:
                reload.prepare()
            except ReloadError as error:
                outcome.append(error)

        thread = threading.Thread(target=prepare)
        thread.start()
        eventually(lambda: hang_is_reached(thread, code.line(hang)))
        words = reload.abandon()
        assert words == f"on_configure has not returned ({code.line(hang)})"
        event.set()
        thread.join(10.0)
        assert outcome
        del sys.modules["ramp_event"]
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.11)
        assert plugins.load(plugins.CONTROLLERS, "ramp:Ramp") is type(ramp)

    def test_one_that_is_unloaded_meanwhile_is_not_reloaded(self, stack, code, ramp):
        reload = ControllerReload(stack.manager, "ramp")
        reload.prepare()
        stack.deactivate("ramp")
        assert stack.manager.unload_controller("ramp")
        with pytest.raises(ReloadError, match="unloaded meanwhile"):
            reload.commit()


def hang_is_reached(thread, place):
    file, _, line = place.rpartition(":")
    frame = sys._current_frames().get(thread.ident)
    while frame is not None:
        if frame.f_code.co_filename == file and frame.f_lineno == int(line):
            return True
        frame = frame.f_back
    return False


REACH = """\
from control_msgs.action import GripperCommand

from teleopctl.control import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
    RealtimeServerGoalHandle,
)
from teleopctl.node import CancelResponse, GoalResponse


class Reach(ControllerInterface):
    goal = None

    def on_configure(self):
        self.server = self.create_action_server(
            GripperCommand,
            "~/reach",
            goal_callback=lambda goal: GoalResponse.ACCEPT,
            handle_accepted_callback=self.begin,
            cancel_callback=lambda handle: CancelResponse.ACCEPT,
        )

    def on_cleanup(self):
        self.server.destroy()

    def begin(self, handle):
        handle.executing()
        queue = self.params.publish_queue
        self.goal = RealtimeServerGoalHandle(handle, GripperCommand, queue)

    def command_interface_configuration(self):
        names = ["joint1/position"]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    state_interface_configuration = command_interface_configuration

    def update(self, time_ns, period):
        if self.goal is not None:
            wanted = self.goal.handle.request.command.position
            away = wanted - self.state_interfaces[0].value
            step = max(-0.01, min(0.01, away))
            self.command_interfaces[0].value = self.state_interfaces[0].value + step
            if abs(away) < 1e-9:
                self.goal.try_succeed(position=wanted)
                self.goal = None
"""


class TestGoals:
    @pytest.fixture
    def goal(self, stack, code):
        code.save(REACH, "reach.py")
        stack.load_controller("reach", "reach:Reach", {})
        stack.activate("reach")
        action = get_action("control_msgs/action/GripperCommand")
        goal = stack.action_servers["reach/reach"].send_goal(
            action.Goal(command=get_message("control_msgs/msg/GripperCommand")(position=0.3))
        )
        stack.step(10)
        assert goal.status == GoalState.EXECUTING
        return goal

    def test_without_an_exported_state_new_code_gets_the_active_goals_as_if_just_accepted(
        self, stack, code, goal
    ):
        code.edit(("-0.01, min(0.01,", "-0.02, min(0.02,"), file="reach.py")
        stack.reload_controller("reach")
        assert goal.status == GoalState.EXECUTING
        stack.step(9)
        assert stack.command(COMMAND) == pytest.approx(0.3)
        stack.step(2)
        assert goal.status == GoalState.SUCCEEDED
        assert stack.action_servers["reach/reach"].result(goal).position == pytest.approx(0.3)

    @pytest.mark.parametrize(
        ("old", "new"),
        [("handle.executing()", "1 / 0"), ("wanted = self", "wanted = 1 / 0 * self")],
    )
    def test_if_the_new_code_fails_the_goal_is_still_the_old_codes(
        self, stack, code, goal, old, new
    ):
        code.edit((old, new), file="reach.py")
        with pytest.raises(ReloadError, match="ZeroDivisionError"):
            stack.reload_controller("reach")
        assert goal.status == GoalState.EXECUTING
        stack.step(24)
        assert goal.status == GoalState.SUCCEEDED

    def test_requests_go_to_the_new_code(self, stack, code, goal):
        code.edit(("GoalResponse.ACCEPT", "GoalResponse.REJECT"), file="reach.py")
        stack.reload_controller("reach")
        assert stack.action_servers["reach/reach"].send_goal(goal.request) is None


GENTLE = """\
from teleopctl.control import (
    ChainableControllerInterface,
    CommandInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)


class Gentle(ChainableControllerInterface):
    def on_export_reference_interfaces_list(self):
        self.reference = CommandInterface(f"{self.name}/joint1", "position")
        return [self.reference]

    def command_interface_configuration(self):
        names = ["joint1/position"]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def on_activate(self):
        self.reference.value = float("nan")

    def update_and_write_commands(self, time_ns, period):
        self.command_interfaces[0].value = 0.5 * self.reference.value
"""


class TestChains:
    @pytest.fixture
    def chain(self, stack, code):
        code.save(GENTLE, "gentle.py")
        code.edit(('"joint1/position"', '"gentle/joint1/position"'))
        stack.load_controller("gentle", "gentle:Gentle", {})
        assert stack.manager.configure_controller("gentle")
        stack.load_controller("ramp", "ramp:Ramp", {})
        stack.activate("gentle", "ramp")
        stack.step(10)
        assert stack.command(COMMAND) == pytest.approx(0.05)
        return code

    def test_the_commanded_one_stays_in_its_chain_with_its_last_reference(self, stack, chain):
        chain.edit(("0.5 *", "0.25 *"), file="gentle.py")
        assert stack.reload_controller("gentle") == "gentle"
        assert stack.command(COMMAND) == pytest.approx(0.0275)
        assert controller(stack, "gentle").in_chained_mode
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.03)
        stack.deactivate("ramp")
        assert not controller(stack, "gentle").in_chained_mode

    def test_the_commanding_one_keeps_its_claims(self, stack, chain):
        chain.save("STEP = 0.1\n", "ramp_step.py")
        stack.reload_controller("ramp")
        assert stack.command(COMMAND) == pytest.approx(0.1)

    def test_a_failed_update_leaves_the_chain_as_it_was(self, stack, chain):
        before = controller(stack, "gentle")
        chain.edit(("0.5 *", "1 / 0 *"), file="gentle.py")
        with pytest.raises(ReloadError, match="ZeroDivisionError"):
            stack.reload_controller("gentle")
        assert controller(stack, "gentle") is before
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.06)

    def test_a_reference_in_use_cannot_go(self, stack, chain):
        chain.edit(("/joint1", "/joint9"), file="gentle.py")
        with pytest.raises(
            ReloadError, match="no longer exports 'gentle/joint1/position', which 'ramp' uses"
        ):
            stack.reload_controller("gentle")
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.055)

    def test_a_chain_in_a_circle_is_refused(self, stack, chain):
        chain.edit(('["joint1/position"]', '["ramp/x"]'), file="gentle.py")
        with pytest.raises(ReloadError, match="in a chain of controllers that command each other"):
            stack.reload_controller("gentle")
        stack.step()
        assert stack.command(COMMAND) == pytest.approx(0.055)


def test_a_reload_without_a_cycle_yet_can_be_withdrawn_for_another(stack, code, ramp):
    code.edit(("self.value += STEP", "self.value -= STEP"))
    first = ControllerReload(stack.manager, "ramp")
    first.prepare()
    first.commit()
    assert not first.is_settled.is_set()
    first.withdraw()
    with pytest.raises(ReloadError, match="reloaded again"):
        first.finish()
    assert controller(stack) is ramp
    code.edit(("self.value -= STEP", "self.value += 2 * STEP"))
    stack.reload_controller("ramp")
    assert stack.command(COMMAND) == pytest.approx(0.12)


def test_what_is_loaded_before_a_failed_first_update_stays_loaded(stack, code, ramp):
    code.edit(("self.value += STEP", "self.value /= 0"))
    reload = ControllerReload(stack.manager, "ramp")
    reload.prepare()
    reload.commit()
    parameters = {"interfaces": ["joint2/position"]}
    stack.load_controller("other", "passthrough_controller/PassthroughController", parameters)
    stack.activate("other")
    stack.step()
    with pytest.raises(ReloadError, match="ZeroDivisionError"):
        reload.finish()
    assert {spec.name for spec in stack.manager.active_controllers} == {"ramp", "other"}
    assert set(stack.manager.controllers) == {"ramp", "other"}
    assert "other/joint2/position" in stack.resources.command_interfaces
    assert ramp.command_interfaces


def test_a_controller_that_is_deactivated_before_its_first_update_is_the_new_one(stack, code, ramp):
    code.edit(("self.value += STEP", "self.value -= STEP"))
    reload = ControllerReload(stack.manager, "ramp")
    reload.prepare()
    reload.commit()
    stack.deactivate("ramp")
    stack.activate("ramp")
    stack.step()
    assert reload.finish() == "ramp"
    assert stack.command(COMMAND) == pytest.approx(-0.01)


def test_while_the_robot_is_stopped_the_new_code_is_stopped_as_well(stack, code, ramp):
    stack.manager.robot_stop.hold("operator")
    stack.step(50)
    before = stack.command(COMMAND)
    code.edit(("self.value += STEP", "self.value += 10 * STEP"))
    stack.reload_controller("ramp")
    stack.step(10)
    assert stack.command(COMMAND) == before


@pytest.mark.parametrize("lockstep", [True, False])
def test_an_asynchronous_controller_is_reloaded_too(code, lockstep):
    stack = ControlStack(serial_robot(joints=2, initial=(0.0, 0.0)))
    stack.resources.in_lockstep = lockstep
    old = stack.load_controller("ramp", "ramp:Ramp", {"is_async": True})
    stack.activate("ramp")

    def step(count):
        for _ in range(count):
            stack.step()
            update = stack.manager.controllers["ramp"].async_update
            assert update is not None
            assert update.wait_until_idle()

    try:
        step(11)
        assert stack.command(COMMAND) == pytest.approx(0.10)
        code.edit(("self.value += STEP", "self.value /= 0"))
        with pytest.raises(ReloadError, match="its first update raised ZeroDivisionError"):
            stack.reload_controller("ramp")
        assert controller(stack) is old
        step(2)
        assert stack.command(COMMAND) == pytest.approx(0.12)
        code.edit(("self.value /= 0", "self.value -= STEP"))
        stack.reload_controller("ramp")
        step(2)
        assert stack.command(COMMAND) == pytest.approx(0.11)
        assert controller(stack).lifecycle_state is State.ACTIVE
        stack.deactivate("ramp")
    finally:
        stack.manager.shutdown()
