"""The gripper action controllers, on one joint at 0.2, 100 Hz."""

from typing import Any

import pytest

from teleopctl.interfaces import get_action, get_message
from teleopctl.node import GoalState
from teleopctl.testing import ControlStack, serial_robot

GripperCommand = get_action("control_msgs/action/GripperCommand")
ParallelGripperCommand = get_action("control_msgs/action/ParallelGripperCommand")
JointState = get_message("sensor_msgs/msg/JointState")
POSITION = "position_controllers/GripperActionController"
EFFORT = "effort_controllers/GripperActionController"
PARALLEL = "parallel_gripper_action_controller/GripperActionController"


class Gripper:
    """An active gripper on hardware that moves when the test says so."""

    def __init__(self, kind=POSITION, commands=("position",), **parameters):
        robot = serial_robot(
            1, initial=(0.2,), commands=commands, states=("position", "velocity", "effort")
        )
        self.kind = kind
        self.stack = ControlStack(robot)
        hardware: Any = self.stack.resources.components["Hardware"].hardware
        hardware._pairs = []
        options = {"joint": "joint1", **parameters}
        self.stack.load_controller("gripper", kind, options)
        self.stack.activate("gripper")
        self.server = self.stack.action_servers["gripper/gripper_cmd"]

    def send(self, position, max_effort=5.0):
        if self.kind == PARALLEL:
            positions = position if isinstance(position, list) else [position]
            command = JointState(position=positions, effort=[max_effort])
            return self.server.send_goal(ParallelGripperCommand.Goal(command=command))
        goal = GripperCommand.Goal()
        goal.command.position, goal.command.max_effort = position, max_effort
        return self.server.send_goal(goal)

    def measure(self, position, velocity=0.0):
        self.stack.resources.state_interfaces["joint1/position"].value = position
        self.stack.resources.state_interfaces["joint1/velocity"].value = velocity

    def outcome(self, handle):
        result = self.server.result(handle)
        return GoalState(handle.status), result.reached_goal, result.stalled


@pytest.fixture(params=[POSITION, PARALLEL])
def gripper(request):
    return Gripper(request.param)


def test_a_gripper_needs_a_joint():
    with pytest.raises(AssertionError, match="Could not configure"):
        Gripper(joint="")


def test_it_holds_until_a_goal_comes(gripper):
    gripper.stack.step(3)
    assert gripper.stack.command("joint1/position") == 0.2


def test_a_goal_is_reached_within_the_tolerance(gripper):
    handle = gripper.send(0.5)
    gripper.stack.step()
    assert gripper.stack.command("joint1/position") == 0.5
    gripper.measure(0.48, 0.1)
    gripper.stack.step(300)
    assert handle.status == GoalState.EXECUTING  # slow is not stalled
    gripper.measure(0.495)
    gripper.stack.step()
    assert gripper.outcome(handle) == (GoalState.SUCCEEDED, True, False)


@pytest.mark.parametrize("kind", [POSITION, PARALLEL])
@pytest.mark.parametrize(
    ("allowed", "state"), [(False, GoalState.ABORTED), (True, GoalState.SUCCEEDED)]
)
def test_a_gripper_that_does_not_move_has_stalled(kind, allowed, state):
    gripper = Gripper(kind, allow_stalling=allowed, stall_timeout=0.5)
    handle = gripper.send(0.5)
    gripper.measure(0.3, 0.0005)
    gripper.stack.step(51)
    assert handle.status == GoalState.EXECUTING
    gripper.stack.step()
    assert gripper.outcome(handle) == (state, False, True)
    result = gripper.server.result(handle)
    position = result.state.position[0] if kind == PARALLEL else result.position
    assert position == 0.3
    gripper.stack.step(10)
    assert gripper.stack.command("joint1/position") == 0.5  # it goes on gripping


def test_a_cancelled_goal_holds(gripper):
    handle = gripper.send(0.5)
    gripper.measure(0.3, 0.1)
    gripper.stack.step()
    assert gripper.server.cancel(handle)
    gripper.stack.step()
    assert gripper.outcome(handle) == (GoalState.CANCELED, False, False)
    assert gripper.stack.command("joint1/position") == 0.3


def test_a_new_goal_and_deactivation_abort_a_goal(gripper):
    first = gripper.send(0.5)
    gripper.stack.step()
    second = gripper.send(0.4)
    assert first.status == GoalState.ABORTED
    gripper.stack.step()
    gripper.stack.deactivate("gripper")
    assert second.status == GoalState.ABORTED
    assert gripper.send(0.5) is None


def test_a_goal_has_one_finite_position():
    gripper = Gripper(PARALLEL)
    assert gripper.send([]) is None
    assert gripper.send([0.1, 0.2]) is None
    assert gripper.send(float("nan")) is None
    assert gripper.stack.nodes["gripper"].log.texts("error")[0] == (
        "Received action goal with wrong number of position values, expects 1, got 0"
    )


def test_effort_is_a_pid_within_the_largest_effort_of_the_goal():
    gripper = Gripper(EFFORT, ("effort",), **{"gains.joint1.p": 20.0, "gains.joint1.d": 1.0})
    gripper.send(0.5, max_effort=4.0)
    gripper.measure(0.4, 0.5)
    gripper.stack.step()
    assert gripper.stack.command("joint1/effort") == pytest.approx(20.0 * 0.1 - 0.5)
    gripper.measure(0.0)
    gripper.stack.step()
    assert gripper.stack.command("joint1/effort") == 4.0
    gripper.stack.deactivate("gripper")
    assert gripper.stack.command("joint1/effort") == 0.0


def test_the_parallel_gripper_tells_the_hardware_its_limits():
    gripper = Gripper(
        PARALLEL,
        ("position", "effort", "velocity"),
        max_effort_interface="joint1/effort",
        max_velocity_interface="joint1/velocity",
        max_velocity=0.3,
    )
    gripper.stack.step()
    assert gripper.stack.command("joint1/effort") == 10.0
    gripper.send(0.5, max_effort=4.0)
    gripper.stack.step()
    commands = [gripper.stack.command(f"joint1/{n}") for n in ("position", "effort", "velocity")]
    assert commands == [0.5, 4.0, 0.3]


@pytest.mark.parametrize(("kind", "commands"), [(POSITION, ["position"]), (EFFORT, ["effort"])])
def test_reloaded_code_keeps_the_grip_on_an_object_and_the_goal(kind, commands):
    gains = {f"gains.joint1.{name}": 10.0 for name in ("p", "i", "i_clamp")}
    grippers = [Gripper(kind, commands, **gains) for _ in range(2)]
    reloaded, other = grippers
    goals = [gripper.send(0.6) for gripper in grippers]
    for gripper in grippers:
        gripper.measure(0.3)
        gripper.stack.step(5)
    reloaded.stack.reload_controller("gripper")
    other.stack.step()
    for gripper in grippers:
        gripper.stack.step(200)
    assert reloaded.stack.commands(commands[0]) == other.stack.commands(commands[0])
    assert [gripper.outcome(goal) for gripper, goal in zip(grippers, goals, strict=True)] == [
        (GoalState.ABORTED, False, True)
    ] * 2
