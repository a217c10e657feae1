"""Controllers that command each other: what they export, in which order they run and switch."""

import math
from itertools import permutations

import pytest

from teleopctl.cli.verbs.control.controllers import controller_diagram
from teleopctl.control.lifecycle import State
from teleopctl.control.services import ControllerManagerServices, controller_state
from teleopctl.control.switching import Strictness, SwitchRequest, switch_controller
from teleopctl.interfaces import get_service
from teleopctl.node import Parameter
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import CHAINABLE, FAILURE, TYPE, failing
from tests.samples import sample

POSITION = "joint1/position"
REFERENCE = "follower/joint1/position"


@pytest.fixture
def stack():
    return ControlStack(serial_robot())


def load(stack, name, exports=(), commands=(), states=(), **parameters):
    """A configured controller, which is chainable where it exports something."""
    parameters |= {"commands": list(commands), "states": list(states)}
    if exports or parameters.get("sum"):
        parameters["exports"] = list(exports)
    controller = stack.load_controller(
        name, CHAINABLE if "exports" in parameters else TYPE, parameters
    )
    assert stack.manager.configure_controller(name), stack.log.texts("error")
    return controller


def chain(stack, **of_leader):
    """A follower of joint1 and a leader that commands it, whose references nobody commands."""
    follower = load(stack, "follower", ["joint1/position"], [POSITION])
    leader = load(stack, "leader", ["joint1/position"], [REFERENCE], **of_leader)
    return follower, leader


def do_switch(stack, activate=(), deactivate=(), strictness=Strictness.STRICT, **options):
    request = SwitchRequest(list(activate), list(deactivate), strictness, **options)
    return switch_controller(stack.manager, request)


def active(stack):
    return {
        name
        for name, spec in stack.manager.controllers.items()
        if spec.lifecycle_state is State.ACTIVE
    }


def shown(stack, name):
    return controller_state(stack.manager, stack.manager.controllers[name])


class TestExports:
    def test_references_exist_once_it_is_configured_and_are_available_while_it_is_active(
        self, stack
    ):
        follower = load(stack, "follower", ["joint1/position"], [POSITION], sum=True)
        reference = stack.resources.command_interfaces[REFERENCE]
        total = stack.resources.state_interfaces["follower/sum"]
        assert reference is follower.reference_interfaces[0]
        assert [reference.available, total.available] == [False, False]
        stack.activate("follower")
        assert [reference.available, total.available] == [True, True]
        assert not reference.claimed
        stack.deactivate("follower")
        assert [reference.available, total.available] == [False, False]
        assert math.isnan(total.value)
        assert stack.manager.cleanup_controller("follower")
        assert REFERENCE not in stack.resources.command_interfaces
        assert "follower/sum" not in stack.resources.state_interfaces

    def test_a_controller_that_is_unloaded_leaves_nothing(self, stack):
        load(stack, "follower", ["joint1/position"], [POSITION])
        stack.manager.unload_controller("follower")
        assert REFERENCE not in stack.resources.command_interfaces

    def test_configured_again_it_exports_what_it_does_now(self, stack):
        load(stack, "follower", ["joint1/position"], [POSITION])
        stack.nodes["follower"].set_parameters([Parameter("exports", value=["joint2/position"])])
        assert stack.manager.configure_controller("follower")
        assert "follower/joint2/position" in stack.resources.command_interfaces
        assert REFERENCE not in stack.resources.command_interfaces

    def test_the_list_tells_them_without_the_controllers_name(self, stack):
        chain(stack)
        follower, leader = shown(stack, "follower"), shown(stack, "leader")
        assert (follower.is_chainable, follower.is_chained) == (True, False)
        assert follower.reference_interfaces == ["joint1/position"]
        assert leader.required_command_interfaces == [REFERENCE]
        (connection,) = leader.chain_connections
        assert connection.name == "follower"
        assert connection.reference_interfaces == ["joint1/position"]
        stack.activate("follower", "leader")
        assert shown(stack, "follower").is_chained
        assert not shown(stack, "leader").is_chained
        assert shown(stack, "leader").claimed_interfaces == [REFERENCE]

    def test_a_connection_has_the_references_of_its_own_controller_alone(self, stack):
        load(stack, "left", ["joint1/position"], ["joint1/position"])
        load(stack, "right", ["joint2/position"], ["joint2/position"])
        load(stack, "base", [], ["left/joint1/position", "right/joint2/position"])
        connections = shown(stack, "base").chain_connections
        assert [(one.name, one.reference_interfaces) for one in connections] == [
            ("left", ["joint1/position"]),
            ("right", ["joint2/position"]),
        ]

    def test_types_that_can_be_chained_are_listed_as_such(self, stack):
        ControllerManagerServices(stack.node, stack.manager).offer_switching()
        kind = get_service("controller_manager_msgs/srv/ListControllerTypes")
        response = stack.node.call("~/list_controller_types", kind.Request(), kind.Response())
        classes = dict(zip(response.types, response.base_classes, strict=True))
        assert set(classes.values()) <= {
            "controller_interface::ControllerInterface",
            "controller_interface::ChainableControllerInterface",
        }
        name = "joint_trajectory_controller/JointTrajectoryController"
        assert classes[name] == "controller_interface::ControllerInterface"

    def test_the_picture_joins_what_one_commands_with_what_another_exports(self, stack):
        chain(stack)
        edges = {
            (edge.source, edge.target)
            for edge in controller_diagram(
                [shown(stack, name) for name in ("follower", "leader")]
            ).edges
        }
        assert ("controller leader", f"command {REFERENCE}") in edges
        assert (f"command {REFERENCE}", "controller follower") in edges
        assert ("controller follower", f"command {POSITION}") in edges

    @pytest.mark.parametrize(
        ("exports", "told"),
        [
            (["joint1/position"] * 2, "exports the reference interface 'follower/joint1/position'"),
            ([], "is chainable, but does not export any state or reference interfaces."),
        ],
    )
    def test_what_cannot_be_exported_is_told(self, stack, exports, told):
        stack.load_controller("follower", CHAINABLE, {"exports": exports})
        assert not stack.manager.configure_controller("follower")
        assert told in stack.log.texts("error")[0]
        assert stack.manager.controllers["follower"].lifecycle_state is State.UNCONFIGURED

    def test_a_name_of_another_is_refused(self, stack):
        controller = stack.load_controller("follower", CHAINABLE, {"exports": ["a/b"]})
        controller.name = "stranger"
        controller.on_export_reference_interfaces_list()
        controller.name = "follower"
        exported = list(controller.on_export_reference_interfaces_list())
        exported[0].prefix_name = "stranger/a"
        controller.on_export_reference_interfaces_list = lambda: exported
        assert not stack.manager.configure_controller("follower")
        assert "should begin with the controller's name 'follower'" in stack.log.texts("error")[0]

    def test_the_interface_of_a_joint_stays_the_joints(self, stack):
        stack.load_controller("joint1", CHAINABLE, {"exports": ["position"]})
        assert not stack.manager.configure_controller("joint1")
        assert f"'{POSITION}' is an interface of the hardware." in stack.log.texts("error")[0]
        assert stack.resources.component_of(POSITION) is not None
        stack.manager.unload_controller("joint1")
        assert POSITION in stack.resources.command_interfaces


class TestOrder:
    @pytest.mark.parametrize(
        "order", sample([*permutations(("low", "middle", "high", "other"))], 4)
    )
    def test_who_commands_is_updated_first_in_whatever_order_they_are_loaded(self, stack, order):
        wanted = {
            "low": (["joint1/position"], [POSITION]),
            "middle": (["joint1/position"], ["low/joint1/position"]),
            "high": (["joint1/position"], ["middle/joint1/position"]),
            "other": ([], ["joint2/position"]),
        }
        for name in order:
            load(stack, name, *wanted[name])
        ordered = [name for name in stack.manager.controllers if name != "other"]
        assert ordered == ["high", "middle", "low"]
        stack.activate("low", "middle", "high", "other")
        stack.manager.controllers["high"].controller.topic = 0.75
        stack.step()
        assert stack.command(POSITION) == 0.75  # through all of them in one cycle

    def test_without_chains_the_order_is_that_of_loading(self, stack):
        for name in ("c", "a", "b"):
            load(stack, name)
        assert list(stack.manager.controllers) == ["c", "a", "b"]

    def test_states_are_read_after_they_have_been_exported(self, stack):
        reader = load(stack, "reader", ["x"], [], ["source/sum"])
        source = load(stack, "source", ["a"], [], sum=True)
        assert list(stack.manager.controllers) == ["source", "reader"]
        stack.activate("source", "reader")
        source.topic = 3.0
        stack.step()
        assert reader.state_interfaces[0].value == 3.0

    def test_who_commands_and_reads_a_controller_comes_before_it(self, stack):
        load(stack, "wheel", ["joint1/position"], [POSITION], sum=True)
        load(stack, "base", ["x"], ["wheel/joint1/position"], ["wheel/sum"])
        assert list(stack.manager.controllers) == ["base", "wheel"]
        stack.activate("base", "wheel")
        assert active(stack) == {"base", "wheel"}

    @pytest.mark.parametrize("circle", [["a"], ["a", "b"], ["a", "b", "c"]])
    def test_a_circle_is_refused_when_it_is_closed(self, stack, circle):
        *others, last = circle
        for name, commanded in zip(others, circle[1:], strict=True):
            load(stack, name, ["x"], [f"{commanded}/x"])
        stack.load_controller(last, CHAINABLE, {"exports": ["x"], "commands": [f"{circle[0]}/x"]})
        assert not stack.manager.configure_controller(last)
        told = stack.log.texts("error")[0]
        assert "command each other in a cycle" in told
        assert all(f"'{name}'" in told for name in circle)
        assert stack.manager.controllers[last].lifecycle_state is State.UNCONFIGURED
        assert f"{last}/x" not in stack.resources.command_interfaces


class TestSwitching:
    def test_one_after_the_other_from_the_end_and_back(self, stack):
        follower, leader = chain(stack)
        stack.activate("follower")
        assert not follower.in_chained_mode
        follower.topic = 0.5
        stack.step()
        assert stack.command(POSITION) == 0.5
        stack.activate("leader")
        assert follower.in_chained_mode
        leader.topic = 1.5
        stack.step()
        assert stack.command(POSITION) == 1.5  # its own topic no longer counts
        assert stack.resources.command_interfaces[REFERENCE].owner == "leader"
        stack.deactivate("leader")
        assert active(stack) == {"follower"}
        assert not follower.in_chained_mode
        assert not stack.resources.command_interfaces[REFERENCE].claimed
        assert follower.calls.count("activate") == 3  # restarted for each change of mode
        stack.step()
        assert stack.command(POSITION) == 0.5

    @pytest.mark.parametrize("asap", [True, False])
    @pytest.mark.parametrize("names", [["follower", "leader"], ["leader", "follower"]])
    def test_all_at_once_in_any_order(self, stack, names, asap):
        follower, leader = chain(stack)
        assert do_switch(stack, names, activate_asap=asap)[0]
        assert follower.in_chained_mode
        leader.topic = 0.25
        stack.step()
        assert stack.command(POSITION) == 0.25
        assert do_switch(stack, [], names, activate_asap=asap)[0]
        assert active(stack) == set()
        assert not follower.in_chained_mode

    def test_who_commands_needs_the_follower(self, stack):
        chain(stack)
        told = (
            "The following controller with name 'follower' is currently inactive and it is not "
            "requested to be activated."
        )
        ok, message = do_switch(stack, ["leader"])
        assert (ok, message.splitlines()[0]) == (False, told)
        ok, message = do_switch(stack, ["leader"], strictness=Strictness.BEST_EFFORT)
        assert ok
        assert "no controllers need to be activated" in message
        assert told in stack.log.texts("warning")
        assert active(stack) == set()

    def test_a_follower_stays_as_long_as_it_is_commanded(self, stack):
        chain(stack)
        stack.activate("follower", "leader")
        told = (
            "Unable to deactivate controller with name 'follower' because preceding controller "
            "with name 'leader' is currently active and will not be deactivated."
        )
        ok, message = do_switch(stack, [], ["follower"])
        assert (ok, message.splitlines()[0]) == (False, told)
        assert active(stack) == {"follower", "leader"}

    def test_a_follower_cannot_go_while_another_is_to_command_it(self, stack):
        chain(stack)
        stack.activate("follower")
        ok, message = do_switch(stack, ["leader"], ["follower"])
        assert not ok
        assert message.splitlines()[0] == (
            "Unable to deactivate controller with name 'follower' because preceding controller "
            "with name 'leader' is inactive and will be activated."
        )
        ok, _ = do_switch(stack, ["leader"], ["follower"], Strictness.BEST_EFFORT)
        assert ok
        assert active(stack) == {"follower", "leader"}

    def test_best_effort_leaves_out_all_that_hangs_on_what_it_leaves_out(self, stack):
        chain(stack)
        stack.manager.cleanup_controller("follower")
        load(stack, "other", [], ["joint2/position"])
        ok, _ = do_switch(stack, ["leader", "follower", "other"], strictness=Strictness.BEST_EFFORT)
        assert ok
        assert active(stack) == {"other"}

    def test_one_that_is_no_longer_configured_is_in_no_chain(self, stack):
        chain(stack)
        stack.activate("follower")
        assert stack.manager.cleanup_controller("leader")
        assert not do_switch(stack, ["leader"], ["leader"])[0]
        assert not do_switch(stack, ["leader"])[0]
        assert shown(stack, "leader").required_command_interfaces == []
        assert stack.manager.chains.users(stack.manager.controllers["follower"]) == []

    def test_a_controller_that_exports_nothing_has_no_references(self, stack):
        load(stack, "plain", [], [POSITION])
        load(stack, "leader", [], ["plain/joint1/position"])
        ok, message = do_switch(stack, ["plain", "leader"])
        assert not ok
        assert message.splitlines()[0] == (
            "No state/reference interface from controller : 'plain/joint1/position' exist, since "
            "the following controller with name 'plain' is not chainable."
        )

    def test_a_reference_that_is_not_exported_is_not_available(self, stack):
        load(stack, "follower", ["joint1/position"], [POSITION])
        load(stack, "leader", [], ["follower/joint2/position"])
        ok, message = do_switch(stack, ["follower", "leader"])
        assert not ok
        assert message == (
            "Unable to activate controller 'leader' since the command interface "
            "'follower/joint2/position' is not available."
        )
        assert active(stack) == set()

    def test_a_reference_has_one_owner(self, stack):
        chain(stack)
        load(stack, "rival", [], [REFERENCE])
        ok, message = do_switch(stack, ["follower", "leader", "rival"])
        assert not ok
        assert f"the command interface '{REFERENCE}' will be used by another" in message
        stack.activate("follower", "leader")
        ok, message = do_switch(stack, ["rival"])
        assert not ok
        assert f"'{REFERENCE}' is currently claimed by another controller" in message
        assert do_switch(stack, ["rival"], ["leader"])[0]
        assert stack.resources.command_interfaces[REFERENCE].owner == "rival"
        assert stack.manager.controllers["follower"].controller.in_chained_mode

    def test_the_whole_chain_is_restarted_in_one_request(self, stack):
        follower, _ = chain(stack)
        stack.activate("follower", "leader")
        names = ["leader", "follower"]
        assert do_switch(stack, names, names)[0]
        assert active(stack) == {"follower", "leader"}
        assert follower.in_chained_mode

    def test_a_leader_that_is_restarted_leaves_its_follower_alone(self, stack):
        follower, leader = chain(stack)
        stack.activate("follower", "leader")
        assert do_switch(stack, ["leader"], ["leader"])[0]
        assert leader.calls.count("activate") == 2
        assert follower.calls.count("activate") == 1

    def test_a_leader_that_fails_to_start_commands_nobody(self, stack):
        follower, _ = chain(stack, failing=failing("activate", FAILURE))
        ok, message = do_switch(stack, ["follower", "leader"], strictness=Strictness.BEST_EFFORT)
        assert not ok
        assert "Unable to activate controllers: [ leader ]" in message
        assert active(stack) == {"follower"}
        assert not follower.in_chained_mode
        follower.topic = 0.5
        stack.step()
        assert stack.command(POSITION) == 0.5

    def test_a_follower_that_fails_to_start_has_nobody_to_command_it(self, stack):
        load(stack, "follower", ["x"], [POSITION], failing=failing("activate", FAILURE))
        load(stack, "leader", ["x"], ["follower/x"])
        ok, _ = do_switch(stack, ["follower", "leader"], strictness=Strictness.BEST_EFFORT)
        assert not ok
        assert active(stack) == set()
        assert not stack.resources.command_interfaces["follower/x"].available

    def test_a_controller_may_refuse_to_be_commanded(self, stack):
        load(stack, "follower", ["x"], [POSITION], loner=True)
        load(stack, "leader", ["x"], ["follower/x"])
        assert not do_switch(stack, ["follower", "leader"])[0]
        assert "refused to do it" in stack.log.texts("error")[0]
        assert do_switch(stack, ["follower"])[0]

    def test_who_reads_all_states_does_not_hold_their_exporters(self, stack):
        load(stack, "follower", ["x"], [POSITION], sum=True)
        stack.activate("follower")
        broadcaster = "joint_state_broadcaster/JointStateBroadcaster"
        stack.load_controller("broadcaster", broadcaster)
        stack.activate("broadcaster")
        assert "follower/sum" in shown(stack, "broadcaster").required_state_interfaces
        stack.deactivate("follower")
        stack.step()
        names = stack.nodes["broadcaster"].published("joint_states")[-1].name
        assert names == ["joint1", "joint2", "joint3"]

    @pytest.mark.parametrize("strictness", ["AUTO", "FORCE_AUTO"])
    def test_chains_are_not_completed_by_themselves(self, stack, strictness):
        chain(stack)
        ControllerManagerServices(stack.node, stack.manager).offer_switching()
        kind = get_service("controller_manager_msgs/srv/SwitchController")
        request = kind.Request(activate_controllers=["leader"])
        request.strictness = getattr(kind.Request, strictness)
        assert stack.node.call("~/switch_controller", request, kind.Response()).ok
        assert active(stack) == set()
        assert stack.log.texts("warning")[0] == (
            f"Controller Manager: {strictness} is not currently implemented. Defaulting to "
            "BEST_EFFORT"
        )


class TestFailures:
    @pytest.mark.parametrize("culprit", ["follower", "leader"])
    def test_a_member_that_fails_takes_its_chain_with_it_and_no_other(self, stack, culprit):
        parameters = {"failing": failing("update", FAILURE).copy()}
        parameters["failing"][1] = "ERROR"
        load(stack, "follower", ["x"], [POSITION], **(parameters if culprit == "follower" else {}))
        load(stack, "leader", ["x"], ["follower/x"], **(parameters if culprit == "leader" else {}))
        load(stack, "other", [], ["joint2/position"])
        stack.activate("follower", "leader", "other")
        stack.step()
        assert active(stack) == {"other"}
        assert not stack.resources.command_interfaces[POSITION].claimed

    def test_a_fallback_takes_over_from_a_chain(self, stack):
        load(stack, "follower", ["x"], [POSITION])
        load(stack, "rescue", [], [POSITION])
        stack.node.declare_parameter("leader.fallback_controllers", ["rescue"])
        load(stack, "leader", ["x"], ["follower/x"], failing=["update", "ERROR"])
        stack.activate("follower", "leader")
        stack.step()
        assert active(stack) == {"rescue"}

    def test_a_fallback_may_command_references(self, stack):
        follower = load(stack, "follower", ["x"], ["joint1/position"])
        load(stack, "rescue", ["x"], ["follower/x"])
        stack.node.declare_parameter("single.fallback_controllers", ["rescue"])
        load(stack, "single", [], ["joint2/position"], failing=["update", "ERROR"])
        stack.activate("follower", "single")
        stack.step()
        assert active(stack) == {"follower", "rescue"}
        assert follower.in_chained_mode

    def test_hardware_that_goes_takes_the_whole_chain(self, stack):
        chain(stack)
        stack.activate("follower", "leader")
        ControllerManagerServices(stack.node, stack.manager).offer_switching()
        kind = get_service("controller_manager_msgs/srv/SetHardwareComponentState")
        request = kind.Request(name=next(iter(stack.resources.components)))
        request.target_state.label = "inactive"
        assert stack.node.call("~/set_hardware_component_state", request, kind.Response()).ok
        assert active(stack) == set()
