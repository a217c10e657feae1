"""Which controllers execute a trajectory, and what each is sent."""

import pytest

from teleopctl.interfaces import get_message
from teleopctl.nodes.moveit.move_group.controllers import (
    GRIPPER,
    PARALLEL_GRIPPER,
    TRAJECTORY,
    Controller,
    active_controllers,
    choose_controllers,
    goal_for,
)

ControllerState = get_message("controller_manager_msgs/msg/ControllerState")
JointTrajectory = get_message("trajectory_msgs/msg/JointTrajectory")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")


def state(name, kind, joints, state="active"):
    claimed = [f"{joint}/position" for joint in joints]
    return ControllerState(name=name, type=kind, state=state, claimed_interfaces=claimed)


ARM = Controller("arm", "arm/follow_joint_trajectory", TRAJECTORY, ("a", "b"))
WRIST = Controller("wrist", "wrist/follow_joint_trajectory", TRAJECTORY, ("c",))
BOTH = Controller("both", "both/follow_joint_trajectory", TRAJECTORY, ("a", "b", "c"))


def trajectory(names, *positions):
    points = [Point(positions=list(each), velocities=[1.0] * len(names)) for each in positions]
    return JointTrajectory(joint_names=names, points=points)


def test_active_controllers_with_an_action_are_found_with_their_joints():
    found = list(
        active_controllers(
            [
                state("arm", "joint_trajectory_controller/JointTrajectoryController", ["a", "b"]),
                state("hand", "position_controllers/GripperActionController", ["f"]),
                state("claw", "parallel_gripper_action_controller/GripperActionController", ["g"]),
                state(
                    "off",
                    "joint_trajectory_controller/JointTrajectoryController",
                    ["c"],
                    "inactive",
                ),
                state("jsb", "joint_state_broadcaster/JointStateBroadcaster", []),
                state("forward", "forward_command_controller/ForwardCommandController", ["d"]),
            ],
            "/left",
        )
    )
    assert [(one.name, one.action, one.type, one.joints) for one in found] == [
        ("arm", "/left/arm/follow_joint_trajectory", TRAJECTORY, ("a", "b")),
        ("hand", "/left/hand/gripper_cmd", GRIPPER, ("f",)),
        ("claw", "/left/claw/gripper_cmd", PARALLEL_GRIPPER, ("g",)),
    ]


@pytest.mark.parametrize(
    ("joints", "named", "expected", "left"),
    [
        (["a", "b"], [], ["both"], []),
        (["a", "b"], ["arm"], ["arm"], []),
        (["a", "c"], ["arm", "wrist"], ["arm", "wrist"], []),
        (["a", "x"], ["arm"], ["arm"], ["x"]),
        (["a"], ["none"], [], ["a"]),
    ],
)
def test_controllers_are_chosen_that_move_all_joints(joints, named, expected, left):
    chosen, unmoved = choose_controllers(joints, [ARM, WRIST, BOTH], named)
    if not named:
        # One of the two that move both; which one does not matter.
        assert len(chosen) == 1
    else:
        assert [one.name for one in chosen] == expected
    assert unmoved == left


def test_a_default_controller_is_preferred():
    preferred = Controller("own", "own/follow_joint_trajectory", TRAJECTORY, ("a", "b"), True)
    chosen, _ = choose_controllers(["a", "b"], [ARM, BOTH, preferred])
    assert [one.name for one in chosen] == ["own"]


def test_a_goal_has_the_controller_s_joints_in_its_order_and_others_stay():
    goal = goal_for(BOTH, trajectory(["b", "a"], (1.0, 2.0), (3.0, 4.0)), {"c": 0.5})
    assert list(goal.trajectory.joint_names) == ["a", "b", "c"]
    assert [list(point.positions) for point in goal.trajectory.points] == [
        [2.0, 1.0, 0.5],
        [4.0, 3.0, 0.5],
    ]
    assert list(goal.trajectory.points[0].velocities) == [1.0, 1.0, 0.0]


def test_a_gripper_is_sent_the_last_position_of_its_joint():
    hand = Controller("hand", "hand/gripper_cmd", GRIPPER, ("f", "g"), max_effort=5.0)
    goal = goal_for(hand, trajectory(["g", "f"], (0.0, 0.0), (0.1, 0.2)), {})
    assert goal.command.position == pytest.approx(0.2)
    assert goal.command.max_effort == 5.0
    claw = Controller("claw", "claw/gripper_cmd", PARALLEL_GRIPPER, ("g",))
    goal = goal_for(claw, trajectory(["g"], (0.0,), (0.1,)), {})
    assert (list(goal.command.name), list(goal.command.position)) == (["g"], [0.1])
