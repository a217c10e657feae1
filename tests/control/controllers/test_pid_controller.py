"""The PID controller: what it commands, exports, hears and refuses; figures of ROS 2's own tests.

One joint stands at 1.1 and is read before each update; updates come at 100 Hz.
"""

import math

import pytest

from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.lifecycle import State
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Parameter
from teleopctl.testing import ControlStack, serial_robot

TYPE = "pid_controller/PidController"
FORWARD = "forward_command_controller/ForwardCommandController"
NAN = math.nan
Command = get_message("control_msgs/msg/MultiDOFCommand")


class Pid:
    """A PID controller of ``joint1``, and of ``joint2`` where there are two joints."""

    def __init__(
        self,
        *,
        joints=1,
        states=("position",),
        command="position",
        activate=True,
        options=None,
        **gains,
    ):
        robot = serial_robot(
            joints,
            initial=(1.1, -0.5),
            commands=("position", "velocity", "effort"),
            states=("position", "velocity"),
        )
        self.stack = ControlStack(robot, enforce_limits=False)
        self.names = [f"joint{number + 1}" for number in range(joints)]
        self.command = f"joint1/{command}"
        parameters = {
            "dof_names": self.names,
            "command_interface": command,
            "reference_and_state_interfaces": list(states),
            **{f"gains.{name}.{key}": gains[key] for name in self.names for key in gains},
            **(options or {}),
        }
        controller = self.stack.load_controller("pid", TYPE, parameters)
        assert isinstance(controller, ChainableControllerInterface)
        self.controller = controller
        self.node = self.stack.nodes["pid"]
        if activate:
            self.stack.activate("pid")

    def refer(self, *values, names=None, rates=()):
        names = self.names if names is None else names
        self.node.receive(
            "~/reference", Command(dof_names=names, values=values, values_dot=list(rates))
        )

    def step(self, *values, **options):
        """One update, with new references, and what it commands of joint1."""
        if values:
            self.refer(*values, **options)
        self.stack.step()
        return self.stack.command(self.command)

    @property
    def references(self):
        return [reference.value for reference in self.controller.reference_interfaces]

    @property
    def state(self):
        return self.node.published("~/controller_state")[-1]


FIRST, EXTERNAL, STATES = (
    "set_current_state_as_first_setpoint",
    "use_external_measured_states",
    "reference_and_state_dof_names",
)
GAINS = {"p": 1.0, "i": 2.0, "d": 3.0, "antiwindup_strategy": "none"}


class TestUpdate:
    def test_the_error_its_integral_and_its_rate_are_weighed(self):
        # 100.001 + 0 + 3 · 100.001 / 0.01: the integral counts from the next step on.
        assert Pid(**GAINS).step(101.101) == pytest.approx(30100.301)

    def test_with_the_legacy_strategy_the_integral_counts_at_once(self):
        pid = Pid(**GAINS | {"antiwindup_strategy": "legacy"})
        assert pid.step(101.101) == pytest.approx(30102.30102)

    def test_the_output_is_clamped(self):
        assert Pid(**GAINS, u_clamp_max=5.0, u_clamp_min=-5.0).step(101.101) == 5.0
        assert Pid(**GAINS, u_clamp_max=5.0, u_clamp_min=-5.0).step(-101.101) == -5.0

    @pytest.mark.parametrize(("wraps", "expected"), [(False, 2678.9), (True, 787.6612219)])
    def test_angles_go_the_short_way_where_they_wrap(self, wraps, expected):
        assert Pid(**GAINS, angle_wraparound=wraps).step(10.0) == pytest.approx(expected)

    @pytest.mark.parametrize(("ahead", "expected"), [(True, 6.95), (False, 1.95)])
    def test_feed_forward_adds_the_reference(self, ahead, expected):
        pid = Pid(p=0.5, feedforward_gain=1.0, options={"enable_feedforward": ahead})
        assert pid.step(5.0) == pytest.approx(expected)

    def test_with_two_interfaces_rates_are_those_that_are_measured(self):
        pid = Pid(states=["position", "velocity"], command="velocity", p=0.5, d=0.4)
        assert pid.step(5.0, rates=[2.0]) == pytest.approx(0.5 * 3.9 + 0.4 * 2.0)

    def test_with_two_interfaces_feed_forward_adds_the_rate(self):
        pid = Pid(
            states=["position", "velocity"],
            command="velocity",
            p=0.5,
            feedforward_gain=2.0,
            options={"enable_feedforward": True},
        )
        assert pid.step(5.0, rates=[3.0]) == pytest.approx(0.5 * 3.9 + 2.0 * 3.0)

    def test_it_brings_a_joint_to_its_reference(self):
        robot = serial_robot(
            1,
            initial=(0.0,),
            commands=("velocity",),
            states=("position", "velocity"),
            parameters='<param name="calculate_dynamics">true</param>',
        )
        stack = ControlStack(robot, enforce_limits=False)
        stack.load_controller(
            "pid",
            TYPE,
            {
                "dof_names": ["joint1"],
                "command_interface": "velocity",
                "reference_and_state_interfaces": ["position"],
                "gains.joint1.p": 5.0,
            },
        )
        stack.activate("pid")
        stack.nodes["pid"].receive("~/reference", Command(dof_names=["joint1"], values=[0.7]))
        stack.step(300)
        assert stack.state("joint1/position") == pytest.approx(0.7, abs=1e-4)

    @pytest.mark.parametrize("what", ["reference", "state"])
    def test_nothing_is_commanded_while_something_is_not_known(self, what):
        pid = Pid(**GAINS, options={FIRST: what == "state"})
        if what == "state":
            pid.stack.resources.state_interfaces["joint1/position"].value = NAN
            pid.controller.update(pid.stack.time_ns, 0.01)
            assert math.isnan(pid.stack.command("joint1/position"))
        else:
            assert math.isnan(pid.step())


class TestStart:
    def test_its_first_reference_is_where_it_is(self):
        pid = Pid(**GAINS, states=["position", "velocity"])
        assert pid.references == [1.1, 0.0]
        assert pid.step() == pytest.approx(0.0)

    def test_or_none_where_that_is_not_wanted(self):
        assert math.isnan(Pid(**GAINS, options={FIRST: False}).references[0])

    @pytest.mark.parametrize(("kept", "expected"), [(True, 2.00002), (False, 0.0)])
    def test_the_integral_outlasts_a_deactivation_where_it_is_saved(self, kept, expected):
        pid = Pid(**GAINS, save_i_term=kept)
        pid.step(101.101)
        pid.stack.deactivate("pid")
        pid.stack.resources.command_interfaces["joint1/position"].value = 1.1
        pid.stack.step()
        pid.stack.activate("pid")
        assert pid.step() == pytest.approx(expected)

    def test_a_robot_that_is_put_elsewhere_is_held_there(self):
        pid = Pid(**GAINS)
        pid.step(101.101)
        pid.stack.resources.state_interfaces["joint1/position"].value = 4.0
        pid.controller.on_restart()
        assert pid.references == [4.0]

    @pytest.mark.parametrize(("command", "left"), [("position", 5.0), ("velocity", 0.0)])
    def test_what_would_go_on_is_stopped_at_the_end(self, command, left):
        pid = Pid(command=command, **GAINS, u_clamp_max=5.0)
        pid.step(101.101)
        pid.stack.deactivate("pid")
        assert pid.stack.command(f"joint1/{command}") == left


class TestReferences:
    def test_two_degrees_of_freedom_are_told_apart_by_name(self):
        pid = Pid(joints=2, p=1.0)
        pid.step(2.0, 3.0, names=["joint2", "joint1"])
        assert pid.references == [3.0, 2.0]

    def test_without_names_the_order_counts(self):
        pid = Pid(joints=2, p=1.0)
        pid.step(2.0, 3.0, names=[])
        assert pid.references == [2.0, 3.0]
        assert "does not have DoF names defined" in pid.node.log.texts("warning")[-1]

    def test_what_is_not_a_number_stays(self):
        pid = Pid(joints=2, p=1.0)
        pid.step(NAN, 3.0)
        assert pid.references == [1.1, 3.0]

    @pytest.mark.parametrize(
        ("values", "names", "told"),
        [
            ([2.0], ["joint1"], "Size of input data names (1) and/or values (1) is not matching"),
            ([2.0], ["joint1", "joint2"], "names (2) and/or values (1) is not matching the exp"),
            ([2.0, 3.0], ["joint1", "other"], "DoF name 'other' not found in the defined list"),
            ([2.0, 3.0], ["joint1", "joint1"], "A DoF name is given twice: joint1, joint1"),
        ],
    )
    def test_a_message_that_does_not_fit_is_told_and_dropped(self, values, names, told):
        pid = Pid(joints=2, p=1.0)
        pid.step(*values, names=names)
        assert pid.references == [1.1, -0.5]
        assert told in pid.node.log.texts()[-1]

    def test_another_controller_commands_it(self):
        pid = Pid(activate=False, command="effort", **GAINS)
        stack = pid.stack
        options = {"joints": ["pid/joint1"], "interface_name": "position"}
        stack.load_controller("forward", FORWARD, options)
        assert stack.manager.configure_controller("forward")
        stack.activate("pid", "forward")
        pid.refer(77.0)  # its topic is not heard
        Floats = get_message("std_msgs/msg/Float64MultiArray")  # noqa: N806 - a class
        stack.nodes["forward"].receive("~/commands", Floats(data=[5.0]))
        stack.step()
        assert stack.command("joint1/effort") == pytest.approx(1173.9)
        assert pid.references == [5.0]

    def test_it_exports_references_and_states_of_the_same_names(self):
        pid = Pid(joints=2, states=["position", "velocity"], p=1.0)
        names = [
            f"pid/joint{joint}/{kind}" for kind in ("position", "velocity") for joint in (1, 2)
        ]
        assert [one.name for one in pid.controller.reference_interfaces] == names
        assert [one.name for one in pid.controller.exported_state_interfaces] == names
        pid.stack.step()
        assert pid.stack.state("pid/joint2/position") == -0.5

    def test_states_may_have_other_names_than_commands(self):
        pid = Pid(options={STATES: ["joint2"]}, joints=2, activate=False, p=1.0)
        assert not pid.stack.manager.configure_controller("pid")
        assert pid.node.log.texts("error") == [
            "Size of 'dof_names' (2) and 'reference_and_state_dof_names' (1) parameters has to be "
            "the same!"
        ]
        names = ["joint2", "joint1"]
        pid = Pid(options={STATES: names}, joints=2, p=1.0)
        assert pid.references == [-0.5, 1.1]
        assert pid.step(0.5, 1.1, names=names) == pytest.approx(1.0)

    def test_measured_values_may_come_from_a_topic(self):
        pid = Pid(options={EXTERNAL: True}, **GAINS)
        assert pid.stack.manager.controllers["pid"].required_state_interfaces == ()
        assert math.isnan(pid.step(5.0))
        pid.node.receive("~/measured_state", Command(dof_names=["joint1"], values=[1.1]))
        assert pid.step() == pytest.approx(1173.9)

    @pytest.mark.parametrize(
        ("message", "told"),
        [
            (Command(values=[1.0]), "Size of input data names (0) is not matching"),
            (Command(dof_names=["joint1"]), "Size of input data values (0) is not matching"),
            (
                Command(dof_names=["joint1"], values=[1.0], values_dot=[1.0]),
                "has to have two interfaces",
            ),
        ],
    )
    def test_measured_values_that_do_not_fit_are_told(self, message, told):
        pid = Pid(options={EXTERNAL: True}, **GAINS)
        pid.node.receive("~/measured_state", message)
        assert told in pid.node.log.texts("error")[-1]


class TestState:
    def test_each_step_is_published(self):
        pid = Pid(states=["position", "velocity"], command="velocity", p=0.5, d=0.4)
        output = pid.step(5.0, rates=[2.0])
        (state,) = pid.state.dof_states
        assert state.name == "joint1"
        assert (state.reference, state.feedback, state.error) == pytest.approx((5.0, 1.1, 3.9))
        assert (state.feedback_dot, state.error_dot, state.time_step) == (0.0, 2.0, 0.01)
        assert state.output == output

    def test_a_degree_of_freedom_may_have_a_topic_of_its_own(self):
        pid = Pid(**GAINS, activate_state_publisher=True, i_clamp_max=7.0)
        output = pid.step(5.0)
        state = pid.node.published("~/joint1/pid_state")[-1]
        assert (state.p_term, state.i_term, state.d_term, state.i_max) == (1.0, 2.0, 3.0, 7.0)
        assert (state.error, state.error_dot, state.output) == pytest.approx((3.9, 390.0, output))
        assert state.i_error == pytest.approx(2.0 * 3.9 * 0.01)
        assert "~/joint1/pid_state" not in Pid(**GAINS).node.endpoints


class TestParameters:
    @pytest.mark.parametrize(
        ("parameters", "told"),
        [
            ({"dof_names": []}, "Parameter 'dof_names' cannot be empty"),
            ({"command_interface": ""}, "Parameter 'command_interface' cannot be empty"),
            (
                {"reference_and_state_interfaces": []},
                "Parameter 'reference_and_state_interfaces' cannot be empty",
            ),
            (
                {"reference_and_state_interfaces": ["a", "b", "c"]},
                "Length of parameter 'reference_and_state_interfaces' is 3 but must be less than 3",
            ),
            ({"dof_names": ["a", "a"]}, "Value of parameter 'dof_names' must be unique"),
            (
                {"gains.joint1.antiwindup_strategy": "magic"},
                "Parameter 'gains.joint1.antiwindup_strategy' with the value 'magic' is not in the",
            ),
            (
                {"gains.joint1.u_clamp_max": -1.0, "gains.joint1.u_clamp_min": 1.0},
                "Gains of 'joint1': Gains: u_min (1) must be less than u_max (-1)",
            ),
            (
                {"gains.joint1.i_clamp_min": 1.0},
                "PID requires i_min to be smaller or equal to 0 (i_min: 1)",
            ),
            (
                {"gains.joint1.i_clamp_max": -1.0},
                "PID requires i_max to be greater or equal to 0 (i_max: -1)",
            ),
            ({"gains.joint1.p": NAN}, "Gain 'p' is nan: it must be finite"),
            (
                {
                    "gains.joint1.antiwindup_strategy": "back_calculation",
                    "gains.joint1.i": 1.0,
                    "gains.joint1.tracking_time_constant": -1.0,
                },
                "'back_calculation' requires a valid positive tracking time constant",
            ),
        ],
    )
    def test_what_cannot_be_is_told_when_it_is_configured(self, parameters, told):
        stack = ControlStack(serial_robot(1))
        defaults = {
            "dof_names": ["joint1"],
            "command_interface": "position",
            "reference_and_state_interfaces": ["position"],
        }
        stack.load_controller("pid", TYPE, defaults | parameters)
        assert not stack.manager.configure_controller("pid")
        assert stack.manager.controllers["pid"].lifecycle_state is State.UNCONFIGURED
        assert told in stack.nodes["pid"].log.texts("error")[0]

    def test_gains_can_be_changed_while_it_runs_and_wrong_ones_are_left_out(self):
        pid = Pid(p=1.0)
        pid.node.set_parameters([Parameter("gains.joint1.p", value=2.0)])
        assert pid.step(5.0) == pytest.approx(7.8)
        pid.node.set_parameters([Parameter("gains.joint1.u_clamp_max", value=-math.inf)])
        assert "Skipping new gains." in pid.node.log.texts("error")[-1]
        pid.node.set_parameters([Parameter("gains.joint1.u_clamp_max", value="much")])
        assert "must be a number" in pid.node.log.texts("error")[-1]
        pid.stack.resources.state_interfaces["joint1/position"].value = 1.1
        assert pid.controller.update(pid.stack.time_ns, 0.01) is None
        assert pid.stack.command("joint1/position") == pytest.approx(7.8)

    def test_feed_forward_is_switched_by_parameter_and_by_service(self):
        pid = Pid(feedforward_gain=1.0)
        kind = get_service("std_srvs/srv/SetBool")
        service = "~/set_feedforward_control"
        assert pid.step(5.0) == 0.0
        assert pid.node.call(service, kind.Request(data=True), kind.Response()).success
        assert pid.step() == 5.0
        pid.node.set_parameters([Parameter("enable_feedforward", value=False)])
        assert pid.step() == 0.0
        pid.node.set_parameters([Parameter("enable_feedforward", value=True)])
        assert pid.step() == 5.0

    def test_every_parameter_of_ros_2_means_something(self):
        pid = Pid(**GAINS, antiwindup=True, feedforward_gain=0.95, error_deadband=0.1)
        assert not [text for text in pid.node.log.texts("warning") if "no effect" in text]


def test_reloaded_code_keeps_reference_and_integral():
    reloaded, other = (
        Pid(command="effort", p=2.0, i=5.0, antiwindup_strategy="none") for _ in "ab"
    )
    for pid in (reloaded, other):
        pid.step(2.0)
        pid.stack.step(30)
    reloaded.stack.reload_controller("pid")
    other.stack.step()
    assert reloaded.stack.command("joint1/effort") == other.stack.command("joint1/effort")
    assert other.stack.command("joint1/effort") > 2.0 * 0.9
    reloaded.stack.step(5)
    other.stack.step(5)
    assert reloaded.stack.command("joint1/effort") == other.stack.command("joint1/effort")
