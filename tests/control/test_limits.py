"""Commands outside a joint's limits are clamped, and reported once."""

import math

import pytest
from hypothesis import given, strategies as st

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.limits import command_ranges, limits_text, make_limiter
from teleopctl.interfaces import get_message
from teleopctl.robot.joint_rules import JointLimits, SoftLimits
from teleopctl.testing import ControlStack, serial_robot

PERIOD = 0.01


class Joint:
    def __init__(self, limits, *interfaces):
        self.reports: list[str] = []
        self.command = {name: CommandInterface("joint", name) for name in interfaces}
        self.state = {
            name: StateInterface("joint", name, initial_value=0.0)
            for name in ("position", "velocity")
        }
        for command in self.command.values():
            command.owner = "somebody"
        limiter = make_limiter("joint", limits, self.command, self.state, self.reports.append)
        assert limiter is not None
        self.limiter = limiter

    def limit(self, interface, value, period=PERIOD):
        self.command[interface].value = value
        self.limiter.enforce(period)
        return self.command[interface].value


def test_a_position_is_clamped_into_its_limits():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    assert joint.limit("position", 5.0) == 1.0
    assert joint.limit("position", -5.0) == -1.0
    assert joint.limit("position", 0.5) == 0.5


def test_a_position_moves_no_faster_than_the_velocity_limit_from_the_last_command():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=10.0), "position")
    assert joint.limit("position", 1.0) == pytest.approx(0.1)
    assert joint.limit("position", 1.0) == pytest.approx(0.2)


def test_it_is_reported_once_with_joint_value_and_limits():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    for _ in range(5):
        joint.limit("position", 5.0)
    (report,) = joint.reports
    assert "'joint'" in report
    assert "position 5 is clamped to 1" in report
    assert "[-1, 1]" in report
    joint.limit("position", 0.0)
    joint.limit("position", 5.0)
    assert len(joint.reports) == 1
    joint.limiter.reset("position")
    joint.limit("position", 5.0)
    assert len(joint.reports) == 2, "another controller takes the joint over"


@pytest.mark.parametrize(
    ("limits", "interface", "asked", "told"),
    [
        (JointLimits(velocity=1.0, line=7), "velocity", 6.0, "6 is clamped to 1 (velocity limit 1"),
        (JointLimits(-1.0, 1.0, line=7), "position", 2.0, "2 is clamped to 1 (position limits"),
        (
            JointLimits(-1.0, 1.0, velocity=10.0, line=9, lines={"velocity": 7}),
            "position",
            0.5,
            "position 0.5 is clamped to 0.1 (velocity limit 10",
        ),
        (JointLimits(effort=3.0, line=7), "effort", -5.0, "-5 is clamped to -3 (effort limit 3"),
    ],
)
def test_a_report_names_both_numbers_and_the_line_of_the_limit(limits, interface, asked, told):
    joint = Joint(limits, interface)
    joint.limit(interface, asked)
    (report,) = joint.reports
    assert report.startswith(f"Command of joint 'joint' is outside its limits: {interface} ")
    assert told in report
    assert report.endswith(", line 7 of the robot description)")


@pytest.mark.parametrize(
    ("distribution", "enforced"),
    [("", False), ("humble", False), ("jazzy", False), ("kilted", True), ("rolling", True)],
)
def test_the_distribution_decides_whether_limits_are_enforced(distribution, enforced, monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", distribution)
    stack = ControlStack(serial_robot(limits='lower="-1" upper="1" effort="1" velocity="999"'))
    command = stack.resources.command_interfaces["joint1/position"]
    command.owner, command.value = "somebody", 3.0
    stack.step()
    assert command.value == (1.0 if enforced else 3.0)
    said = "enabled..." if enforced else "disabled. Command limits from URDF will be ignored."
    assert f"Enforcing command limits is {said}" in stack.log.texts("info")


def test_no_command_stays_no_command():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "position", "velocity")
    assert math.isnan(joint.limit("position", math.nan))
    assert math.isnan(joint.limit("velocity", math.nan))
    assert not joint.reports


def test_interfaces_that_nobody_owns_are_left_alone():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    joint.command["position"].owner = None
    assert joint.limit("position", 5.0) == 5.0


def test_a_velocity_is_clamped_and_stops_at_the_position_limit():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "velocity")
    assert joint.limit("velocity", 2.0) == 1.0
    joint.state["position"].value = 0.995
    assert joint.limit("velocity", 1.0) == pytest.approx(0.5)
    joint.state["position"].value = 1.01
    assert joint.limit("velocity", 1.0) == 0.0
    assert joint.limit("velocity", -1.0) == 0.0


def test_a_velocity_changes_no_faster_than_the_acceleration_limit():
    limits = JointLimits(velocity=10.0, acceleration=5.0, deceleration=5.0)
    joint = Joint(limits, "velocity")
    joint.limit("velocity", 0.0)
    assert joint.limit("velocity", 10.0) == pytest.approx(0.05)


def test_an_effort_does_not_push_outwards_at_a_position_limit():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, effort=3.0, velocity=1.0), "effort")
    assert joint.limit("effort", 5.0) == 3.0
    joint.state["position"].value = 1.0
    assert joint.limit("effort", 5.0) == 0.0
    assert joint.limit("effort", -5.0) == -3.0
    joint.state["position"].value = 0.0
    joint.state["velocity"].value = 2.0
    assert joint.limit("effort", 5.0) == 0.0


@pytest.mark.parametrize(
    ("start", "wanted", "sign"), [(1.5, 0.0, 1), (1.5, 9.0, 1), (-1.5, 0.0, -1)]
)
def test_a_joint_outside_its_limits_moves_back_at_its_velocity_limit(start, wanted, sign):
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "position")
    joint.state["position"].value = start
    assert joint.limit("position", wanted) == pytest.approx(sign * 1.49)
    assert joint.limit("position", wanted) == pytest.approx(sign * 1.48)
    said = [report for report in joint.reports if report.startswith("Joint position is out of")]
    assert said == [
        f"Joint position is out of bounds for the joint : 'joint' actual position: {start} "
        "limits: [-1, 1]. Position commands are clamped to the limits; recheck the URDF's limits."
    ]


def test_a_joint_outside_its_limits_gets_no_velocity_and_is_named_once():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "velocity")
    joint.state["position"].value = 1.3
    assert joint.limit("velocity", -0.5) == joint.limit("velocity", 0.5) == 0.0
    assert [text for text in joint.reports if "will be restricted to zero" in text] == [
        "Joint position is out of bounds for the joint : 'joint' actual position: 1.3 limits: "
        "[-1, 1]. Joint velocity limits will be restricted to zero."
    ]


def test_the_first_velocity_command_starts_from_the_measured_speed():
    joint = Joint(JointLimits(velocity=10.0, acceleration=5.0, deceleration=5.0), "velocity")
    joint.state["velocity"].value = 2.0
    assert joint.limit("velocity", 0.0) == pytest.approx(1.95)
    assert joint.limit("velocity", 0.0) == pytest.approx(1.90)


def test_an_effort_may_brake_a_joint_at_its_limit():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, effort=3.0), "effort")
    for position, velocity, wanted, limited in (
        (1.0, -0.2, 5.0, 3.0),
        (1.0, 0.2, 5.0, 0.0),
        (1.0, 0.0, -5.0, -3.0),
        (-1.0, 0.2, -5.0, -3.0),
        (-1.0, -0.2, -5.0, 0.0),
        (-1.2, math.nan, -5.0, 0.0),
    ):
        joint.state["position"].value, joint.state["velocity"].value = position, velocity
        assert joint.limit("effort", wanted) == limited


def test_accelerations_against_the_motion_have_the_limit_of_decelerations():
    joint = Joint(JointLimits(acceleration=2.0, deceleration=5.0), "acceleration")
    for velocity, wanted, limited in ((1.0, -9, -5), (1.0, 9, 2), (-1.0, 9, 5), (0.0, 9, 2)):
        joint.state["velocity"].value = velocity
        assert joint.limit("acceleration", float(wanted)) == limited


def test_jerks_are_limited_on_both_sides():
    joint = Joint(JointLimits(jerk=1.5), "jerk")
    for wanted, limited in ((7.0, 1.5), (-7.0, -1.5), (0.5, 0.5)):
        assert joint.limit("jerk", wanted) == limited


def test_a_command_is_marked_as_limited_until_it_is_not():
    joint = Joint(JointLimits(velocity=1.0), "velocity")
    marks = []
    for wanted in (0.5, 2.0, 2.0, 0.5):
        joint.limit("velocity", wanted)
        marks.append(joint.command["velocity"].is_limited)
    assert marks == [False, True, True, False]


def test_a_cycle_without_a_period_limits_nothing():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    assert joint.limit("position", 5.0, 0.0) == 5.0


def soft(lower, upper, k_position=0.0, k_velocity=0.0, *, hard=5.0, **limits):
    """Return limits with soft limits within ``-hard`` and ``hard``, as joint_rules makes them."""
    safety = SoftLimits(lower, upper, k_position, k_velocity, (-hard, hard))
    return JointLimits(max(lower, -hard), min(upper, hard), soft=safety, **limits)


class TestSoftLimits:
    """The numbers are those of ros2_control's tests of its JointSoftLimiter; the period is 1 s."""

    @pytest.mark.parametrize(
        ("position", "wanted", "limited"),
        [
            *((3.0, 5.0, 1.0), (3.8, 5.0, 0.2), (3.5, 0.3, 0.3), (3.8, 0.5, 0.2)),
            *((4.0, 0.5, 0.0), (-2.0, -0.5, 0.0), (4.0, -0.5, -0.5), (-2.0, 3.0, 1.0)),
        ],
    )
    def test_k_position_slows_a_joint_down_towards_a_soft_limit(self, position, wanted, limited):
        joint = Joint(soft(-2.0, 4.0, 1.0, velocity=1.0), "velocity")
        joint.state["position"].value = position
        assert joint.limit("velocity", wanted, 1.0) == pytest.approx(limited)

    @pytest.mark.parametrize("wanted", [-3.0, -0.2, 0.6, 5.0])
    @pytest.mark.parametrize(("position", "sign"), [(4.8, -1), (4.3, -1), (5.0, -1), (-4.5, 1)])
    def test_a_joint_outside_its_soft_limits_returns_at_1_degree_per_second(
        self, position, sign, wanted
    ):
        joint = Joint(soft(-2.0, 4.0, 1.0, velocity=1.0), "velocity")
        joint.state["position"].value = position
        assert joint.limit("velocity", wanted, 1.0) == pytest.approx(sign * math.pi / 180)

    @pytest.mark.parametrize("position", [5.004, -5.004])
    def test_a_joint_outside_its_limits_gets_no_velocity(self, position):
        joint = Joint(soft(-2.0, 4.0, 1.0, velocity=1.0), "velocity")
        joint.state["position"].value = position
        assert joint.limit("velocity", -1.0, 1.0) == joint.limit("velocity", 1.0, 1.0) == 0.0

    def test_without_k_position_only_positions_stop_at_the_soft_limits(self):
        joint = Joint(soft(-0.75, 0.75, velocity=1.0), "position", "velocity")
        assert joint.limit("position", 2.0, 1.0) == 0.75
        assert joint.limit("position", -3.0, 1.0) == -0.25
        joint.state["position"].value = 4.5
        assert joint.limit("velocity", 5.0, 1.0) == 0.5

    def test_positions_approach_a_soft_limit_more_and_more_slowly(self):
        joint = Joint(soft(-1.5, 1.5, 0.5, velocity=1.0), "position")
        last = joint.limit("position", 0.2, 1.0)
        assert last == 0.2
        for _ in range(20):
            following = joint.limit("position", 2.0, 1.0)
            assert following == pytest.approx(last + 0.5 * (1.5 - last))
            last = following
        assert last == pytest.approx(1.5, abs=1e-5)

    def test_a_joint_far_outside_its_soft_limits_moves_back_at_its_velocity_limit(self):
        joint = Joint(soft(-0.75, 0.75, velocity=1.0), "position")
        joint.state["position"].value = 2.0
        assert joint.limit("position", 2.5) == pytest.approx(1.99)
        assert joint.limit("position", 0.0) == pytest.approx(1.98)

    @pytest.mark.parametrize(
        ("position", "velocity", "wanted", "limited"),
        [
            *((0.0, 0.5, 200.0, 150.0), (0.0, 0.5, -201.0, -200.0), (0.0, -0.5, -200.0, -150.0)),
            *((3.5, 0.4, 200.0, 30.0), (3.5, 0.5, 200.0, 0.0), (3.5, 0.4, -201.0, -200.0)),
            *((-3.5, -0.4, -200.0, -30.0), (-3.5, -0.4, 20.0, 20.0)),
        ],
    )
    def test_k_velocity_limits_efforts_near_a_velocity_limit(
        self, position, velocity, wanted, limited
    ):
        joint = Joint(soft(-4.0, 4.0, 1.0, 300.0, velocity=1.0, effort=200.0), "effort")
        joint.state["position"].value, joint.state["velocity"].value = position, velocity
        assert joint.limit("effort", wanted, 1.0) == pytest.approx(limited)

    def test_velocities_stay_near_the_measured_one_by_the_acceleration_limit(self):
        joint = Joint(soft(-4.0, 4.0, 1.0, velocity=9.0, acceleration=2.0), "velocity")
        assert [joint.limit("velocity", 5.0, 0.1) for _ in range(3)] == [0.2] * 3
        joint.state["velocity"].value = 0.2
        assert joint.limit("velocity", 5.0, 0.1) == pytest.approx(0.4)

    def test_a_k_velocity_of_zero_limits_nothing(self):
        joint = Joint(soft(-4.0, 4.0, 1.0, 0.0, velocity=1.0, effort=200.0), "effort")
        assert joint.limit("effort", 150.0) == 150.0

    @given(
        limits=st.builds(
            soft,
            *(st.floats(-4, 0), st.floats(0, 4), st.floats(0, 50), st.floats(0, 50)),
            velocity=st.floats(0.1, 9),
            effort=st.floats(1, 99),
            acceleration=st.floats(0.1, 9) | st.just(math.inf),
        ),
        measured=st.tuples(st.floats(-6, 6), st.floats(-9, 9)),
        wanted=st.lists(st.floats(-20, 20), min_size=1, max_size=5),
        interface=st.sampled_from(["position", "velocity", "effort"]),
    )
    def test_a_command_never_leaves_the_other_limits_and_no_band_is_empty(
        self, limits, measured, wanted, interface
    ):
        joint = Joint(limits, interface)
        joint.state["position"].value, joint.state["velocity"].value = measured
        previous = measured[0]
        for value in wanted:
            found = joint.limit(interface, value)
            if interface == "position":
                assert abs(found - previous) <= limits.velocity * PERIOD + 1e-9
                assert abs(found) <= max(5.0, abs(previous)) + 1e-9
                previous = found
            elif interface == "velocity":
                assert abs(found) <= limits.velocity + 1e-9
            else:
                assert abs(found) <= limits.effort


class TestLogLines:
    LIMITS = (
        '<limit lower="-1" upper="2" effort="3" velocity="0.5"/>'
        '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="9" k_position="20" '
        'k_velocity="7"/>'
    )

    def stack(self, *, safety=False, kind="revolute", control=""):
        text = serial_robot(1, initial=(0.0,), kind=kind)
        plain = '<limit lower="-100" upper="100" effort="1000" velocity="1000"/>'
        text = text.replace(plain, self.LIMITS if safety else self.LIMITS.split("<safety")[0])
        text = text.replace('<command_interface name="position"/>', f"{COMMAND}{control}")
        return ControlStack(text, enforce_limits=True)

    def test_of_a_joint_and_its_limiter(self):
        assert (
            "Using JointLimiter for joint 'joint1' in hardware 'Hardware' : 'has position limits: "
            "true [-1, 2], has velocity limits: true [0.5], has effort limits: true [3]'"
        ) in self.stack().log.texts("info")

    def test_of_a_joint_with_soft_limits(self):
        (line,) = (t for t in self.stack(safety=True).log.texts("info") if "SoftJointLimiter" in t)
        assert "soft position limits: [-0.5, 2], k-position: [20], k-velocity: [7]" in line
        assert "has position limits: true [-1, 2]" in line

    def test_of_a_joint_that_turns_without_end(self):
        (line,) = (t for t in self.stack(kind="continuous").log.texts("info") if "JointLim" in t)
        assert "has velocity limits: true [0.5]" in line
        assert line.endswith("angle wraparound: true'")
        assert "position" not in line

    def test_of_a_joint_whose_limits_are_disabled(self):
        stack = self.stack(control='<limits enable="false"/>')
        said = "Joint limits are disabled for joint 'joint1' in hardware 'Hardware'"
        assert said in stack.log.texts("info")


COMMAND = '<command_interface name="position"/>'


def test_soft_limits_of_a_description_slow_a_joint_down():
    limits = TestLogLines.LIMITS.replace('k_position="20"', 'k_position="5"')
    text = serial_robot(1, initial=(0.0,)).replace(
        '<limit lower="-100" upper="100" effort="1000" velocity="1000"/>', limits
    )
    stack = ControlStack(text, enforce_limits=True)
    stack.load_controller(
        "forward",
        "forward_command_controller/ForwardCommandController",
        {"joints": ["joint1"], "interface_name": "position"},
    )
    stack.activate("forward")
    message = get_message("std_msgs/msg/Float64MultiArray")(data=[-9.0])
    stack.nodes["forward"].receive("~/commands", message)
    stack.step(100)
    assert -0.499 < stack.command("joint1/position") < -0.4
    stack.step(400)
    assert stack.command("joint1/position") == pytest.approx(-0.5, abs=1e-3)


def test_the_limits_of_a_joint_are_told_on_one_line():
    limits = JointLimits(lower=-1.0, upper=2.0, velocity=0.5)
    text = "has position limits: true [-1, 2], has velocity limits: true [0.5]"
    assert limits_text(limits) == text
    assert limits_text(JointLimits()) == "no limits"


def test_a_joint_without_limits_costs_no_limiter():
    assert make_limiter("joint", JointLimits(), {}, {}, print) is None


def test_ranges_of_commands_by_interface():
    ranges = command_ranges(serial_robot(1, limits='lower="-1" upper="2" effort="5" velocity="3"'))
    assert ranges == {
        "joint1/position": (-1.0, 2.0),
        "joint1/velocity": (-3.0, 3.0),
        "joint1/effort": (-5.0, 5.0),
    }
