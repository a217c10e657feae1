"""Hardware behind topics: one cycle and one answer for every state, with its stamp."""

import math

import pytest

from teleopctl.control.lifecycle import State
from teleopctl.control.switching import SwitchRequest, switch_controller
from teleopctl.interfaces import get_action
from teleopctl.interfaces.store import get_message
from teleopctl.node import GoalState
from teleopctl.robot import RESET_FRAME
from teleopctl.testing import ControlStack, serial_robot

PLUGIN = "gazebo_ros2_control/GazeboSystem"
FORWARD = "forward_command_controller/ForwardCommandController"
JTC = "joint_trajectory_controller/JointTrajectoryController"
INTERFACES = {"command_interfaces": ["position"], "state_interfaces": ["position"]}
BROADCASTER = "joint_state_broadcaster/JointStateBroadcaster"
JOINTS = ["joint1", "joint2", "joint3"]
PERIOD_NS = 10_000_000
JointState = get_message("sensor_msgs/msg/JointState")
Time = get_message("builtin_interfaces/msg/Time")
Float64MultiArray = get_message("std_msgs/msg/Float64MultiArray")


class Simulator(ControlStack):
    """The other side of the topics."""

    def __init__(self, **options):
        super().__init__(serial_robot(plugin=PLUGIN, **options))
        (component,) = self.resources.components.values()
        self.hardware = component.hardware
        self.hardware.set_cycle(self.cycle.run)

    def tick(self, time_ns, positions, names=tuple(JOINTS), frame=""):
        sec, nanosec = divmod(time_ns, 10**9)
        message = JointState(name=list(names), position=[float(value) for value in positions])
        message.header.stamp = Time(sec=sec, nanosec=nanosec)
        message.header.frame_id = frame
        self.node.receive("/robot_joint_states", message)
        return self.answers[-1]

    def measure(self, positions, tick, frame=""):
        """A state with velocities of zero."""
        message = JointState(name=JOINTS, position=list(map(float, positions)), velocity=[0.0] * 3)
        message.header.stamp = Time(sec=tick // 100, nanosec=tick % 100 * PERIOD_NS)
        message.header.frame_id = frame
        self.node.receive("/robot_joint_states", message)
        return self.answers[-1]

    @property
    def answers(self):
        return self.node.published("/robot_joint_commands")


@pytest.fixture
def simulator():
    return Simulator()


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def test_every_state_is_answered_with_its_stamp_also_without_controllers(simulator):
    assert simulator.hardware.drives_cycle
    for tick in range(1, 4):
        answer = simulator.tick(tick * PERIOD_NS, [0, 0, 0])
        assert stamp_ns(answer) == tick * PERIOD_NS
        assert list(answer.name) == []
    assert len(simulator.answers) == 3


def test_states_are_found_by_name(simulator):
    simulator.tick(PERIOD_NS, [3, 9, 1, 2], ["joint3", "other", "joint1", "joint2"])
    values = [state.value for state in simulator.resources.state_interfaces.values()]
    assert values == [1, 2, 3]


def test_values_of_sensors_come_under_the_full_names_of_their_interfaces():
    names = ("force.x", "torque.z")
    states = "".join(f'<state_interface name="{name}"/>' for name in names)
    simulator = Simulator(joints=1, extra_control=f'<sensor name="wrist">{states}</sensor>')
    simulator.tick(PERIOD_NS, [1, 2, 3], ["joint1", "wrist/torque.z", "wrist/force.x"])
    assert [simulator.state(f"wrist/{name}") for name in names] == [3.0, 2.0]
    assert simulator.log.texts("warning") == []
    simulator.tick(2 * PERIOD_NS, [1], ["joint1"])
    (warning,) = simulator.log.texts("warning")
    assert warning == "No state on /robot_joint_states for: wrist"


def test_commands_go_out_with_the_state_that_they_answer(simulator):
    simulator.load_controller(
        "forward", FORWARD, {"joints": ["joint1", "joint3"], "interface_name": "position"}
    )
    assert simulator.manager.configure_controller("forward")
    assert switch_controller(simulator.manager, SwitchRequest(["forward"], []))[0]
    message = Float64MultiArray(data=[0.5, 0.7])
    simulator.nodes["forward"].receive("~/commands", message)
    answer = simulator.tick(PERIOD_NS, [0, 0, 0])
    assert list(answer.name) == JOINTS
    assert list(answer.position)[::2] == [0.5, 0.7]
    assert math.isnan(answer.position[1])
    assert list(answer.velocity) == list(answer.effort) == []


def test_a_switch_works_while_no_state_arrives(simulator):
    simulator.tick(PERIOD_NS, [0, 0, 0])
    simulator.load_controller("forward", FORWARD, {"joints": JOINTS, "interface_name": "position"})
    assert simulator.manager.configure_controller("forward")
    assert switch_controller(simulator.manager, SwitchRequest(["forward"], []))[0]
    assert simulator.resources.command_interfaces["joint1/position"].owner == "forward"


def test_joint_states_carry_the_stamp_of_the_state(simulator):
    simulator.load_controller("broadcaster", BROADCASTER)
    assert simulator.manager.configure_controller("broadcaster")
    assert switch_controller(simulator.manager, SwitchRequest(["broadcaster"], []))[0]
    for tick in range(1, 4):
        simulator.tick(tick * PERIOD_NS, [tick, 0, 0])
    published = simulator.nodes["broadcaster"].published("joint_states")
    assert [stamp_ns(message) for message in published] == [
        PERIOD_NS,
        2 * PERIOD_NS,
        3 * PERIOD_NS,
    ]
    assert [message.position[0] for message in published] == [1, 2, 3]


def test_topics_can_be_named():
    parameters = (
        '<param name="joint_states_topic">/s</param><param name="joint_commands_topic">/c</param>'
    )
    stack = Simulator(parameters=parameters)
    assert {"/s", "/c"} <= set(stack.node.endpoints)


def test_without_lockstep_the_latest_state_counts():
    stack = Simulator(parameters='<param name="lockstep">false</param>')
    assert not stack.hardware.drives_cycle
    message = JointState(name=JOINTS, position=[1.0, 2.0, 3.0])
    stack.node.receive("/robot_joint_states", message)
    assert stack.answers == []
    stack.step()
    assert [state.value for state in stack.resources.state_interfaces.values()] == [1, 2, 3]
    assert len(stack.answers) == 1


def forward(simulator, name, interface, value):
    """Command one interface of joint1 and no other."""
    active = [spec.name for spec in simulator.manager.active_controllers]
    simulator.load_controller(name, FORWARD, {"joints": ["joint1"], "interface_name": interface})
    assert simulator.manager.configure_controller(name)
    ok, message = switch_controller(simulator.manager, SwitchRequest([name], active))
    assert ok, message
    simulator.nodes[name].receive("~/commands", Float64MultiArray(data=[value]))


def of_joint1(answer):
    """The commands of joint1 that are there, by interface."""
    fields = {name: getattr(answer, name) for name in ("position", "velocity", "effort")}
    return {name: v[0] for name, v in fields.items() if len(v) and not math.isnan(v[0])}


def test_a_joint_is_commanded_in_one_way_at_a_time():
    simulator = Simulator(commands=("position", "velocity", "effort"))
    tick = iter(range(1, 100))

    def answer():
        return of_joint1(simulator.tick(next(tick) * PERIOD_NS, [0, 0, 0]))

    forward(simulator, "by_position", "position", 0.001)
    assert answer() == {"position": 0.001}
    forward(simulator, "by_velocity", "velocity", 0.5)
    assert answer() == {"velocity": 0.5}
    forward(simulator, "by_effort", "effort", 2.0)
    assert answer() == {"effort": 2.0}
    assert switch_controller(simulator.manager, SwitchRequest([], ["by_effort"]))[0]
    # Nobody commands any joint: that is said by naming none.
    assert list(simulator.tick(next(tick) * PERIOD_NS, [0, 0, 0]).name) == []
    # Another joint is commanded: the old position must not come back.
    simulator.load_controller(
        "other", FORWARD, {"joints": ["joint2"], "interface_name": "position"}
    )
    assert simulator.manager.configure_controller("other")
    assert switch_controller(simulator.manager, SwitchRequest(["other"], []))[0]
    assert answer() == {"effort": 2.0}


def test_a_joint_is_not_commanded_in_two_ways_by_two_controllers():
    simulator = Simulator(commands=("position", "velocity"))
    both = {"joint": "joint1", "interface_names": ["position", "velocity"]}
    for name, kind, parameters in (
        ("by_position", FORWARD, {"joints": ["joint1"], "interface_name": "position"}),
        ("by_velocity", FORWARD, {"joints": ["joint1"], "interface_name": "velocity"}),
        ("by_both", "forward_command_controller/MultiInterfaceForwardCommandController", both),
    ):
        simulator.load_controller(name, kind, parameters)
        assert simulator.manager.configure_controller(name)

    def switch(start, stop=()):
        return switch_controller(simulator.manager, SwitchRequest([start], stop))[0]

    assert switch("by_position")
    assert not switch("by_velocity")
    assert [spec.name for spec in simulator.manager.active_controllers] == ["by_position"]
    assert switch("by_velocity", ["by_position"])
    assert switch("by_both", ["by_velocity"]), "one controller may have both"


def test_a_position_counts_as_known_only_once_it_was_measured():
    simulator = Simulator(initial=(1.1, 2.1, 3.1))
    states = simulator.resources.state_interfaces.values()
    assert all(math.isnan(state.value) for state in states)
    simulator.tick(PERIOD_NS, [1, 2, 3])
    component = simulator.resources.components["Hardware"]
    for target in (State.UNCONFIGURED, State.ACTIVE):
        assert component.change_state(target)
    simulator.step()
    assert all(math.isnan(state.value) for state in states)


@pytest.fixture
def arm():
    """A trajectory controller that has commanded the joints to stay at 5 rad."""
    arm = Simulator(limits='lower="-9" upper="9" effort="10" velocity="1"')
    arm.load_controller("arm", JTC, {"joints": JOINTS, **INTERFACES})
    assert arm.manager.configure_controller("arm")
    assert switch_controller(arm.manager, SwitchRequest(["arm"], []))[0]
    for tick in range(1, 4):
        answer = arm.tick(tick * PERIOD_NS, [5, 5, 5])
    assert list(answer.position) == [5, 5, 5]
    return arm


def test_after_a_simulation_has_begun_again_commands_start_where_the_joints_are(arm):
    for tick in range(3):
        assert list(arm.tick(tick * PERIOD_NS, [0, 0, 0]).position) == [0, 0, 0]


GRIPPER = "position_controllers/GripperActionController"


@pytest.mark.parametrize("time_goes_on", [True, False])
def test_a_reset_voids_what_controllers_were_to_do(time_goes_on):
    states = {"states": ("position", "velocity")}
    arm = Simulator(limits='lower="-9" upper="9" effort="10" velocity="9"', **states)
    one = {"joints": ["joint1"], **INTERFACES}
    arm.load_controller("path", JTC, one)
    arm.load_controller("forward", FORWARD, {"joints": ["joint2"], "interface_name": "position"})
    arm.load_controller("gripper", GRIPPER, {"joint": "joint3"})
    for name in ("path", "forward", "gripper"):
        arm.activate(name)
    arm.measure([0, 0, 0], 0)
    arm.nodes["path"].receive("~/commands", Float64MultiArray(data=[5.0]))
    arm.nodes["forward"].receive("~/commands", Float64MultiArray(data=[5.0]))
    grip = get_action("control_msgs/action/GripperCommand").Goal()
    grip.command.position = 5.0
    handle = arm.action_servers["gripper/gripper_cmd"].send_goal(grip)
    assert handle is not None
    for tick in range(1, 200):
        answer = arm.measure([5, 5, 4], tick)
    assert list(answer.position) == pytest.approx([5, 5, 5])

    first = 200 if time_goes_on else 0
    for tick in range(first, first + 3):
        reset = time_goes_on and tick == first
        position = list(arm.measure([1, 2, 3], tick, RESET_FRAME if reset else "").position)
        assert [position[0], position[2]] == [1, 3]
        assert math.isnan(position[1]), "the joint stays where it is"
    assert handle.status == GoalState.ABORTED
    arm.nodes["forward"].receive("~/commands", Float64MultiArray(data=[4.0]))
    assert arm.measure([1, 2, 3], first + 3).position[1] > 2, "the next command counts"


def test_a_controller_that_fails_at_a_reset_does_not_keep_it_from_the_others(arm, monkeypatch):
    arm.load_controller("other", "tests.control.fakes:Recorder", {})
    arm.activate("other")
    monkeypatch.setattr(arm.manager.controllers["other"].controller, "on_restart", lambda: 1 / 0)
    assert list(arm.tick(4 * PERIOD_NS, [0, 0, 0], frame=RESET_FRAME).position) == [0, 0, 0]
    assert "Controller 'other' raised in on_restart" in arm.log.texts("warning")[-1]


def test_a_controller_started_after_that_does_not_go_on_from_old_commands(arm):
    assert switch_controller(arm.manager, SwitchRequest([], ["arm"]))[0]
    arm.tick(0, [0, 0, 0])
    assert switch_controller(arm.manager, SwitchRequest(["arm"], []))[0]
    assert list(arm.tick(PERIOD_NS, [0, 0, 0]).position) == [0, 0, 0]


def test_hardware_that_was_inactive_meanwhile_does_not_go_on_from_old_commands(arm):
    component = arm.resources.components["Hardware"]
    assert switch_controller(arm.manager, SwitchRequest([], ["arm"]))[0]
    for target in (State.INACTIVE, State.ACTIVE):
        assert component.change_state(target)
    arm.tick(4 * PERIOD_NS, [3, 3, 3])
    assert switch_controller(arm.manager, SwitchRequest(["arm"], []))[0]
    assert list(arm.tick(5 * PERIOD_NS, [3, 3, 3]).position) == [3, 3, 3]


def test_components_on_the_same_topics_give_one_answer():
    second = (
        '</ros2_control><ros2_control name="Hand" type="system"><hardware>'
        f"<plugin>{PLUGIN}</plugin></hardware>"
        '<joint name="finger"><command_interface name="velocity"/>'
        '<state_interface name="position"/></joint>'
    )
    stack = ControlStack(
        serial_robot(
            1,
            plugin=PLUGIN,
            extra_joints='<link name="tip"/><joint name="finger" type="continuous">'
            '<parent link="link1"/><child link="tip"/></joint>',
            extra_control=second,
        )
    )
    first, _ = stack.resources.components.values()
    first.hardware.set_cycle(stack.cycle.run)
    for name, joint, kind in (("arm", "joint1", "position"), ("hand", "finger", "velocity")):
        stack.load_controller(name, FORWARD, {"joints": [joint], "interface_name": kind})
        stack.activate(name)
        stack.nodes[name].receive("~/commands", Float64MultiArray(data=[0.5]))
    message = JointState(name=["finger", "joint1"], position=[3.0, 1.0])
    message.header.stamp = Time(nanosec=PERIOD_NS)
    stack.node.receive("/robot_joint_states", message)
    assert (stack.state("joint1/position"), stack.state("finger/position")) == (1.0, 3.0)
    (answer,) = stack.node.published("/robot_joint_commands")
    assert list(answer.name) == ["joint1", "finger"]
    assert [answer.position[0], answer.velocity[1]] == [0.5, 0.5]
    assert math.isnan(answer.position[1])
    assert math.isnan(answer.velocity[0])
    # One that goes leaves the topics to the other.
    first.change_state(State.UNCONFIGURED)
    stack.node.receive("/robot_joint_states", message)
    assert list(stack.node.published("/robot_joint_commands")[-1].name) == ["finger"]


def test_two_controllers_never_command_one_joint_in_two_ways():
    """Neither one after the other nor in one request; one alone may, and one takes over."""
    stack = ControlStack(serial_robot(1, plugin=PLUGIN, commands=("position", "velocity")))
    for name, kind in (("there", "position"), ("fast", "velocity")):
        stack.load_controller(name, FORWARD, {"joints": ["joint1"], "interface_name": kind})
        assert stack.manager.configure_controller(name)
    for request in (SwitchRequest(["there", "fast"], []), SwitchRequest(["fast", "there"], [])):
        ok, reason = switch_controller(stack.manager, request)
        assert (ok, "mode switch was rejected" in reason) == (False, True)
    assert switch_controller(stack.manager, SwitchRequest(["there"], []))[0]
    assert not switch_controller(stack.manager, SwitchRequest(["fast"], []))[0]
    assert switch_controller(stack.manager, SwitchRequest(["fast"], ["there"]))[0]
