"""``<ros2_control>``: its grammar, its errors, mimic joints and limits."""

import math
from typing import Any

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joint_rules import UNLIMITED, JointLimits, SoftLimits
from teleopctl.robot.ros2_control_tag import AsyncThread
from teleopctl.robot.urdf import Mimic

PLUGIN = "<hardware><plugin>p/P</plugin></hardware>"
POSITION = '<command_interface name="position"/><state_interface name="position"/>'


def description(control, *, mimic="", limits='lower="-2" upper="2" effort="5" velocity="3"'):
    """A robot with the joints a and b (revolute), c (continuous) and f (fixed)."""
    links = "".join(f'<link name="l{n}"/>' for n in range(5))
    joints = ""
    for n, (name, kind, inside) in enumerate(
        (
            ("a", "revolute", f"<limit {limits}/>"),
            ("b", "revolute", f"<limit {limits}/>{mimic}"),
            ("c", "continuous", ""),
            ("f", "fixed", ""),
        )
    ):
        joints += (
            f'<joint name="{name}" type="{kind}"><parent link="l{n}"/><child link="l{n + 1}"/>'
            f"{inside}</joint>"
        )
    return RobotDescription.from_urdf(f'<robot name="r">{links}{joints}{control}</robot>')


def component(body, attributes='name="S" type="system"', **options):
    control = f"<ros2_control {attributes}>{PLUGIN}{body}</ros2_control>"
    return description(control, **options).ros2_control[0]


def failure(body="", attributes='name="S" type="system"', **options):
    with pytest.raises(TeleopctlError) as caught:
        component(body, attributes, **options)
    return caught.value.message


def joint(name, inside=POSITION, attributes=""):
    return f'<joint name="{name}" {attributes}>{inside}</joint>'


def test_everything_that_stands_in_the_tag_is_read():
    found = component(
        joint(
            "a",
            '<command_interface name="position" data_type="float32">'
            '<param name="min">-1</param><param name="max"> 1 </param><param name="gain">7</param>'
            '</command_interface><state_interface name="position" size="3">'
            '<param name="initial_value">0.5</param></state_interface>'
            '<param name="id">11</param>',
        )
        + '<sensor name="imu"><state_interface name="orientation.x"/></sensor>'
        + '<gpio name="io"><command_interface name="out" data_type="bool"/>'
        '<state_interface name="in" data_type="complex"/></gpio>'
        + '<transmission name="t"><plugin>t/T</plugin><actuator name="m" role="actuator1"/>'
        '<joint name="a" role="joint1" read_only="TRUE">'
        "<mechanical_reduction>50</mechanical_reduction>"
        '<offset>0.1</offset></joint><param name="k">v</param></transmission>',
        'name="S" type="system" rw_rate="50" is_async="true" thread_priority="30" unknown="x"',
    )
    assert (found.rw_rate, found.is_async, found.async_thread.priority) == (50, True, 30)
    (moved,) = found.joints
    command, state = moved.command_interfaces[0], moved.state_interfaces[0]
    assert (command.data_type, command.min, command.max) == ("float32", "-1", "1")
    assert command.parameters["gain"] == "7"
    assert (state.size, state.initial_value) == (3, 0.5)
    assert moved.parameters == {"id": "11"}
    assert found.sensors[0].state_interfaces[0].name == "orientation.x"
    assert found.gpios[0].command_interfaces[0].data_type == "bool"
    assert found.gpios[0].state_interfaces[0].data_type == "unknown"
    (transmission,) = found.transmissions
    assert transmission.joints[0].mechanical_reduction == 50
    assert transmission.joints[0].offset == 0.1
    assert transmission.joints[0].read_only
    assert transmission.parameters == {"k": "v"}


def test_several_components_are_kept_in_order():
    tags = "".join(
        f'<ros2_control name="{name}" type="system">{PLUGIN}</ros2_control>' for name in "zyx"
    )
    assert [found.name for found in description(tags).ros2_control] == ["z", "y", "x"]
    with pytest.raises(TeleopctlError, match="Component name 'z' is not unique"):
        _ = description(tags + tags).ros2_control


@pytest.mark.parametrize(
    ("body", "attributes", "message"),
    [
        ("<wheel/>", None, "invalid tag name 'wheel'"),
        ("", 'type="system"', "no attribute 'name' in 'ros2_control' tag"),
        ("", 'name="S"', "no attribute 'type' in 'ros2_control' tag with name 'S'"),
        ("", 'name="S" type="robot"', "Component 'S' is of unknown type 'robot'"),
        (
            joint("f"),
            None,
            "Joint 'f' is of type 'fixed'. Fixed joints do not make sense in ros2_control.",
        ),
        (
            joint("b", attributes='mimic="true"'),
            None,
            "Joint 'b' has no mimic information in the URDF",
        ),
        (joint("b", attributes='mimic="yes"'), None, "mimic of joint 'b' should be true or false"),
        (
            joint("a", '<state_interface name="position" size="0"/>'),
            None,
            'Could not parse size tag in "position". Got "0", but expected a non-zero positive '
            "integer.",
        ),
        (
            "",
            'name="S" type="system" rw_rate="-1"',
            'Could not parse rw_rate tag in "S". Got "-1", but expected an integer that is not '
            "negative.",
        ),
        ("", 'name="S" type="system" rw_rate="fast"', 'Could not parse rw_rate tag in "S"'),
        ("", 'name="S" type="system" rw_rate="99999999999"', "Could not parse rw_rate tag"),
        ("", 'name="S" type="system" is_async="true" thread_priority="0"', "thread_priority"),
        (
            '<properties><async scheduling_policy="fifo"/></properties>',
            'name="S" type="system" is_async="true"',
            "scheduling_policy of <async> in 'S' should be synchronized or detached, got 'fifo'",
        ),
        (
            '<properties><async affinity="[1, two]"/></properties>',
            'name="S" type="system" is_async="true"',
            "affinity of <async> in 'S' should be numbers of processors such as [2, 4]",
        ),
        (joint("a", "<limits/>"), None, "no attribute 'enable' in 'limits' tag"),
        (
            "<transmission name='t'><plugin>p</plugin><joint name='z' role='j'/></transmission>",
            None,
            "Transmission 't' declared joint 'z' is not available in component 'S'.",
        ),
        ("<transmission name='t'/>", None, "Missing <plugin> tag in transmission 't'"),
        (
            "<transmission name='t'><plugin>p</plugin></transmission>",
            'name="S" type="actuator"',
            "Transmission 't' has no <joint>",
        ),
    ],
)
def test_mistakes_are_named_in_ros2_controls_words(body, attributes, message):
    attributes = attributes or 'name="S" type="system"'
    assert message in failure(body, attributes)


def test_a_joint_that_the_robot_has_not_is_left_out_and_said():
    found = component(joint("fan") + joint("a"))
    assert [part.name for part in found.joints] == ["a"]
    assert found.warnings == (
        "Joint 'fan' of <ros2_control> is left out: the robot has none of that name, and ROS 2 "
        "refuses it since Jazzy",
    )


def test_hardware_without_plugin_is_refused():
    with pytest.raises(TeleopctlError) as caught:
        _ = description(
            '<ros2_control name="S" type="system"><hardware/></ros2_control>'
        ).ros2_control
    assert caught.value.message == (
        "Missing <plugin> tag of <hardware> element for 'S' in your URDF."
    )


def test_a_mimic_of_the_urdf_holds_in_control():
    found = component(
        joint("a") + joint("b", '<state_interface name="position"/>'),
        mimic='<mimic joint="a" multiplier="-2" offset="0.5"/>',
    )
    assert found.joints[1].mimic == Mimic("a", -2, 0.5)
    assert found.warnings == ()


def test_a_mimic_of_the_urdf_can_be_switched_off():
    found = component(
        joint("a") + joint("b", attributes='mimic="false"'), mimic='<mimic joint="a"/>'
    )
    assert found.joints[1].mimic is None
    assert found.joints[1].command_interfaces


def test_a_mimic_joint_needs_its_leader_in_the_tag():
    body = joint("b", '<state_interface name="position"/>')
    message = failure(body, mimic='<mimic joint="a"/>')
    assert message == "Mimic joint 'a' not found in <ros2_control> tag"


def test_a_mimic_joint_of_the_urdf_cannot_be_commanded():
    message = failure(joint("a") + joint("b"), mimic='<mimic joint="a"/>')
    assert message == (
        "Joint 'b' has mimic attribute not set to false: "
        "Activated mimic joints cannot have command interfaces."
    )


PARAMETERS = '<param name="mimic">a</param><param name="multiplier">-1</param>'


def test_a_mimic_by_parameters_is_understood_and_its_commands_are_dropped():
    found = component(joint("a") + joint("b", POSITION + PARAMETERS))
    follower = found.joints[1]
    assert follower.mimic == Mimic("a", -1)
    assert follower.command_interfaces == ()
    assert [i.name for i in follower.state_interfaces] == ["position"]
    replacement, dropped = found.warnings
    assert '<mimic joint="a" multiplier="-1"/>' in replacement
    assert "b/position" in dropped


def test_the_urdf_wins_over_parameters():
    found = component(
        joint("a") + joint("b", POSITION + PARAMETERS), mimic='<mimic joint="a" multiplier="3"/>'
    )
    assert found.joints[1].mimic == Mimic("a", 3)
    assert found.joints[1].command_interfaces == ()


def test_the_thread_of_an_asynchronous_component_is_scheduled_as_written():
    tag = (
        '<properties><async affinity="[2,4]" scheduling_policy="detached" print_warnings="false" '
        'thread_priority="30"/></properties>'
    )
    found = component(tag, 'name="S" type="system" is_async="true" thread_priority="7"')
    assert found.async_thread == AsyncThread(30, (2, 4), is_detached=True, print_warnings=False)
    assert component("", 'name="S" type="system" is_async="true"').async_thread == AsyncThread()


def test_the_transmission_of_an_actuator_component_has_one_actuator():
    tag = '<transmission name="t"><plugin>p</plugin><joint name="a" role="joint1"/></transmission>'
    found = component(joint("a") + tag, 'name="S" type="actuator"')
    assert [end.name for end in found.transmissions[0].actuators] == ["actuator1"]


SWITCHED_OFF = '<limits enable="false"/>'


def limits(inside, name="a", **options):
    found = component(joint(name, inside), **options)
    return found.joints[0].limits, found.warnings


def interface(name, low=None, high=None, more=""):
    low = "" if low is None else f'<param name="min">{low}</param>'
    high = "" if high is None else f'<param name="max">{high}</param>'
    return f'<command_interface name="{name}">{low}{high}{more}</command_interface>'


def safety(lower, upper):
    return (
        f'<safety_controller soft_lower_limit="{lower}" soft_upper_limit="{upper}" k_velocity="1"/>'
    )


SPEED: dict[str, Any] = {"top_speed": 3}
STOPS: dict[str, Any] = {"stops": (-2, 2), **SPEED}


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ("", JointLimits(-2, 2, 3, 5, **STOPS)),
        (interface("position", -1, 5), JointLimits(-1, 2, 3, 5, **STOPS)),
        (interface("position", high=1), JointLimits(-2, 1, 3, 5, **STOPS)),
        (interface("velocity", -2, 4), JointLimits(-2, 2, 2, 5, **STOPS)),
        (interface("velocity", -9, 9), JointLimits(-2, 2, 3, 5, **STOPS)),
        (interface("velocity", 0, 0), JointLimits(-2, 2, 3, 5, **STOPS)),
        (interface("effort", -1, 4), JointLimits(-2, 2, 3, 1, **STOPS)),
        (interface("acceleration", -3, 2), JointLimits(-2, 2, 3, 5, 2, 3, **STOPS)),
        (interface("acceleration", high=2), JointLimits(-2, 2, 3, 5, 2, 2, **STOPS)),
        (interface("acceleration", low=-3), JointLimits(-2, 2, 3, 5, 3, 3, **STOPS)),
        (interface("jerk", -1, 8), JointLimits(-2, 2, 3, 5, jerk=8, **STOPS)),
        (SWITCHED_OFF + interface("position", -1, 1), UNLIMITED),
        (interface("position", -1, 1, SWITCHED_OFF), JointLimits(velocity=3, effort=5, **SPEED)),
        (
            interface("velocity", -1, 1, SWITCHED_OFF),
            JointLimits(-2, 2, effort=5, stops=(-2, 2)),
        ),
    ],
)
def test_the_most_restrictive_limit_wins(inside, expected):
    assert limits(inside) == (expected, ())


@pytest.mark.parametrize(
    ("soft", "inside", "quantity", "expected"),
    [
        ("", "", "velocity", "limit"),
        ("", interface("velocity", -2, 2), "velocity", "command_interface"),
        ("", interface("velocity", -9, 9), "velocity", "limit"),
        ("", interface("velocity", -2, 2), "position", "limit"),
        ("", interface("position", -1, 5), "position", "command_interface"),
        (safety(-1, 1), "", "position", "safety_controller"),
        (safety(-1, 1), interface("position", -0.5, 0.5), "position", "command_interface"),
    ],
)
def test_a_limit_has_the_line_of_what_makes_it_narrow(soft, inside, quantity, expected):
    text = (
        '<robot name="r"><link name="base"/><link name="tip"/><joint name="a" type="revolute">\n'
        '<parent link="base"/><child link="tip"/>\n'
        f'{soft}\n<limit lower="-2" upper="2" velocity="3" effort="5"/></joint>\n'
        '<ros2_control name="h" type="system"><hardware><plugin>p</plugin></hardware>'
        f'<joint name="a">\n{inside}</joint></ros2_control></robot>'
    )
    (component,) = RobotDescription.from_urdf(text).ros2_control
    limits = component.joints[0].limits
    line = limits.lines.get(quantity, limits.line)
    assert f"<{expected}" in text.splitlines()[line - 1]


@pytest.mark.parametrize(
    ("k_position", "lower", "upper", "inside", "expected"),
    [
        (7, -1, 1, "", SoftLimits(-1, 1, 7, 2, (-2, 2))),
        (7, -9, 1, interface("position", -1.5, 3), SoftLimits(-1.5, 1, 7, 2, (-1.5, 2))),
        (0, 0, 0, "", SoftLimits(-math.inf, math.inf, 0, 2, (-2, 2))),
        (7, 5, 9, "", SoftLimits(-math.inf, math.inf, 7, 2, (-2, 2))),
    ],
)
def test_soft_limits_keep_their_gains_and_the_limits_around_them(
    k_position, lower, upper, inside, expected
):
    tag = (
        f'<safety_controller soft_lower_limit="{lower}" soft_upper_limit="{upper}" '
        f'k_position="{k_position}" k_velocity="2"/>'
    )
    found = component(joint("a") + joint("b", inside), mimic=tag).joints[1].limits
    assert found.soft == expected
    assert (found.lower, found.upper) == (
        max(expected.lower, expected.hard[0]),
        min(expected.upper, expected.hard[1]),
    )
    assert found.mechanical.soft is None


def test_negative_gains_of_soft_limits_are_reported_and_ignored():
    tag = (
        '<safety_controller soft_lower_limit="-1" soft_upper_limit="1" k_position="-7" '
        'k_velocity="-2"/>'
    )
    found = component(joint("a") + joint("b"), mimic=tag)
    assert found.joints[1].limits.soft == SoftLimits(-1, 1, 0, 0, (-2, 2))
    assert [text.split(" is ignored")[0] for text in found.warnings] == [
        "Joint 'b': k_position -7",
        "Joint 'b': k_velocity -2",
    ]


def test_a_continuous_joint_has_only_the_limits_of_its_interfaces():
    assert limits("", "c")[0] == UNLIMITED
    found, _ = limits(interface("position", -7, 7), "c")
    assert found == JointLimits(-7, 7)


def test_limits_that_cannot_be_used_are_reported_and_skipped():
    found, warnings = limits(interface("position", "low", 1) + interface("torque", 0, 1))
    assert (found.lower, found.upper) == (-2, 1)
    assert "got 'low'" in warnings[0]
    assert "'a/torque' are ignored" in warnings[1]


def test_limits_that_leave_no_position_are_reported_and_skipped():
    found, (warning,) = limits(interface("position", 3, 4))
    assert (found.lower, found.upper) == (-2, 2)
    assert "'a/position'" in warning


@pytest.mark.parametrize(
    ("soft", "expected"), [((-9, 1.5), (-2, 1.5)), ((0, 0), (-2, 2)), ((5, 6), (-2, 2))]
)
def test_soft_limits_lie_within_the_hard_ones_or_are_not_used(soft, expected):
    found = component(joint("a") + joint("b"), mimic=safety(*soft)).joints[1].limits
    assert (found.lower, found.upper) == expected
    assert found.stops == (-2, 2)


def test_limits_of_zero_limit_nothing():
    nothing = 'lower="0" upper="0" effort="0" velocity="0"'
    assert component(joint("a"), limits=nothing).joints[0].limits == UNLIMITED


def test_a_chain_of_mimics_is_followed_to_the_joint_that_moves_on_its_own():
    parameters = '<param name="mimic">b</param><param name="multiplier">3</param>'
    found = component(
        joint("c", parameters) + joint("b", "") + joint("a"),
        mimic='<mimic joint="a" multiplier="-2" offset="0.5"/>',
    )
    assert found.joints[0].leaders == (Mimic("b", 3), Mimic("a", -6, 1.5))
    assert found.joints[0].mimic == Mimic("a", -6, 1.5)


def test_joints_that_mimic_each_other_are_refused():
    follow_b = '<param name="mimic">b</param>'
    message = failure(joint("a", follow_b) + joint("b", ""), mimic='<mimic joint="a"/>')
    assert message.startswith("Joint 'a' mimics itself")
