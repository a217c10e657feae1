"""``tf2_echo`` prints, character for character, what ROS 2's does."""

import pytest

from teleopctl.tf.echo import echo_text, time_text
from teleopctl.tf.transforms import Transform, quaternion_from_rpy


def test_a_transform_without_rotation():
    assert echo_text(1716587608671408293, Transform((0.0, 0.0, 0.307))) == (
        "At time 1716587608.671408293\n"
        "- Translation: [0.000, 0.000, 0.307]\n"
        "- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.000, 1.000]\n"
        "- Rotation: in RPY (radian) [0.000, -0.000, 0.000]\n"
        "- Rotation: in RPY (degree) [0.000, -0.000, 0.000]\n"
        "- Matrix:\n"
        "  1.000  0.000  0.000  0.000\n"
        "  0.000  1.000  0.000  0.000\n"
        "  0.000  0.000  1.000  0.307\n"
        "  0.000  0.000  0.000  1.000"
    )


def test_a_transform_with_rotation():
    text = echo_text(5, Transform((-1.5, 12.25, 0.0), quaternion_from_rpy(0.0, 0.0, 0.5)))
    assert text == (
        "At time 0.000000005\n"
        "- Translation: [-1.500, 12.250, 0.000]\n"
        "- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.247, 0.969]\n"
        "- Rotation: in RPY (radian) [0.000, -0.000, 0.500]\n"
        "- Rotation: in RPY (degree) [0.000, -0.000, 28.648]\n"
        "- Matrix:\n"
        "  0.878 -0.479  0.000 -1.500\n"
        "  0.479  0.878  0.000 12.250\n"
        "  0.000  0.000  1.000  0.000\n"
        "  0.000  0.000  0.000  1.000"
    )


def test_more_digits_are_told_where_they_are_asked_for():
    lines = echo_text(0, Transform((-1.0, 0.123456789, 2.0)), digits=5).splitlines()
    assert lines[1] == "- Translation: [-1.00000, 0.12346, 2.00000]"
    assert lines[6] == "  1.00000  0.00000  0.00000 -1.00000"


@pytest.mark.parametrize(
    ("stamp", "text"), [(0, "0.0"), (1, "0.000000001"), (3_000_000_020, "3.000000020")]
)
def test_times(stamp, text):
    assert time_text(stamp) == text
