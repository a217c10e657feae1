"""The differential drive controller, on wheels that turn as they are told, 100 Hz."""

import math

import pytest

from teleopctl.control.controllers.mobile_base.odometry import Odometry
from teleopctl.control.controllers.mobile_base.rate_limiter import RateLimiter, RateLimits
from teleopctl.interfaces import get_message, set_stamp
from teleopctl.testing import ControlStack, serial_robot

TYPE = "diff_drive_controller/DiffDriveController"
RADIUS, SEPARATION = 0.1, 0.4
TwistStamped = get_message("geometry_msgs/msg/TwistStamped")
Twist = get_message("geometry_msgs/msg/Twist")

DYNAMICS = '<param name="calculate_dynamics">true</param>'


class Base:
    """A base with two wheels, ``joint1`` on the left; they have turned already."""

    def __init__(self, **parameters):
        robot = serial_robot(
            2,
            initial=(7.0, -3.0),
            commands=("velocity",),
            states=("position", "velocity"),
            kind="continuous",
            parameters=DYNAMICS,
        )
        self.stack = ControlStack(robot, enforce_limits=False)
        options = {
            "left_wheel_names": ["joint1"],
            "right_wheel_names": ["joint2"],
            "wheel_radius": RADIUS,
            "wheel_separation": SEPARATION,
            **parameters,
        }
        dotted = {name.replace("__", "."): value for name, value in options.items()}
        self.stack.load_controller("base", TYPE, dotted)
        self.stack.activate("base")
        self.node = self.stack.nodes["base"]
        self.stack.step()

    def drive(self, x, angular, seconds=0.0, **stamp):
        """Command a velocity anew each 0.1 s, for so long."""
        for _ in range(max(1, round(seconds * 10))):
            message = TwistStamped()
            message.twist.linear.x, message.twist.angular.z = x, angular
            set_stamp(message.header.stamp, stamp.get("stamp_ns", self.stack.time_ns))
            self.node.receive("~/cmd_vel", message)
            if seconds:
                self.stack.step(10)

    def stop(self):
        self.drive(0.0, 0.0)
        self.stack.step(6)

    @property
    def wheels(self):
        return self.stack.commands("velocity")

    @property
    def pose(self):
        pose = self.node.published("~/odom")[-1].pose.pose
        heading = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        return pose.position.x, pose.position.y, heading


def test_wheel_speeds_follow_from_the_velocity():
    base = Base(wheel_separation_multiplier=2.0, right_wheel_radius_multiplier=0.5)
    base.drive(1.0, 0.5, 0.1)
    half = 0.5 * SEPARATION * 2.0 / 2.0
    assert base.wheels == pytest.approx([(1.0 - half) / RADIUS, (1.0 + half) / (RADIUS / 2)])


@pytest.mark.parametrize("by_position", [True, False])
def test_a_square_ends_where_it_began(by_position):
    base = Base(position_feedback=by_position, publish_rate=100.0)
    for side in range(1, 5):
        base.drive(0.5, 0.0, 2.0)
        base.drive(0.0, math.pi / 4.0, 2.0)
        base.stop()
        heading = math.remainder(base.pose[2] - side * math.pi / 2, 2 * math.pi)
        assert heading == pytest.approx(0.0, abs=0.01)
        corner = [(1, 0), (1, 1), (0, 1), (0, 0)][side - 1]
        assert base.pose[:2] == pytest.approx(corner, abs=0.01)


def test_an_arc_is_a_circle_with_the_radius_of_speed_by_turn_rate():
    odometry = Odometry(window=10)
    steps = 37
    for _ in range(steps):
        odometry.advance(math.pi / steps, math.pi / 2.0 / steps, 0.1)
    # A quarter of a circle of radius 2.
    assert (odometry.x, odometry.y) == pytest.approx((2.0, 2.0), abs=1e-12)
    assert odometry.linear_x == pytest.approx(10.0 * math.pi / steps)


def test_odometry_and_transform_tell_the_same_in_their_frames():
    base = Base(
        tf_frame_prefix="/robot1",
        odom_frame_id="map",
        base_frame_id="base_footprint",
        pose_covariance_diagonal=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        publish_rate=20.0,
    )
    base.drive(0.5, 0.25, 1.0)
    odometry = base.node.published("~/odom")
    assert len(odometry) == 21  # 20 Hz of 100, from the first update on
    message, transform = odometry[-1], base.node.published("/tf")[-1].transforms[0]
    assert (message.header.frame_id, message.child_frame_id) == (
        "robot1/map",
        "robot1/base_footprint",
    )
    assert [message.pose.covariance[7 * row] for row in range(6)] == [1, 2, 3, 4, 5, 6]
    assert message.twist.twist.linear.x == pytest.approx(0.5)
    assert message.twist.twist.angular.z == pytest.approx(0.25)
    assert transform.header == message.header
    assert transform.transform.rotation == message.pose.pose.orientation
    assert transform.transform.translation.x == message.pose.pose.position.x > 0.3


def test_no_transform_where_none_is_wanted():
    assert "/tf" not in Base(enable_odom_tf=False).node.endpoints


def test_an_open_loop_believes_its_commands():
    base = Base(open_loop=True, publish_rate=100.0, linear__x__max_velocity=0.5)
    assert base.stack.manager.controllers["base"].required_state_interfaces == ()
    base.drive(1.0, 0.0, 1.0)
    assert base.pose[0] == pytest.approx(0.5)


def test_a_base_halts_when_no_velocity_comes_for_the_timeout():
    base = Base(cmd_vel_timeout=0.3)
    assert base.wheels == [0.0, 0.0]
    base.drive(1.0, 0.0)
    base.stack.step(30)
    assert base.wheels == [10.0, 10.0]
    base.stack.step()
    assert base.wheels == [0.0, 0.0]
    assert base.node.log.texts("warning") == ["Velocity command timed out. Braking."]
    for_ever = Base(cmd_vel_timeout=0.0)
    for_ever.drive(1.0, 0.0, stamp_ns=1)
    for_ever.stack.step(1000)
    assert for_ever.wheels == [10.0, 10.0]


def test_stamps_count():
    base = Base()
    base.drive(1.0, 0.0, 0.1, stamp_ns=base.stack.time_ns - 600_000_000)
    assert base.wheels == [0.0, 0.0]
    assert "exceeds the allowed timeout (0.5000)" in base.node.log.texts("warning")[-1]
    base.drive(1.0, 0.0, 0.1, stamp_ns=0)
    assert base.wheels == [10.0, 10.0]
    assert "zero timestamp" in base.node.log.texts("warning")[-1]
    # A clock that is ahead does not keep the base going when its sender is silent.
    base.drive(1.0, 0.0, stamp_ns=base.stack.time_ns + 10**12)
    base.stack.step(51)
    assert base.wheels == [0.0, 0.0]


def test_nonsense_is_ignored():
    base = Base()
    base.drive(0.5, 0.0, 0.1)
    base.drive(math.nan, 0.0, 0.1)
    assert base.wheels == [5.0, 5.0]


def test_velocities_may_come_without_a_stamp():
    base = Base(use_stamped_vel=False)
    message = Twist()
    message.linear.x = 0.5
    base.node.receive("~/cmd_vel_unstamped", message)
    base.stack.step()
    assert base.wheels == [5.0, 5.0]
    base.stack.step(60)
    assert base.wheels == [0.0, 0.0]


def test_a_base_stands_still_after_a_reset_at_once_and_its_odometry_begins_anew():
    base = Base(cmd_vel_timeout=0.0, linear__x__max_acceleration=1.0)
    base.drive(1.0, 0.0, 2.0)
    assert base.wheels == pytest.approx([10.0, 10.0])
    base.stack.time_ns = 0
    base.stack.step()
    assert base.wheels == [0.0, 0.0], "it has no speed to brake from"
    base.stack.step(5)
    assert base.pose == pytest.approx((0.0, 0.0, 0.0))


def test_a_base_halts_on_deactivation_and_forgets_the_old_velocity():
    base = Base(cmd_vel_timeout=0.0)
    base.drive(1.0, 0.0, 0.1)
    base.stack.deactivate("base")
    assert base.wheels == [0.0, 0.0]
    base.drive(1.0, 0.0)
    base.stack.activate("base")
    base.stack.step(3)
    assert base.wheels == [0.0, 0.0]


@pytest.mark.parametrize(
    "mistake",
    [
        {"left_wheel_names": []},
        {"left_wheel_names": ["joint1", "joint2"]},
        {"wheel_radius": 0.0},
        {"wheel_separation": -1.0},
        {"linear__x__max_velocity": -1.0},
    ],
)
def test_what_is_no_base_is_refused(mistake):
    with pytest.raises(AssertionError, match="Could not configure"):
        Base(**mistake)


class TestLimits:
    def test_speeding_up_braking_and_the_same_backwards_have_limits_of_their_own(self):
        base = Base(
            linear__x__max_velocity=0.4,
            linear__x__min_velocity=-0.2,
            linear__x__max_acceleration=2.0,
            linear__x__max_deceleration=-4.0,
            linear__x__max_acceleration_reverse=-8.0,
            linear__x__max_deceleration_reverse=10.0,
            publish_limited_velocity=True,
        )

        def speeds(wanted, count):
            seen = []
            for _ in range(count):
                base.drive(wanted, 0.0)
                base.stack.step()
                seen.append(base.node.published("~/cmd_vel_out")[-1].twist.linear.x)
            return pytest.approx(seen)

        assert [n * 0.02 for n in range(1, 20)] == speeds(1.0, 19)
        assert speeds(1.0, 2) == [0.4, 0.4]
        assert speeds(0.0, 2) == [0.36, 0.32]
        assert [*(n * 0.04 for n in range(7, -1, -1)), 0.0] == speeds(0.0, 9)
        assert speeds(-1.0, 3) == [-0.08, -0.16, -0.2]
        assert speeds(0.0, 3) == [-0.1, 0.0, 0.0]

    def test_what_is_left_out_follows_from_its_counterpart(self):
        base = Base(angular__z__max_velocity=1.0, angular__z__max_acceleration=50.0)
        base.drive(0.0, -5.0, 0.1)
        turning = 1.0 * SEPARATION / 2 / RADIUS
        assert base.wheels == pytest.approx([turning, -turning])
        base.drive(0.0, 5.0)
        base.stack.step()
        assert base.wheels == pytest.approx([turning / 2, -turning / 2])

    def test_limits_can_be_switched_off_as_older_files_do(self):
        base = Base(linear__x__max_velocity=0.4, linear__x__has_velocity_limits=False)
        base.drive(1.0, 0.0, 0.1)
        assert base.wheels == pytest.approx([10.0, 10.0])

    def test_jerk_is_limited_but_not_where_it_eases_off(self):
        limiter = RateLimiter(RateLimits(highest_jerk=100.0, lowest_jerk=-100.0))
        speeds = [limiter.limit(1.0, 0.1) for _ in range(2)]
        assert speeds == pytest.approx([1.0, 1.0])
        limiter = RateLimiter(RateLimits(highest_jerk=10.0, lowest_jerk=-10.0))
        assert [limiter.limit(1.0, 0.1) for _ in range(3)] == pytest.approx([0.1, 0.3, 0.6])
        assert limiter.limit(0.7, 0.1) == pytest.approx(0.7)


def test_reloaded_code_goes_on_with_velocity_limits_and_odometry():
    bases = [Base(linear__x__max_acceleration=1.0, publish_rate=100.0) for _ in range(2)]
    for base in bases:
        base.drive(1.0, 0.5, 0.3)
    reloaded, other = bases
    reloaded.stack.reload_controller("base")
    other.stack.step()
    assert reloaded.wheels == other.wheels
    for base in bases:
        base.stack.step(20)
    assert reloaded.wheels == other.wheels
    assert reloaded.pose == other.pose
