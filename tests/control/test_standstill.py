"""A control cycle that stands still: goals end with the reason, and joints do not jump afterwards.

A simulator ends, or hardware hangs. Joints have a velocity limit of 1 rad/s; cycles come at 100 Hz.
"""

from __future__ import annotations

import threading
from typing import Any, cast

import pytest

from teleopctl.control import controller_manager, cycle_watchdog, robot_stop_node
from teleopctl.control.cycle_watchdog import CycleWatchdog
from teleopctl.control.robot_stop_node import RobotStopNode
from teleopctl.control.services import ControllerManagerServices
from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import CancelResponse, GoalResponse, GoalState, Node, RcutilsLogger
from teleopctl.robot import RESET_FRAME
from teleopctl.testing import LONGEST_WAIT_S, ControlStack, serial_robot

TRAJECTORY = "joint_trajectory_controller/JointTrajectoryController"
FORWARD = "forward_command_controller/ForwardCommandController"
GRIPPER = "position_controllers/GripperActionController"
FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")
GripperCommand = get_action("control_msgs/action/GripperCommand")
Fibonacci = get_action("example_interfaces/action/Fibonacci")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
JointState = get_message("sensor_msgs/msg/JointState")
Floats = get_message("std_msgs/msg/Float64MultiArray")
State = get_message("lifecycle_msgs/msg/State")
Trigger = get_service("std_srvs/srv/Trigger")
SetHardwareComponentState = get_service("controller_manager_msgs/srv/SetHardwareComponentState")
PERIOD_NS = 10_000_000
GONE = "Nothing publishes /robot_joint_states any more"
STATES = "/robot_joint_states"


class Arm:
    """A joint with a trajectory controller, a watchdog that a test makes look, and goals."""

    def __init__(self, plugin="mock_components/GenericSystem", joints=1):
        self.stack = ControlStack(
            serial_robot(
                joints,
                plugin=plugin,
                initial=(0.0,),
                states=("position", "velocity"),
                limits='lower="-9" upper="9" effort="10" velocity="1"',
            ),
            enforce_limits=False,
        )
        (component,) = self.stack.resources.components.values()
        self.hardware: Any = component.hardware
        self.ended: list[object] = []
        self.watchdog = CycleWatchdog(
            self.stack.cycle,
            cast(RcutilsLogger, self.stack.log),
            limit_s=0.0,
            on_limit=self.ended.append,
            aborts_goals=True,
        )
        parameters = {
            "joints": ["joint1"],
            "command_interfaces": ["position"],
            "state_interfaces": ["position", "velocity"],
        }
        self.stack.load_controller("arm", TRAJECTORY, parameters)
        self.stack.activate("arm")

    def send_goal(self, position, seconds):
        goal = FollowJointTrajectory.Goal()
        point = Point(positions=[position])
        point.time_from_start.sec = seconds
        goal.trajectory.joint_names, goal.trajectory.points = ["joint1"], [point]
        handle: Any = self.server.send_goal(goal)
        return handle

    @property
    def server(self):
        return self.stack.action_servers["arm/follow_joint_trajectory"]

    def reason(self, handle):
        return self.server.result(handle).error_string

    def refusals(self, name="arm"):
        return [text for text in self.stack.nodes[name].log.texts() if "is refused" in text]


class SimulatedArm(Arm):
    """The arm behind topics, in lockstep: a test sends the states of a simulator."""

    def __init__(self, joints=1):
        super().__init__(plugin="gazebo_ros2_control/GazeboSystem", joints=joints)
        self.hardware.set_cycle(self.stack.cycle.run)
        self.watchdog.absence = self.hardware.absence
        self.names = [f"joint{number + 1}" for number in range(joints)]
        self.simulators = 1
        subscription: Any = self.stack.node.endpoints[STATES]
        subscription.get_publisher_count = lambda: self.simulators

    def tick(self, tick, position, frame=""):
        """Send the state of a tick; return the command for the first joint."""
        count = len(self.names)
        message = JointState(
            name=self.names, position=[float(position)] * count, velocity=[0.0] * count
        )
        message.header.stamp.sec, rest = divmod(tick, 100)
        message.header.stamp.nanosec = rest * PERIOD_NS
        message.header.frame_id = frame
        self.stack.node.receive(STATES, message)
        return self.stack.node.published("/robot_joint_commands")[-1].position[0]

    def move(self, ticks):
        """Follow what is commanded for some ticks; return the position."""
        position = 0.0
        for tick in range(1, ticks + 1):
            position = self.tick(tick, position)
        return position

    def end_simulator(self):
        self.simulators = 0
        # States may have come since the last look.
        self.watchdog.look()
        self.watchdog.look()


def test_a_simulator_that_ends_is_reported_once_and_its_goals_end_with_the_reason():
    arm = SimulatedArm()
    arm.tick(1, 0.0)
    handle = arm.send_goal(5.0, 10)
    arm.move(20)
    arm.end_simulator()
    arm.watchdog.look()
    (report,) = arm.stack.log.texts("error")
    assert report == (
        f"{GONE}: the control cycle stands still. Goals are aborted, and goals and commands are "
        "refused, until states come again"
    )
    assert handle.status == GoalState.ABORTED
    assert arm.reason(handle) == f"The control cycle stands still: {GONE}"


def test_a_simulator_that_is_paused_has_not_ended():
    arm = SimulatedArm()
    arm.tick(1, 0.0)
    handle = arm.send_goal(5.0, 10)
    arm.move(20)
    for _ in range(3):
        arm.watchdog.look()
    assert handle.is_active
    assert arm.stack.log.texts("error") == []


def test_goals_and_commands_are_refused_while_there_is_no_simulator():
    arm = SimulatedArm(joints=2)
    arm.stack.load_controller(
        "forward", FORWARD, {"joints": ["joint2"], "interface_name": "position"}
    )
    arm.stack.activate("forward")
    arm.move(2)
    arm.end_simulator()
    assert arm.send_goal(1.0, 1) is None
    arm.stack.nodes["forward"].receive("~/commands", Floats(data=[1.0]))
    why = f"is refused: the control cycle stands still: {GONE}."
    assert arm.refusals() == [f"The action goal {why}"]
    assert arm.refusals("forward") == [f"The command on ~/commands {why}"]


@pytest.mark.parametrize(
    ("first", "frame"), [(0, ""), (21, ""), (5000, RESET_FRAME)], ids=["new", "later", "reset"]
)
def test_when_a_simulator_comes_back_controllers_hold_the_joints_there_and_take_goals(first, frame):
    arm = SimulatedArm()
    arm.tick(1, 0.0)
    arm.send_goal(5.0, 10)
    arm.move(20)
    arm.end_simulator()
    arm.simulators = 1
    assert arm.tick(first, 0.7, frame) == 0.7
    assert arm.tick(first + 1, 0.7) == 0.7
    assert arm.stack.log.texts("info")[-1] == (
        f"Controllers go on from where the joints are, without their goals: {GONE}"
    )
    handle = arm.send_goal(0.8, 1)
    position = 0.7
    for tick in range(2, 110):
        position = arm.tick(first + tick, position)
    assert handle.status == GoalState.SUCCEEDED
    assert position == pytest.approx(0.8)


def test_a_goal_that_came_after_the_end_of_the_simulator_is_not_executed_when_it_is_back():
    arm = SimulatedArm()
    arm.move(2)
    arm.simulators = 0
    arm.watchdog.look()
    handle = arm.send_goal(5.0, 10)
    arm.watchdog.look()
    assert handle.status == GoalState.ABORTED
    assert [arm.tick(tick, 0.3) for tick in range(3, 9)] == [0.3] * 6


def test_a_stop_holds_while_the_simulator_is_gone_and_when_it_is_back():
    arm = SimulatedArm()
    arm.tick(1, 0.0)
    arm.send_goal(5.0, 10)
    arm.move(20)
    arm.end_simulator()
    arm.stack.manager.robot_stop.hold("/button")
    assert [arm.tick(tick, 0.7) for tick in range(5)] == [0.7] * 5
    assert arm.send_goal(1.0, 1) is None
    assert "stopped by /button" in arm.refusals()[-1]


def test_goals_of_a_controller_of_ones_own_and_of_a_gripper_end_too():
    arm = SimulatedArm(joints=2)
    arm.stack.load_controller("gripper", GRIPPER, {"joint": "joint2"})
    arm.stack.load_controller("own", "tests.control.fakes:Recorder", {})
    own = arm.stack.manager.controllers["own"].controller
    own.create_action_server(
        Fibonacci,
        "~/count",
        goal_callback=lambda _: GoalResponse.ACCEPT,
        handle_accepted_callback=lambda handle: handle.executing(),
        cancel_callback=lambda _: CancelResponse.ACCEPT,
    )
    arm.stack.activate("gripper", "own")
    arm.move(2)
    goal = GripperCommand.Goal()
    goal.command.position = 5.0
    handles: list[Any] = [
        arm.stack.action_servers[name].send_goal(goal)
        for name, goal in (("gripper/gripper_cmd", goal), ("own/count", Fibonacci.Goal()))
    ]
    arm.end_simulator()
    assert [handle.status for handle in handles] == [GoalState.ABORTED] * 2


class Hanging:
    """A cycle on the wall clock that hangs in the hardware's read, until it is let go."""

    def __init__(self, arm, monkeypatch):
        monkeypatch.setattr(cycle_watchdog, "_PATIENCE_S", 0.0)
        for module in (controller_manager, robot_stop_node):
            monkeypatch.setattr(module, "LONGEST_CYCLE_S", 0.01)
        self._arm = arm
        self._hangs, self._goes_on = threading.Event(), threading.Event()
        self._read = arm.hardware.read
        arm.hardware.read = self._hang
        self._thread = threading.Thread(target=arm.stack.step)

    def _hang(self, *arguments):
        self._hangs.set()
        assert self._goes_on.wait(LONGEST_WAIT_S)
        return self._read(*arguments)

    def __enter__(self):
        self._thread.start()
        assert self._hangs.wait(LONGEST_WAIT_S)
        self._arm.watchdog.look()
        return self

    def __exit__(self, *_):
        self._goes_on.set()
        self._thread.join()
        self._arm.hardware.read = self._read


@pytest.fixture
def arm():
    """The arm on the wall clock, in the midst of a goal."""
    arm: Any = Arm()
    arm.stack.resources.set_lockstep(False)
    arm.stack.step()
    arm.handle = arm.send_goal(5.0, 10)
    arm.stack.step(100)
    return arm


def test_a_goal_ends_with_the_name_of_hardware_that_hangs_and_the_joints_do_not_jump(
    arm, monkeypatch
):
    with Hanging(arm, monkeypatch) as hanging:
        assert arm.handle.status == GoalState.ABORTED
        reason = arm.reason(arm.handle)
        assert reason.startswith(
            "The control cycle stands still: Hardware 'Hardware' has not returned from read() for"
        )
        assert arm.send_goal(1.0, 1) is None
        del hanging
    before = arm.stack.command("joint1/position")
    assert before == pytest.approx(0.5, abs=0.02)
    arm.stack.step(period_ns=3_000_000_000)
    arm.stack.step(20)
    assert arm.stack.command("joint1/position") == pytest.approx(before, abs=0.011)
    (report,) = arm.stack.log.texts("error")
    assert "Goals are aborted" in report
    assert arm.send_goal(1.0, 1) is not None


def test_joints_do_not_jump_after_a_time_without_cycles_that_nobody_saw(arm):
    """As after the process was stopped."""
    before = arm.stack.command("joint1/position")
    arm.stack.step(period_ns=2_000_000_000)
    arm.stack.step(20)
    assert arm.stack.command("joint1/position") == pytest.approx(before, abs=0.011)
    assert arm.reason(arm.handle) == ("The control cycle stands still: no cycle began for 2.0 s")
    assert arm.stack.log.texts("info")[-1] == (
        "Controllers go on from where the joints are, without their goals: no cycle began for 2.0 s"
    )


def test_a_stop_is_confirmed_only_when_a_cycle_can_obey_it(arm, monkeypatch):
    node = arm.stack.node
    node.resolve_service_name = lambda name: name
    lock = arm.stack.manager.cycle_lock
    stop = RobotStopNode(cast(Node, node), arm.stack.manager.robot_stop, arm.stack.parameter, lock)
    confirmed = threading.Event()
    publish = node.endpoints["~/is_stopped"].publish

    def published(message):
        publish(message)
        confirmed.set()

    node.endpoints["~/is_stopped"].publish = published
    with Hanging(arm, monkeypatch):
        answer = node.call("~/stop", Trigger.Request(), Trigger.Response())
        assert not answer.success
        assert answer.message.startswith("The robot is not stopped yet: the control cycle does not")
        assert [each.data for each in node.published("~/is_stopped")] == [False]
    assert confirmed.wait(LONGEST_WAIT_S)
    assert [each.data for each in node.published("~/is_stopped")] == [False, True]
    assert node.call("~/stop", Trigger.Request(), Trigger.Response()).success
    del stop


def test_a_manager_with_a_cycle_that_hangs_answers_and_can_be_ended(arm, monkeypatch):
    monkeypatch.setattr("teleopctl.control.services.LONGEST_CYCLE_S", 0.01)
    ControllerManagerServices(cast(Node, arm.stack.node), arm.stack.manager)
    request = SetHardwareComponentState.Request(
        name="Hardware", target_state=State(label="inactive")
    )
    with Hanging(arm, monkeypatch):
        name = "~/set_hardware_component_state"
        answer = arm.stack.node.call(name, request, SetHardwareComponentState.Response())
        assert not answer.ok
        assert "the control cycle has not ended within" in arm.stack.log.texts("error")[-1]
        arm.stack.manager.shutdown()
        assert arm.stack.log.texts("error")[-1] == (
            "Controllers and hardware are not deactivated: the control cycle does not end"
        )


def test_states_that_come_seldom_are_no_standstill(arm):
    handle = arm.handle
    for _ in range(3):
        arm.stack.step(period_ns=500_000_000)
    for _ in range(3):
        arm.stack.step(period_ns=1_200_000_000)
    assert handle.is_active
