"""The numbers of a message by their paths."""

import pytest

from teleopctl.interfaces import NumericField, field_reader, get_message, numeric_fields
from teleopctl.interfaces.field_access import MOST_ELEMENTS, MOST_FIELDS

JointState = get_message("sensor_msgs/msg/JointState")
Transforms = get_message("tf2_msgs/msg/TFMessage")
Transform = get_message("geometry_msgs/msg/TransformStamped")


def test_elements_of_arrays_have_the_names_that_the_message_gives_them():
    state = JointState(name=["hip", "knee"], position=[1.0, 2.0])
    assert numeric_fields(state) == [
        NumericField("position", "", 2),
        NumericField("position[0]", "hip"),
        NumericField("position[1]", "knee"),
        NumericField("header.stamp.sec"),
        NumericField("header.stamp.nanosec"),
    ]


def test_names_of_a_message_hold_for_the_arrays_below_it():
    state = get_message("control_msgs/msg/JointTrajectoryControllerState")(joint_names=["hip"])
    state.output.positions = [0.5]
    assert NumericField("output.positions[0]", "hip") in numeric_fields(state)


def test_messages_of_an_array_have_their_own_names():
    message = Transforms(transforms=[Transform(child_frame_id="tool")])
    fields = [field for field in numeric_fields(message) if "translation.x" in field.path]
    assert fields == [NumericField("transforms[0].transform.translation.x", "tool")]


@pytest.mark.parametrize(
    ("type_name", "paths"),
    [
        ("std_msgs/msg/Bool", ["data"]),
        ("std_msgs/msg/String", []),
        ("geometry_msgs/msg/Vector3", ["x", "y", "z"]),
    ],
)
def test_a_type_tells_its_numbers_without_a_message(type_name, paths):
    assert [field.path for field in numeric_fields(get_message(type_name)())] == paths


def test_the_list_ends():
    cloud = get_message("sensor_msgs/msg/LaserScan")(ranges=[0.0] * 10_000)
    ranges = [field for field in numeric_fields(cloud) if field.path.startswith("ranges[")]
    assert len(ranges) == MOST_ELEMENTS
    many = Transforms(transforms=[Transform()] * 1000)
    assert len(numeric_fields(many)) <= MOST_FIELDS + 10


@pytest.mark.parametrize("type_name", ["sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry"])
def test_each_path_can_be_read(type_name):
    message = get_message(type_name)()
    for field in numeric_fields(message):
        value = field_reader(field.path)(message)
        if field.length is None:
            assert isinstance(value, bool | int | float)
        else:
            assert len(value) == field.length
