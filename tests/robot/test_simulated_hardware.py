"""The simulator as the hardware of any robot."""

import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import (
    RobotDescription,
    default_controllers,
    simulated,
    with_ros2_control_of,
)

SIMULATOR = "gz_ros2_control/GazeboSimSystem"
LIMIT = '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'


def arm(*control: str, joints: str = "a:revolute b:revolute") -> str:
    kinds = [joint.split(":") for joint in joints.split()]
    parts = [
        f'<link name="of_{name}"/><joint name="{name}" type="{kind}"><parent link="base"/>'
        f'<child link="of_{name}"/>{LIMIT}</joint>'
        for name, kind in kinds
    ]
    return f'<robot name="arm"><link name="base"/>{"".join(parts)}{"".join(control)}</robot>'


def system(name: str, plugin: str, *joints: str, command: str = "position") -> str:
    inside = "".join(
        f'<joint name="{joint}"><command_interface name="{command}"/>'
        '<state_interface name="position"/></joint>'
        for joint in joints
    )
    return (
        f'<ros2_control name="{name}" type="system"><hardware><plugin>{plugin}</plugin>'
        f'<param name="port">/dev/ttyUSB0</param></hardware>{inside}</ros2_control>'
    )


def commands(description: RobotDescription) -> dict[str, list[str]]:
    return {
        joint.name: [interface.name for interface in joint.command_interfaces]
        for part in description.ros2_control
        for joint in part.joints
    }


def test_a_description_for_a_simulator_stays_letter_for_letter():
    urdf = arm(system("S", "gz_ros2_control/GazeboSimSystem", "a", "b"))
    assert simulated(urdf) == (urdf, ())


def test_whatever_hardware_a_system_has_it_becomes_the_simulator_and_that_is_said():
    urdf, remarks = simulated(arm(system("Real", "vendor/Driver", "a", "b")))
    (part,) = RobotDescription.from_urdf(urdf).ros2_control
    assert (part.name, part.hardware_plugin_name) == ("Real", SIMULATOR)
    assert part.hardware_parameters == {}  # a port of the real one
    assert remarks == ("The simulator is the hardware of 'Real' (vendor/Driver, without its port)",)


def test_an_mjcf_file_of_mujoco_ros2_control_is_named_since_the_urdf_is_simulated():
    tag = system("Sim", "mujoco_ros2_control/MujocoSystemInterface", "a", "b")
    tag = tag.replace('name="port">/dev/ttyUSB0', 'name="mujoco_model">/robots/scene.xml')
    assert simulated(arm(tag)).remarks == (
        "The physics of 'Sim' is that of this description, not of its mujoco_model: "
        "model:=/robots/scene.xml simulates that file",
    )


def test_of_several_systems_each_keeps_its_name_and_its_joints():
    mock = system("Hand", "mock_components/GenericSystem", "b")
    urdf, remarks = simulated(
        arm(system("Arm", "vendor/Arm", "a"), mock.replace('type="system"', 'type="actuator"'))
    )
    description = RobotDescription.from_urdf(urdf)
    assert [(part.name, part.type) for part in description.ros2_control] == [
        ("Arm", "system"), ("Hand", "system"),
    ]  # fmt: skip
    assert {part.hardware_plugin_name for part in description.ros2_control} == {SIMULATOR}
    assert commands(description) == {"a": ["position"], "b": ["position"]}
    assert remarks == (
        "The simulator is the hardware of 'Arm' (vendor/Arm, without its port), "
        "'Hand' (mock_components/GenericSystem, without its port)",
    )


def test_gazebos_commands_with_pid_are_plain_ones():
    one = system("S", SIMULATOR, "a", command="velocity_pid")
    urdf, remarks = simulated(arm(one, joints="a:revolute"))
    assert commands(RobotDescription.from_urdf(urdf)) == {"a": ["velocity"]}
    assert remarks == (
        "Without '_pid', since the simulator's drives follow exactly: a/velocity_pid",
    )


def test_of_joints_that_no_system_has_the_states_are_told_so_that_their_links_have_frames():
    urdf, remarks = simulated(arm(system("S", SIMULATOR, "a"), joints="a:revolute drop:prismatic"))
    own, others = RobotDescription.from_urdf(urdf).ros2_control
    assert [joint.name for joint in own.joints] == ["a"]
    (drop,) = others.joints
    assert (drop.name, drop.command_interfaces) == ("drop", ())
    assert [state.name for state in drop.state_interfaces] == ["position", "velocity"]
    assert (others.hardware_plugin_name, remarks) == (SIMULATOR, ())


def test_without_any_system_joints_are_held_those_that_go_round_turned_and_followers_follow():
    follower = (
        '<link name="of_f"/><joint name="f" type="revolute"><parent link="base"/>'
        f'<child link="of_f"/><mimic joint="a"/>{LIMIT}</joint>'
    )
    urdf, remarks = simulated(arm(follower, joints="a:revolute wheel:continuous rail:prismatic"))
    description = RobotDescription.from_urdf(urdf)
    held = {"a": ["position"], "wheel": ["velocity"], "rail": ["position"], "f": []}
    assert commands(description) == held
    assert remarks == (
        "No <ros2_control> in the description; "
        "commanded are position of a, rail and velocity of wheel",
    )
    parameters = default_controllers(description)
    manager = parameters["controller_manager"]["ros__parameters"]
    assert [name for name in manager if name != "update_rate"] == [
        "joint_state_broadcaster", "joint_trajectory_controller", "velocity_controller",
    ]  # fmt: skip
    trajectory = parameters["joint_trajectory_controller"]["ros__parameters"]
    assert trajectory["joints"] == ["a", "rail"]
    assert parameters["velocity_controller"]["ros__parameters"] == {"joints": ["wheel"]}


def test_a_robot_that_cannot_move_has_nothing_to_control():
    urdf = '<robot name="stone"><link name="base"/></robot>'
    assert simulated(urdf) == (urdf, ())


def test_what_is_no_robot_is_refused():
    with pytest.raises(InvalidDescriptionError):
        simulated("<robot")


def test_a_model_from_sdf_gets_the_ros2_control_of_the_published_description() -> None:
    model = '<robot name="arm"><link name="base"/></robot>'
    system = '<ros2_control name="all" type="system"><hardware><plugin>x/Y</plugin></hardware>'
    published = f'<robot name="other"><link name="l"/>{system}</ros2_control></robot>'
    both = RobotDescription.from_urdf(with_ros2_control_of(model, published))
    assert [one.name for one in both.ros2_control] == ["all"]
    assert list(both.links) == ["base"]
