"""The joint state broadcaster and the forward command controllers."""

import math

import pytest

from teleopctl.control.lifecycle import State
from teleopctl.control.switching import SwitchRequest, switch_controller
from teleopctl.interfaces.store import get_message
from teleopctl.testing import ControlStack, serial_robot

BROADCASTER = "joint_state_broadcaster/JointStateBroadcaster"
FORWARD = "forward_command_controller/ForwardCommandController"
MULTI = "forward_command_controller/MultiInterfaceForwardCommandController"
JOINTS = ["joint1", "joint2", "joint3"]
Float64MultiArray = get_message("std_msgs/msg/Float64MultiArray")


def up(stack, name, kind, **parameters):
    dotted = {name.replace("__", "."): value for name, value in parameters.items()}
    controller = stack.load_controller(name, kind, dotted)
    assert stack.manager.configure_controller(name)
    ok, message = switch_controller(stack.manager, SwitchRequest([name], []))
    assert ok, message
    return controller


class TestBroadcaster:
    def published(self, *, topic="joint_states", robot=None, **parameters):
        stack = ControlStack(robot or serial_robot())
        up(stack, "broadcaster", BROADCASTER, **parameters)
        stack.step()
        return stack, stack.nodes["broadcaster"].published(topic)[-1]

    def test_a_quantity_that_is_not_measured_is_nan(self):
        stack, message = self.published()
        assert list(message.name) == JOINTS
        assert list(message.position) == [1.1, 2.1, 3.1]
        assert all(map(math.isnan, [*message.velocity, *message.effort]))
        assert message.header.frame_id == "base_link"
        stamp = message.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == stack.time_ns

    def test_it_has_its_name_of_ros_2_foxy_too(self):
        stack = ControlStack(serial_robot())
        up(stack, "broadcaster", "joint_state_controller/JointStateController")
        stack.step()
        assert list(stack.nodes["broadcaster"].published("joint_states")[-1].name) == JOINTS

    def test_every_cycle_is_published_in_order(self):
        stack, _ = self.published()
        stack.step(5)
        messages = stack.nodes["broadcaster"].published("joint_states")
        stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]
        assert len(stamps) == 6
        assert stamps == sorted(stamps)

    def test_nothing_is_published_without_subscribers(self):
        stack, _ = self.published()
        node = stack.nodes["broadcaster"]
        for publisher in node.endpoints.values():
            publisher.has_subscribers = False
        stack.step(5)
        assert len(node.published("joint_states")) == 1
        assert len(node.published("dynamic_joint_states")) == 1

    def test_a_selection_needs_joints_and_interfaces(self):
        selected = {"joints": ["joint2"], "interfaces": ["position"]}
        _, message = self.published(**selected)
        assert list(message.name) == ["joint2"]
        _, message = self.published(joints=["joint2"])
        assert list(message.name) == JOINTS

    def test_extra_joints_stand_at_zero(self):
        _, message = self.published(extra_joints=["wheel"])
        assert list(message.name) == [*JOINTS, "wheel"]
        assert message.position[3] == message.velocity[3] == message.effort[3] == 0.0

    def test_another_interface_can_fill_a_field(self):
        robot = serial_robot(states=("position", "torque"))
        robot = robot.replace('"torque">', '"torque"><param name="initial_value">7</param>')
        _, message = self.published(robot=robot, map_interface_to_joint_state__effort="torque")
        assert list(message.effort) == [7.0, 7.0, 7.0]

    def test_local_topics(self):
        _, message = self.published(topic="~/joint_states", use_local_topics=True)
        assert list(message.name) == JOINTS

    def test_dynamic_joint_states_hold_every_interface(self):
        robot = serial_robot(2, states=("position", "velocity"))
        _, message = self.published(topic="dynamic_joint_states", robot=robot)
        assert list(message.joint_names) == ["joint1", "joint2"]
        first = message.interface_values[0]
        assert list(first.interface_names) == ["position", "velocity"]
        assert list(first.values) == [1.1, 0.0]

    def test_what_is_not_available_is_left_out(self):
        second = (
            '<ros2_control name="Other" type="sensor"><hardware>'
            "<plugin>mock_components/GenericSystem</plugin></hardware>"
            '<sensor name="scale"><state_interface name="force"/></sensor></ros2_control></robot>'
        )
        stack = ControlStack(serial_robot().replace("</robot>", second))
        other = stack.resources.components["Other"]
        other.change_state(State.UNCONFIGURED)
        controller = up(stack, "broadcaster", BROADCASTER)
        assert [state.prefix_name for state in controller.state_interfaces] == JOINTS
        assert switch_controller(stack.manager, SwitchRequest([], ["broadcaster"]))[0]
        other.change_state(State.ACTIVE)
        assert switch_controller(stack.manager, SwitchRequest(["broadcaster"], []))[0]
        assert [state.prefix_name for state in controller.state_interfaces] == [*JOINTS, "scale"]

    def test_without_any_state_it_cannot_be_activated(self):
        stack = ControlStack(serial_robot(states=()))
        stack.load_controller("broadcaster", BROADCASTER)
        assert stack.manager.configure_controller("broadcaster")
        assert not switch_controller(stack.manager, SwitchRequest(["broadcaster"], []))[0]


class TestForwardCommands:
    @pytest.fixture
    def stack(self):
        stack = ControlStack(serial_robot(), enforce_limits=False)
        for value, command in zip(
            (1.1, 2.1, 3.1), stack.resources.command_interfaces.values(), strict=True
        ):
            command.value = value
        up(stack, "forward", FORWARD, joints=JOINTS, interface_name="position")
        return stack

    def send(self, stack, *data):
        stack.nodes["forward"].receive("~/commands", Float64MultiArray(data=list(data)))

    def test_commands_are_written_at_once(self, stack):
        stack.step()
        assert stack.commands() == [1.1, 2.1, 3.1]
        self.send(stack, 10, 20, 30)
        stack.step()
        assert stack.commands() == [10, 20, 30]

    def test_a_wrong_length_stops_the_controller(self, stack):
        self.send(stack, 10, 20)
        stack.step()
        assert stack.commands() == [1.1, 2.1, 3.1]
        assert stack.manager.controllers["forward"].lifecycle_state is State.INACTIVE
        assert stack.nodes["forward"].log.texts("error") == [
            "command size (2) does not match number of interfaces (3): joint1/position, "
            "joint2/position, joint3/position"
        ]

    def test_infinity_is_dropped(self, stack):
        self.send(stack, 10, 20, math.inf)
        stack.step()
        assert stack.commands() == [1.1, 2.1, 3.1]
        assert stack.manager.controllers["forward"].lifecycle_state is State.ACTIVE

    def test_an_old_command_is_not_repeated_after_activation(self, stack):
        self.send(stack, 10, 20, 30)
        stack.step()
        switch_controller(stack.manager, SwitchRequest([], ["forward"]))
        for command in stack.resources.command_interfaces.values():
            command.value = 0.0
        switch_controller(stack.manager, SwitchRequest(["forward"], []))
        stack.step()
        assert stack.commands() == [0.0, 0.0, 0.0]

    @pytest.mark.parametrize(
        ("kind", "parameters"),
        [
            (FORWARD, {"interface_name": "position"}),
            (FORWARD, {"joints": JOINTS}),
            (MULTI, {"joint": "joint1"}),
            (MULTI, {"interface_names": ["position"]}),
        ],
    )
    def test_empty_names_cannot_be_configured(self, kind, parameters):
        stack = ControlStack(serial_robot())
        stack.load_controller("forward", kind, parameters)
        assert not stack.manager.configure_controller("forward")

    def test_group_controllers_stop_what_moves(self):
        stack = ControlStack(serial_robot(commands=("velocity",)))
        kind = "velocity_controllers/JointGroupVelocityController"
        up(stack, "forward", kind, joints=JOINTS)
        self.send(stack, 1, 2, 3)
        stack.step()
        assert stack.commands("velocity") == [1, 2, 3]
        switch_controller(stack.manager, SwitchRequest([], ["forward"]))
        assert stack.commands("velocity") == [0, 0, 0]


class TestCommandTimeout:
    def stack(self, interface, **parameters):
        stack = ControlStack(serial_robot(1, commands=("position", "velocity")))
        up(stack, "forward", FORWARD, joints=["joint1"], interface_name=interface, **parameters)
        return stack

    def test_a_velocity_that_is_not_sent_again_becomes_zero(self):
        stack = self.stack("velocity", cmd_timeout=0.1)
        node = stack.nodes["forward"]
        for _ in range(3):
            node.receive("~/commands", Float64MultiArray(data=[0.5]))
            stack.step(10)
            assert stack.command("joint1/velocity") == 0.5
        stack.step(2)
        assert stack.command("joint1/velocity") == 0.0
        stack.step(50)
        (warning,) = node.log.texts("warning")
        assert warning.startswith("No command on ~/commands for 0.1 s (cmd_timeout)")
        node.receive("~/commands", Float64MultiArray(data=[0.3]))
        stack.step()
        assert stack.command("joint1/velocity") == 0.3

    def test_a_position_is_held(self):
        stack = self.stack("position", cmd_timeout=0.1)
        stack.nodes["forward"].receive("~/commands", Float64MultiArray(data=[0.5]))
        stack.step(50)
        assert stack.command("joint1/position") == 0.5

    def test_by_default_a_command_is_valid_for_ever(self):
        stack = self.stack("velocity")
        stack.nodes["forward"].receive("~/commands", Float64MultiArray(data=[0.5]))
        stack.step(500)
        assert stack.command("joint1/velocity") == 0.5

    def test_a_negative_timeout_is_refused(self):
        stack = ControlStack(serial_robot(1))
        stack.load_controller(
            "forward",
            FORWARD,
            {"joints": ["joint1"], "interface_name": "position", "cmd_timeout": -1.0},
        )
        assert not stack.manager.configure_controller("forward")
        assert "'cmd_timeout' must be at least 0 s, got -1" in stack.nodes["forward"].log.texts()[0]
