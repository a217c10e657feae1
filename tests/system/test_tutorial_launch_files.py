"""The launch files that the tutorial has: Gazebo, controllers and display, by ROS 2's names."""

import pytest

from teleopctl.interfaces import get_message

JointState = get_message("sensor_msgs/msg/JointState")

ACTIVE = ("arm_controller", "gripper_controller", "joint_state_broadcaster")
POINT = "{positions: [0.4, 0.2, -0.3], time_from_start: {nanosec: 500000000}}"
TRAJECTORY = f"{{joint_names: [joint_1, joint_2, joint_3], points: [{POINT}]}}"


@pytest.mark.nightly
def test_the_arm_comes_up_in_gazebos_launch_file_and_moves_by_the_controllers_of_another(ros):
    gazebo = ros.spawn("launch teleop_description gazebo.launch.py")
    gazebo.wait_for_line(r"Spawn status: SpawnEntity: Successfully spawned entity \[teleop\]")
    ros.run("launch teleop_controller controller.launch.py", timeout=60)

    listed = ros.run("control list_controllers").stdout.splitlines()
    states = {line.split()[0]: line.split()[-1] for line in listed}
    assert states == dict.fromkeys(ACTIVE, "active")
    ros.run(
        f"topic pub --once /arm_controller/joint_trajectory "
        f"trajectory_msgs/msg/JointTrajectory '{TRAJECTORY}'"
    )
    ros.wait_for_message(
        JointState,
        "/joint_states",
        lambda m: m.position[:3] == pytest.approx([0.4, 0.2, -0.3], abs=0.01),
    )
    gazebo.interrupt()
    gazebo.wait()
    assert ros.run("node list").stdout == "/test\n"  # the one that this test listens with


def test_the_arm_is_shown_by_the_display_launch_file(ros):
    shown = ros.run("launch --print teleop_description display.launch.py").stdout
    programs = [line.rstrip(":") for line in shown.splitlines() if line.endswith(":")]
    assert [name for name in programs if name[-1:].isdigit()] == [
        "robot_state_publisher-1",
        "joint_state_publisher_gui-2",
        "rviz2-3",
    ]
