"""Controllers of steered bases and mecanum wheels, on wheels that do as they are told, 100 Hz."""

import math

import pytest

from teleopctl.interfaces import get_message, get_service, set_stamp
from teleopctl.testing import ControlStack, serial_robot

ACKERMANN = "ackermann_steering_controller/AckermannSteeringController"
BICYCLE = "bicycle_steering_controller/BicycleSteeringController"
TRICYCLE = "tricycle_steering_controller/TricycleSteeringController"
FORKLIFT_TYPE = "tricycle_controller/TricycleController"
MECANUM = "mecanum_drive_controller/MecanumDriveController"
WHEELBASE, TRACK, RADIUS = 2.0, 1.0, 0.25
TwistStamped = get_message("geometry_msgs/msg/TwistStamped")

CAR = {
    "traction_joints_names": ["joint1", "joint2"],
    "steering_joints_names": ["joint3", "joint4"],
    "wheelbase": WHEELBASE,
    "traction_track_width": TRACK,
    "traction_wheels_radius": RADIUS,
    "position_feedback": False,
    "reference_timeout": 0.0,
}
BIKE = CAR | {"traction_joints_names": ["joint1"], "steering_joints_names": ["joint3"]}
TRIKE = CAR | {"steering_joints_names": ["joint3"]}
FORKLIFT = {
    "traction_joint_name": "joint1",
    "steering_joint_name": "joint3",
    "wheelbase": WHEELBASE,
    "wheel_radius": RADIUS,
    "cmd_vel_timeout": 10_000,
    "enable_odom_tf": True,
}
SIDES = {
    "left_wheel_names": ["joint1"],
    "right_wheel_names": ["joint2"],
    "wheel_separation": TRACK,
    "wheel_radius": RADIUS,
}
ROLLERS = {
    **{
        f"{wheel}_wheel_command_joint_name": f"joint{number}"
        for number, wheel in enumerate(
            ("front_left", "front_right", "rear_right", "rear_left"), start=1
        )
    },
    "kinematics.wheels_radius": RADIUS,
    "kinematics.sum_of_robot_center_projection_on_X_Y_axis": 0.8,
}


class Base:
    """A base on four joints."""

    def __init__(self, kind, parameters):
        robot = serial_robot(
            4,
            initial=(0.0,),
            commands=("position", "velocity"),
            states=("position", "velocity"),
            kind="continuous",
        )
        self.stack = ControlStack(robot, enforce_limits=False)
        self.stack.load_controller("base", kind, parameters)
        self.stack.activate("base")
        self.node = self.stack.nodes["base"]
        self.stack.step()

    def drive(self, x, angular, seconds, y=0.0):
        message = TwistStamped()
        message.twist.linear.x, message.twist.linear.y = x, y
        message.twist.angular.z = angular
        set_stamp(message.header.stamp, self.stack.time_ns)
        topic = "~/reference" if "~/reference" in self.node.endpoints else "~/cmd_vel"
        self.node.receive(topic, message)
        self.stack.step(round(seconds * 100))
        # The odometry is that of the wheels, which follow one update later.
        message.twist = type(message.twist)()
        self.node.receive(topic, message)
        self.stack.step(2)

    def speed(self, joint):
        return self.stack.command(f"{joint}/velocity")

    def angle(self, joint):
        return self.stack.command(f"{joint}/position")

    @property
    def pose(self):
        topic = "~/odometry" if "~/odometry" in self.node.endpoints else "~/odom"
        pose = self.node.published(topic)[-1].pose.pose
        turn = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        return pose.position.x, pose.position.y, turn


@pytest.mark.parametrize(("x", "angular"), [(1.0, 0.4), (1.0, -0.4), (-1.0, 0.4), (-1.0, -0.4)])
def test_all_wheels_of_a_car_roll_about_one_centre(x, angular):
    base = Base(ACKERMANN, CAR)
    message = TwistStamped()
    message.twist.linear.x, message.twist.angular.z = x, angular
    base.node.receive("~/reference", message)
    base.stack.step()
    centre = x / angular  # to the left of the driven axle's middle
    for joint, y in (("joint1", -TRACK / 2), ("joint2", TRACK / 2)):
        assert base.speed(joint) * RADIUS == pytest.approx(angular * (centre - y))
    for joint, y in (("joint3", -TRACK / 2), ("joint4", TRACK / 2)):
        assert math.tan(base.angle(joint)) == pytest.approx(WHEELBASE / (centre - y))
        assert abs(base.angle(joint)) < math.pi / 2


@pytest.mark.parametrize(
    ("kind", "parameters"), [(ACKERMANN, CAR), (BICYCLE, BIKE), (TRICYCLE, TRIKE)]
)
def test_a_steered_base_drives_the_circle_that_is_asked_for(kind, parameters):
    base = Base(kind, parameters)
    base.drive(1.0, math.pi / 4.0, 2.0)  # a quarter of a circle of radius 4 / pi
    radius = 4.0 / math.pi
    assert base.pose == pytest.approx((radius, radius, math.pi / 2), abs=0.01)
    transform = base.node.published("~/tf_odometry")[-1].transforms[0]
    assert transform.transform.translation.x == pytest.approx(base.pose[0])


def test_steered_wheels_stay_turned_at_rest():
    base = Base(BICYCLE, BIKE)
    base.drive(1.0, 0.5, 0.5)
    assert base.speed("joint1") == 0.0
    assert base.angle("joint3") == pytest.approx(math.atan(0.5 * WHEELBASE))
    base.stack.deactivate("base")
    assert base.angle("joint3") == pytest.approx(math.atan(0.5 * WHEELBASE))


def test_the_parameters_of_older_files_are_understood():
    old = {
        "front_steering": False,
        "front_wheels_names": ["joint1", "joint2"],
        "rear_wheels_names": ["joint3", "joint4"],
        "wheelbase": WHEELBASE,
        "front_wheel_track": TRACK,
        "rear_wheel_track": TRACK,
        "front_wheels_radius": RADIUS,
        "rear_wheels_radius": RADIUS,
        "use_stamped_vel": False,
    }
    stack = Base(ACKERMANN, old).stack
    spec = stack.manager.controllers["base"]
    assert spec.required_command_interfaces == (
        "joint1/velocity",
        "joint2/velocity",
        "joint3/position",
        "joint4/position",
    )
    assert spec.required_state_interfaces[0] == "joint1/position"


def test_a_wheel_that_drives_and_steers_rolls_where_it_points():
    base = Base(FORKLIFT_TYPE, FORKLIFT)
    base.drive(1.0, math.pi / 8.0, 0.02)
    angle = math.atan(math.pi / 8.0 * WHEELBASE)
    assert base.angle("joint3") == pytest.approx(angle)
    base.drive(1.0, math.pi / 8.0, 4.0)  # a quarter of a circle of radius 8 / pi
    radius = 8.0 / math.pi
    assert base.pose == pytest.approx((radius, radius, math.pi / 2), abs=0.04)


def test_such_a_wheel_turns_its_base_on_the_spot_slowly_at_first():
    base = Base(FORKLIFT_TYPE, FORKLIFT)
    base.drive(0.0, 0.5, 0.01)
    full = 0.5 * WHEELBASE / RADIUS
    message = TwistStamped()
    message.twist.angular.z = 0.5
    base.node.receive("~/cmd_vel", message)
    base.stack.step()
    assert base.angle("joint3") == pytest.approx(math.pi / 2)
    base.stack.step(2)
    assert base.speed("joint1") == pytest.approx(full)
    x, y, turned = base.pose
    assert (x, y) == pytest.approx((0.0, 0.0), abs=0.01)
    assert turned > 0.0


def test_speed_and_angle_of_such_a_wheel_have_limits():
    base = Base(
        FORKLIFT_TYPE,
        FORKLIFT
        | {
            "traction.max_velocity": 2.0,
            "traction.max_acceleration": 50.0,
            "steering.max_position": 0.3,
            "steering.max_velocity": 10.0,
        },
    )
    seen = []
    message = TwistStamped()
    message.twist.linear.x, message.twist.angular.z = 1.0, 0.2
    base.node.receive("~/cmd_vel", message)
    for _ in range(5):
        base.stack.step()
        seen.append((base.speed("joint1"), base.angle("joint3")))
    expected = [(0.5, 0.1), (1.0, 0.2), (1.5, 0.3), (2.0, 0.3), (2.0, 0.3)]
    assert seen == [pytest.approx(pair) for pair in expected]
    base.stack.deactivate("base")
    assert base.speed("joint1") == 0.0


def test_a_mecanum_base_goes_forwards_sideways_and_about_itself():
    for x, y, angular, wheels in [
        (0.5, 0.0, 0.0, [2.0, 2.0, 2.0, 2.0]),
        (0.0, 0.5, 0.0, [-2.0, 2.0, -2.0, 2.0]),
        (0.0, 0.0, 0.5, [-1.6, 1.6, 1.6, -1.6]),
    ]:
        base = Base(MECANUM, ROLLERS)
        message = TwistStamped()
        message.twist.linear.x, message.twist.linear.y = x, y
        message.twist.angular.z = angular
        base.node.receive("~/reference", message)
        base.stack.step()
        speeds = [base.speed(f"joint{number}") for number in range(1, 5)]
        assert speeds == pytest.approx(wheels)
        base.drive(x, angular, 1.0, y)
        # One update was driven before.
        expected = [1.01 * value for value in (x, y, angular)]
        assert base.pose == pytest.approx(expected, abs=0.01)


def test_a_mecanum_square_without_turning_ends_where_it_began():
    base = Base(MECANUM, ROLLERS)
    for x, y in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)):
        base.drive(x, 0.0, 1.0, y)
    assert base.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [
        (ACKERMANN, CAR | {"wheelbase": 0.0}),
        (ACKERMANN, CAR | {"steering_joints_names": ["joint3"]}),
        (BICYCLE, BIKE | {"traction_joints_names": []}),
        (FORKLIFT_TYPE, FORKLIFT | {"wheelbase": 0.0}),
        (FORKLIFT_TYPE, FORKLIFT | {"traction.max_velocity": -1.0}),
        (FORKLIFT_TYPE, FORKLIFT | {"steering_joint_name": ""}),
        (MECANUM, ROLLERS | {"kinematics.wheels_radius": 0.0}),
        (MECANUM, ROLLERS | {"rear_left_wheel_command_joint_name": ""}),
        (MECANUM, ROLLERS | {"kinematics.base_frame_offset.x": 0.1}),
    ],
)
def test_what_is_no_base_is_refused(kind, parameters):
    with pytest.raises(AssertionError, match="Could not configure"):
        Base(kind, parameters)


def test_a_forklifts_odometry_is_reset_by_its_service():
    base = Base(FORKLIFT_TYPE, FORKLIFT)
    base.drive(1.0, 0.0, 1.0)
    assert base.pose[0] == pytest.approx(1.0, abs=0.05)
    empty = get_service("std_srvs/srv/Empty")
    base.node.call("~/reset_odometry", empty.Request(), empty.Response())
    base.stack.step()
    assert base.pose == pytest.approx((0.0, 0.0, 0.0), abs=0.001)


def test_a_base_on_rollers_tells_its_wheels_speeds():
    base = Base(MECANUM, ROLLERS)
    base.drive(1.0, 0.0, 1.0)
    state = next(
        state
        for state in reversed(base.node.published("~/controller_state"))
        if state.reference_velocity.linear.x
    )
    speeds = (state.front_left_wheel_velocity, state.back_right_wheel_velocity)
    assert speeds == pytest.approx((1.0 / RADIUS,) * 2)


def test_unknown_parameters_are_named_with_the_nearest_known_ones():
    base = Base(MECANUM, ROLLERS | {"odometry_rate": 5.0, "kinematics.wheel_radius": 0.1})
    assert base.node.log.texts("warning") == [
        "Parameter 'kinematics.wheel_radius' is unknown and has no effect. "
        "Did you mean kinematics.wheels_radius?",
        "Parameter 'odometry_rate' is unknown and has no effect.",
    ]


@pytest.mark.parametrize(
    ("kind", "parameters", "references"),
    [
        ("diff_drive_controller/DiffDriveController", SIDES, ["linear", "angular"]),
        (ACKERMANN, CAR, ["linear", "angular"]),
        (BICYCLE, BIKE, ["linear", "angular"]),
        (TRICYCLE, TRIKE, ["linear", "angular"]),
        (MECANUM, ROLLERS, ["linear/x", "linear/y", "angular/z"]),
    ],
)
def test_another_controller_may_command_the_velocity(kind, parameters, references):
    base = Base(kind, parameters)
    names = [f"base/{part}/velocity" for part in references]
    assert [name for name in base.stack.resources.command_interfaces if "base" in name] == names
    forward = "forward_command_controller/MultiInterfaceForwardCommandController"
    options = {"joint": "base", "interface_names": [name.removeprefix("base/") for name in names]}
    base.stack.load_controller("planner", forward, options)
    base.stack.activate("planner")
    base.drive(9.0, 0.0, 0.1)  # its own topic does not count
    base.stack.step()
    assert base.speed("joint1") == 0.0
    values = [0.5] + [0.0] * (len(references) - 1)
    message = get_message("std_msgs/msg/Float64MultiArray")(data=values)
    base.stack.nodes["planner"].receive("~/commands", message)
    base.stack.step()
    assert base.speed("joint1") == pytest.approx(0.5 / RADIUS)
    base.stack.deactivate("planner")
    base.stack.step()
    assert base.speed("joint1") == 0.0


def test_a_forklift_has_no_references():
    base = Base(FORKLIFT_TYPE, FORKLIFT)
    assert not [name for name in base.stack.resources.command_interfaces if "base" in name]
