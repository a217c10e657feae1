"""A field of a message by its path."""

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import field_reader, get_message

Pose = get_message("geometry_msgs/msg/PoseStamped")
Transforms = get_message("tf2_msgs/msg/TFMessage")
Transform = get_message("geometry_msgs/msg/TransformStamped")
JointState = get_message("sensor_msgs/msg/JointState")


def test_a_field_is_named_as_in_python():
    pose = Pose()
    pose.pose.position.x = 2.5
    assert field_reader("pose.position.x")(pose) == 2.5
    transforms = Transforms(transforms=[Transform(child_frame_id="claw")])
    assert field_reader("transforms[0].child_frame_id")(transforms) == "claw"
    assert field_reader("position[-1]")(JointState(position=[1.0, 2.0])) == 2.0


@pytest.mark.parametrize("path", ["", ".pose", "pose..x", "pose[", "pose[x]", "pose-x", "a b"])
def test_a_malformed_path_is_wrong_usage(path):
    with pytest.raises(TeleopctlError) as failure:
        field_reader(path)
    assert failure.value.exit_status == 2


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("pose.posture", "geometry_msgs/msg/Pose has no field 'posture'"),
        ("pose[0]", "geometry_msgs/msg/Pose is no list"),
        ("header.frame_id.x", "str has no field 'x'"),
    ],
)
def test_a_field_that_the_message_lacks_is_named(path, reason):
    with pytest.raises(TeleopctlError, match="Invalid field") as failure:
        field_reader(path)(Pose())
    assert reason in failure.value.message


def test_the_fields_that_there_are_help():
    with pytest.raises(TeleopctlError) as failure:
        field_reader("pose.posture")(Pose())
    assert failure.value.hint == "its fields are position, orientation"
    with pytest.raises(TeleopctlError, match="no element 3"):
        field_reader("position[3]")(JointState(position=[1.0]))
