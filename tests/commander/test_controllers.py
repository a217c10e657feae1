"""Which controllers move joints, by which topic or action, and what each is sent."""

import pytest

from teleopctl.commander import (
    ActionKind,
    CommandTopic,
    Controller,
    StreamKind,
    active_controllers,
    choose_controllers,
    choose_streams,
    goal_for,
)
from teleopctl.interfaces import get_message

ControllerState = get_message("controller_manager_msgs/msg/ControllerState")
JointTrajectory = get_message("trajectory_msgs/msg/JointTrajectory")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
JTC = "joint_trajectory_controller/JointTrajectoryController"
FORWARD = "forward_command_controller/ForwardCommandController"


def state(name, kind, *claimed, active=True, **fields):
    word = "active" if active else "inactive"
    return ControllerState(
        name=name, type=kind, state=word, claimed_interfaces=list(claimed), **fields
    )


ARM = Controller("arm", ("a", "b"), "arm/follow_joint_trajectory")
WRIST = Controller("wrist", ("c",), "wrist/follow_joint_trajectory")
BOTH = Controller("both", ("a", "b", "c"), "both/follow_joint_trajectory")


def trajectory(names, *positions):
    points = [Point(positions=list(each), velocities=[1.0] * len(names)) for each in positions]
    return JointTrajectory(joint_names=names, points=points)


class TestActive:
    def test_controllers_have_their_joints_with_an_action_a_topic_or_both(self):
        arm, hand, claw, forward, torque = active_controllers(
            [
                state("arm", JTC, "a/position", "b/position", "a/velocity", "b/velocity"),
                state("hand", "position_controllers/GripperActionController", "f/position"),
                state(
                    "claw",
                    "parallel_gripper_action_controller/GripperActionController",
                    "g/position",
                ),
                state("off", JTC, "c/position", active=False),
                state("jsb", "joint_state_broadcaster/JointStateBroadcaster"),
                state("forward", FORWARD, "e/velocity", "d/velocity"),
                state("torque", FORWARD, "h/effort"),
            ],
            "/left",
        )
        assert (arm.joints, arm.action) == (("a", "b"), "/left/arm/follow_joint_trajectory")
        assert arm.stream == CommandTopic(
            "/left/arm/joint_trajectory", StreamKind.TRAJECTORY, ("a", "b")
        )
        assert (hand.action, hand.kind) == ("/left/hand/gripper_cmd", ActionKind.GRIPPER)
        assert (claw.action, claw.kind) == ("/left/claw/gripper_cmd", ActionKind.PARALLEL_GRIPPER)
        assert (forward.action, forward.stream) == (
            "",
            CommandTopic("/left/forward/commands", StreamKind.ARRAY, ("e", "d"), "velocity"),
        )
        assert (torque.action, torque.stream) == ("", None)

    def test_of_a_chain_the_first_controller_moves_the_joints(self):
        below = state("stiff", FORWARD, "a/position", is_chained=True)
        (found,) = active_controllers([state("arm", JTC, "stiff/a/position"), below], "/")
        assert (found.name, found.joints) == ("arm", ("a",))


class TestStreams:
    def chosen(self, states, joints):
        return [target.topic for target in choose_streams(active_controllers(states, "/"), joints)]

    def test_controllers_that_share_the_joints_are_commanded_together(self):
        both = [state("one", FORWARD, "a/position"), state("two", JTC, "b/position")]
        assert self.chosen(both, ["a", "b"]) == ["/one/commands", "/two/joint_trajectory"]

    def test_controllers_of_other_joints_are_left_alone(self):
        both = [state("one", FORWARD, "a/position"), state("hand", JTC, "g/position")]
        assert self.chosen(both, ["a"]) == ["/one/commands"]

    @pytest.mark.parametrize(
        "found",
        [
            state("arm", JTC, "a/position", "b/position", active=False),
            state("arm", JTC, "a/position"),
            state("arm", FORWARD, "a/effort", "b/effort"),
        ],
    )
    def test_without_controllers_of_all_joints_nothing_is_commanded(self, found):
        assert self.chosen([found], ["a", "b"]) == []


class TestGoals:
    @pytest.mark.parametrize(
        ("joints", "named", "expected", "left"),
        [
            (["a", "b"], ["arm"], ["arm"], []),
            (["a", "c"], ["arm", "wrist"], ["arm", "wrist"], []),
            (["a", "c"], [], ["both"], []),
            (["a", "x"], ["arm"], ["arm"], ["x"]),
            (["a"], ["none"], [], ["a"]),
            (["d"], [], [], ["d"]),
        ],
    )
    def test_controllers_are_chosen_that_move_all_joints(self, joints, named, expected, left):
        forward = Controller("forward", ("d",))
        chosen, unmoved = choose_controllers(joints, [ARM, WRIST, BOTH, forward], named)
        assert ([one.name for one in chosen], unmoved) == (expected, left)

    def test_a_default_controller_is_preferred(self):
        preferred = Controller("own", ("a", "b"), "own/follow_joint_trajectory", is_default=True)
        chosen, _ = choose_controllers(["a", "b"], [ARM, BOTH, preferred])
        assert [one.name for one in chosen] == ["own"]

    def test_a_goal_has_the_controller_s_joints_in_its_order_and_others_stay(self):
        goal = goal_for(BOTH, trajectory(["b", "a"], (1.0, 2.0), (3.0, 4.0)), {"c": 0.5})
        assert list(goal.trajectory.joint_names) == ["a", "b", "c"]
        assert [list(point.positions) for point in goal.trajectory.points] == [
            [2.0, 1.0, 0.5],
            [4.0, 3.0, 0.5],
        ]
        assert list(goal.trajectory.points[0].velocities) == [1.0, 1.0, 0.0]

    def test_a_gripper_is_sent_the_last_position_of_its_joint(self):
        hand = Controller("hand", ("f", "g"), "hand/gripper_cmd", ActionKind.GRIPPER, max_effort=5)
        goal = goal_for(hand, trajectory(["g", "f"], (0.0, 0.0), (0.1, 0.2)), {})
        assert goal.command.position == pytest.approx(0.2)
        assert goal.command.max_effort == 5.0
        claw = Controller("claw", ("g",), "claw/gripper_cmd", ActionKind.PARALLEL_GRIPPER)
        goal = goal_for(claw, trajectory(["g"], (0.0,), (0.1,)), {})
        assert (list(goal.command.name), list(goal.command.position)) == (["g"], [0.1])
