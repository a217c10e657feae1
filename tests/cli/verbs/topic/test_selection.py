"""``--field`` and ``--filter``."""

import pytest

from teleopctl.cli.verbs.topic.selection import field_reader, filter_predicate
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.store import get_message

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


def test_a_filter_is_python_with_the_message_as_m():
    wanted = filter_predicate("m.pose.position.x > 1")
    pose = Pose()
    assert not wanted(pose)
    pose.pose.position.x = 2.0
    assert wanted(pose)


def test_a_filter_that_is_no_python_is_wrong_usage():
    with pytest.raises(TeleopctlError, match="Invalid filter expression") as failure:
        filter_predicate("m.data >")
    assert failure.value.exit_status == 2


def test_a_filter_that_fails_says_so():
    with pytest.raises(TeleopctlError, match="has no attribute"):
        filter_predicate("m.data > 3")(Pose())
