"""``~/follow_joint_trajectory`` of the joint trajectory controller, by what its publishers test."""

import pytest

from teleopctl.interfaces import get_action, get_message
from teleopctl.node import STREAM_FRAME, GoalState, Parameter
from teleopctl.testing import serial_robot
from tests.control.controllers.joint_trajectory.arm import (
    JOINTS,
    Arm,
    duration,
    near,
    point,
    trajectory,
)

FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")
JointTolerance = get_message("control_msgs/msg/JointTolerance")
START = [1.1, 2.1, 3.1]
TOLERANT = {f"constraints__{joint}__goal": 0.1 for joint in JOINTS}
SUCCESSFUL, INVALID_GOAL, PATH_VIOLATED, GOAL_VIOLATED = 0, -1, -4, -5


class Client:
    """Sends goals to an arm."""

    def __init__(self, **options):
        self.arm = Arm(**options).up()
        self.server = self.arm.stack.action_servers["arm/follow_joint_trajectory"]

    def send(self, *points, joints=JOINTS, path=(), goal=(), goal_time=0.0):
        return self.server.send_goal(
            FollowJointTrajectory.Goal(
                trajectory=trajectory(*points, joints=joints),
                path_tolerance=[JointTolerance(name=n, position=p) for n, p in path],
                goal_tolerance=[JointTolerance(name=n, position=p) for n, p in goal],
                goal_time_tolerance=duration(goal_time),
            )
        )

    def outcome(self, handle):
        result = self.server.result(handle)
        return GoalState(handle.status), result.error_code, result.error_string


def moving_arm(**options):
    """An arm that measures velocity too."""
    return Client(
        robot=serial_robot(
            commands=("position", "velocity"),
            states=("position", "velocity"),
            parameters='<param name="calculate_dynamics">false</param>',
        ),
        command_interfaces=["position", "velocity"],
        state_interfaces=["position", "velocity"],
        **options,
    )


def test_a_goal_succeeds_when_its_last_point_is_reached_and_is_held():
    client = Client()
    handle = client.send(point(0.5, [1.0, 2.0, 3.0]))
    assert handle.status == GoalState.EXECUTING
    client.arm.step(0.5)
    assert client.server.result(handle) is None
    client.arm.step(0.02)
    expected = (GoalState.SUCCEEDED, SUCCESSFUL, "Goal successfully reached!")
    assert client.outcome(handle) == expected
    client.arm.step(1.0)
    assert client.arm.commands == near([1.0, 2.0, 3.0])


def test_the_last_velocity_is_commanded_after_success_where_it_may_be():
    client = moving_arm(allow_nonzero_velocity_at_trajectory_end=True)
    handle = client.send(point(0.2, [1.2, 2.2, 3.2], [0.5, 0.5, 0.5]))
    client.arm.step(0.4)
    assert handle.status == GoalState.SUCCEEDED
    assert client.arm.stack.commands("velocity") == near([0.5] * 3)


def test_feedback_comes_at_the_monitor_rate_and_says_what_is_desired_and_measured():
    client = Client(action_monitor_rate=10.0)
    client.send(point(0.5, [1.6, 2.1, 3.1]), point(1.0, [1.6, 2.6, 3.1]))
    client.arm.step(1.2)
    feedback = client.server.feedback
    assert len(feedback) == 11  # at the beginning, then each 0.1 s; none after the end
    assert list(feedback[0].joint_names) == JOINTS
    for message in feedback:
        moved = min(max(message.desired.time_from_start.nanosec * 1e-9, 0.0), 0.5)
        if message.desired.time_from_start.sec == 0 and moved < 0.5:
            assert message.desired.positions[0] == near(1.1 + moved)
        wanted, measured = message.desired.positions, message.actual.positions
        differences = [one - other for one, other in zip(wanted, measured, strict=True)]
        assert list(message.error.positions) == near(differences)
    assert feedback[-1].header.stamp.sec == 1001


def test_a_goal_is_rejected_that_is_no_trajectory_of_this_controller():
    client = Client()
    assert client.send(point(0.5, [1.0, 2.0])) is None
    assert client.send() is None
    assert client.send(point(0.5, [1.0] * 3), joints=["a", "b", "c"]) is None
    assert client.send(point(0.5, [1.0] * 3, [0.1] * 3)) is None
    client.arm.deactivate()
    assert client.send(point(0.5, [1.0, 2.0, 3.0])) is None
    assert client.arm.rejections()[-1] == (
        "Can't accept new action goals. Controller is not running."
    )


def test_a_goal_may_name_some_joints_where_that_is_allowed():
    client = Client(allow_partial_joints_goal=True)
    handle = client.send(point(0.2, [2.0, 1.0]), joints=["joint3", "joint1"])
    client.arm.step(0.4)
    assert handle.status == GoalState.SUCCEEDED
    assert client.arm.commands == near([1.0, 2.1, 2.0])


def test_a_goal_waits_for_the_robot_and_is_aborted_when_it_comes_too_late():
    client = Client(constraints__goal_time=0.3, **TOLERANT)
    client.arm.freeze()
    handle = client.send(point(0.2, [4.0, 5.0, 6.0]))
    client.arm.step(0.45)
    assert handle.status == GoalState.EXECUTING
    client.arm.step(0.15)
    state, code, text = client.outcome(handle)
    assert (state, code) == (GoalState.ABORTED, GOAL_VIOLATED)
    assert text.startswith("Aborted due to goal_time_tolerance exceeding by 0.3")
    assert "joint joint1: Position Error: 2.900000, Position Tolerance: 0.100000" in text
    client.arm.step(0.01)
    assert client.arm.commands == near(START)


def test_a_goal_ends_as_soon_as_the_robot_is_within_the_goal_tolerances():
    client = Client(**TOLERANT)
    client.arm.freeze()
    handle = client.send(point(0.2, [1.3, 2.1, 3.1]))
    client.arm.step(2.0)
    assert handle.status == GoalState.EXECUTING  # without goal_time it may take for ever
    client.arm.freeze(joint1_position=1.25)
    client.arm.step(0.01)
    assert handle.status == GoalState.SUCCEEDED


@pytest.mark.parametrize("seconds", [0.5, 0.0])
def test_a_goal_is_aborted_where_the_path_tolerances_are_violated(seconds):
    client = Client(**{f"constraints__{joint}__trajectory": 0.0001 for joint in JOINTS})
    client.arm.freeze()
    handle = client.send(point(seconds, [4.0, 5.0, 6.0]))
    client.arm.step(0.1)
    state, code, text = client.outcome(handle)
    assert (state, code) == (GoalState.ABORTED, PATH_VIOLATED)
    assert text.startswith("Aborted due to path tolerance violation: joint joint1: Position Error:")
    assert client.arm.commands == near(START, 0.05)


def test_tolerances_of_a_goal_hold_for_it_alone():
    client = Client(constraints__goal_time=0.1, **TOLERANT)
    client.arm.freeze()
    target = point(0.1, [1.4, 2.1, 3.1])  # 0.3 further than the frozen arm is
    for goal, goal_time, state in [
        ([("joint3", 0.5), ("joint1", 0.5)], 0.0, GoalState.SUCCEEDED),
        ([], 0.0, GoalState.ABORTED),  # the defaults again
        ([("joint1", -1.0)], 0.0, GoalState.SUCCEEDED),
        ([("joint1", -123.0)], 0.0, GoalState.ABORTED),
        ([("joint1", 0.5), ("elbow", 0.5)], 0.0, GoalState.ABORTED),
        ([], 2.0, GoalState.EXECUTING),
    ]:
        handle = client.send(target, goal=goal, goal_time=goal_time)
        client.arm.step(0.5)
        assert handle.status == state, (goal, goal_time)
    assert [text for text in client.arm.rejections() if "Using default" in text] == [
        "joint 'joint1' specified in goal.goal_tolerance has a invalid position tolerance. Using "
        "default tolerances.",
        "joint 'elbow' specified in goal.goal_tolerance does not exist. Using default tolerances.",
    ]


def test_a_path_tolerance_of_a_goal_is_heeded():
    client = Client()
    client.arm.freeze()
    handle = client.send(point(0.5, [4.0, 5.0, 6.0]), path=[("joint2", 0.2)])
    client.arm.step(0.2)
    assert "joint joint2: Position Error: " in client.outcome(handle)[2]


def test_a_new_goal_aborts_the_one_before():
    client = Client()
    first = client.send(point(1.0, [4.0, 5.0, 6.0]))
    client.arm.step(0.2)
    second = client.send(point(0.2, [1.0, 2.0, 3.0]))
    expected = (
        GoalState.ABORTED,
        INVALID_GOAL,
        "Current goal preempted by new incoming action.",
    )
    assert client.outcome(first) == expected
    client.arm.step(0.3)
    assert client.outcome(second)[0] == GoalState.SUCCEEDED
    assert client.arm.commands == near([1.0, 2.0, 3.0])


def test_of_a_flood_of_goals_the_last_one_is_followed_and_all_others_have_their_result():
    client = Client()
    targets = [[1.1 + number / 500, 2.1, 3.1] for number in range(100)]
    handles = [client.send(point(0.2, target)) for target in targets]
    client.arm.step(0.4)
    ends = [handle.status for handle in handles]
    assert ends == [GoalState.ABORTED] * 99 + [GoalState.SUCCEEDED]
    assert client.arm.commands == near(targets[-1])


def test_a_trajectory_over_the_topic_takes_the_goal_over():
    client = Client()
    handle = client.send(point(1.0, [4.0, 5.0, 6.0]))
    # Once before the control loop has seen the goal, once while it is followed.
    client.arm.send(trajectory(point(0.5, [2.0, 2.0, 2.0])))
    client.arm.step(0.2)
    client.arm.send(trajectory(point(0.2, [1.5, 2.5, 3.5])))
    client.arm.step(0.1)
    assert handle.status == GoalState.EXECUTING
    client.arm.step(0.2)
    assert handle.status == GoalState.SUCCEEDED
    assert client.arm.commands == near([1.5, 2.5, 3.5])


def test_a_stream_gives_way_to_the_goal_and_begins_after_it():
    client = Client()
    handle = client.send(point(0.5, [2.0, 2.0, 2.0]))
    stream = trajectory(point(0.1, [1.5, 2.5, 3.5]))
    stream.header.frame_id = STREAM_FRAME
    for _ in range(6):
        client.arm.send(stream)
        client.arm.step(0.1)
    assert handle.status == GoalState.SUCCEEDED
    assert client.arm.commands == near([2.0, 2.0, 2.0])
    client.arm.send(stream)
    client.arm.step(0.2)
    assert client.arm.commands == near([1.5, 2.5, 3.5])


@pytest.mark.parametrize("followed", [True, False])
def test_a_cancelled_goal_holds_where_the_robot_is(followed):
    client = Client()
    handle = client.send(point(1.0, [2.1, 3.1, 4.1]))
    if followed:
        client.arm.step(0.5)
    assert client.server.cancel(handle)
    assert handle.status == GoalState.CANCELING
    client.arm.step(0.01)
    assert client.outcome(handle) == (GoalState.CANCELED, SUCCESSFUL, "")
    held = client.arm.commands
    assert held == near([1.6, 2.6, 3.6] if followed else START, 0.02)
    client.arm.step(1.0)
    assert client.arm.commands == held


def test_a_cancelled_goal_slows_down_where_the_parameters_say_so():
    client = moving_arm(
        constraints__decelerate_on_cancel=True,
        **{f"constraints__{joint}__max_deceleration_on_cancel": 10.0 for joint in JOINTS},
    )
    handle = client.send(point(1.0, START))
    client.arm.freeze(joint1_velocity=0.2, joint2_velocity=-0.4, joint3_velocity=0.0)
    client.arm.step(0.01)
    client.server.cancel(handle)
    client.arm.step(0.01)
    assert handle.status == GoalState.CANCELED
    # v |v| / 2d further on: 0.2 and 0.4 rad/s end after 20 and 40 ms.
    assert client.arm.stack.commands("velocity") == near([0.1, -0.3, 0.0])
    client.arm.step(0.02)
    assert client.arm.stack.commands("velocity") == near([0.0, -0.1, 0.0])
    client.arm.step(0.1)
    assert client.arm.stack.commands("velocity") == near([0.0] * 3)
    assert client.arm.commands == near([1.1 + 0.002, 2.1 - 0.008, 3.1], 1e-6)


def test_deactivation_aborts_the_goal_and_halts():
    client = moving_arm()
    handle = client.send(point(2.5, [4.0, 5.0, 6.0], [0.0] * 3))
    client.arm.step(0.5)
    moving = client.arm.commands
    client.arm.deactivate()
    expected = (
        GoalState.ABORTED,
        INVALID_GOAL,
        "Current goal cancelled during deactivate transition.",
    )
    assert client.outcome(handle) == expected
    assert client.arm.commands == moving
    assert client.arm.stack.commands("velocity") == [0.0] * 3
    client.arm.activate()
    client.arm.step(0.5)
    assert client.arm.commands == near(moving)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_speed_scaling_stretches_a_goal_and_keeps_its_tolerances(factor):
    client = Client(
        speed_scaling__initial_scaling_factor=factor,
        **{f"constraints__{joint}__trajectory": 0.3 for joint in JOINTS},
    )
    handle = client.send(point(1.0, [2.1, 3.1, 4.1]))
    client.arm.step(1.0 / factor)
    assert handle.status == GoalState.EXECUTING
    client.arm.step(0.02)
    assert handle.status == GoalState.SUCCEEDED
    for message in client.server.feedback:
        wanted, actual = (
            part.time_from_start.sec + part.time_from_start.nanosec * 1e-9
            for part in (message.desired, message.actual)
        )
        assert wanted == pytest.approx(factor * actual, rel=1e-3, abs=1e-9)


def test_a_clock_that_goes_back_aborts_the_goal():
    client = Client()
    handle = client.send(point(1.0, [2.1, 3.1, 4.1]))
    client.arm.step(0.5)
    client.arm.stack.time_ns -= 10**9
    client.arm.step(0.01)
    assert client.outcome(handle)[:2] == (GoalState.ABORTED, INVALID_GOAL)


def test_changed_tolerances_count_for_the_next_goal():
    client = Client()
    client.arm.freeze()
    client.arm.node.set_parameters([Parameter("constraints.joint1.trajectory", value=0.01)])
    client.arm.step(0.01)
    handle = client.send(point(0.5, [4.0, 5.0, 6.0]))
    client.arm.step(0.2)
    assert client.outcome(handle)[1] == PATH_VIOLATED


def test_reloaded_code_goes_on_with_the_goal_and_its_client_notices_nothing():
    moved, plain = Client(), Client()
    handles = [client.send(point(1.0, [1.5, 2.5, 3.5])) for client in (moved, plain)]
    for client in (moved, plain):
        client.arm.step(0.4)
    before = moved.arm.stack.manager.controllers["arm"].controller
    moved.arm.stack.reload_controller("arm")
    plain.arm.step(0.01)
    assert moved.arm.stack.manager.controllers["arm"].controller is not before
    assert handles[0].status == GoalState.EXECUTING
    assert moved.arm.commands == plain.arm.commands
    for client in (moved, plain):
        client.arm.step(0.62)
    assert moved.arm.commands == plain.arm.commands
    assert moved.server.feedback == plain.server.feedback
    assert moved.outcome(handles[0]) == (GoalState.SUCCEEDED, 0, "Goal successfully reached!")


def test_reloaded_code_cancels_aborts_and_accepts_goals():
    client = Client()
    first = client.send(point(1.0, [1.5, 2.5, 3.5]))
    client.arm.stack.reload_controller("arm")
    second = client.send(point(1.0, [1.5, 2.5, 3.5]))
    assert client.outcome(first)[0] is GoalState.ABORTED
    assert client.server.cancel(second)
    client.arm.step(0.02)
    assert client.outcome(second)[0] is GoalState.CANCELED
