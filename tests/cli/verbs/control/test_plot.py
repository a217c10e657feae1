"""``control plot``: what is recorded of a trajectory controller, and what is printed of it."""

import math
import xml.etree.ElementTree as ET

import pytest

from teleopctl.bag import save_panels
from teleopctl.cli import console
from teleopctl.cli.verbs.control.plot import Tracking
from teleopctl.interfaces import get_message, set_stamp

STATE = get_message("control_msgs/msg/JointTrajectoryControllerState")
POINT = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
JOINTS = ["shoulder", "hip"]


def state(time_s, reference, feedback):
    message = STATE(
        joint_names=JOINTS,
        reference=POINT(positions=reference),
        feedback=POINT(positions=feedback),
        error=POINT(positions=[r - f for r, f in zip(reference, feedback, strict=True)]),
    )
    set_stamp(message.header.stamp, round(time_s * 1e9))
    return message


@pytest.fixture
def tracking():
    tracking = Tracking("positions", window_s=1.0)
    for time_s, reference in ((10.0, 0.0), (10.5, 0.3), (11.0, 1.0), (11.01, 5.0)):
        tracking.add(state(time_s, [reference, 0.0], [reference - 0.1 * reference, 0.0]))
    return tracking


def test_the_window_is_one_of_the_controllers_clock(tracking):
    assert tracking.is_complete
    assert tracking.times() == [0.0, 0.5, 1.0]
    assert tracking.values("reference", "shoulder") == [0.0, 0.3, 1.0]


def test_after_a_reset_of_the_simulation_it_begins_again(tracking):
    tracking.add(state(0.0, [0.2, 0.1], [0.2, 0.1]))
    assert (tracking.times(), tracking.values("feedback", "hip")) == ([0.0], [0.1])


def test_the_errors_of_each_joint_are_summed_up(tracking):
    assert list(tracking.summary(JOINTS)) == [
        "shoulder  largest error 0.1 at 1.00 s, rms 0.06028",
        "hip       largest error 0 at 0.00 s, rms 0",
    ]


def test_a_field_that_the_controller_does_not_have_is_said():
    tracking = Tracking("velocities", window_s=1.0)
    tracking.add(state(1.0, [0.0, 0.0], [0.0, 0.0]))
    assert list(tracking.summary(["hip"])) == ["hip  no velocities"]
    assert tracking.document("hip") == {
        "joint": "hip",
        "largest_error": None,
        "rms_error": None,
        "times": [0.0],
        "reference": [None],
        "feedback": [None],
        "error": [None],
    }
    assert math.isnan(tracking.values("error", "hip")[0])


def test_colours_of_a_drawing_stay_and_other_control_characters_are_made_visible(capsys):
    console.out_drawing("\x1b[34m⣀\x1b[0m\n\x1b]0;title\x07")
    printed = capsys.readouterr().out
    assert printed == "\x1b[34m⣀\x1b[0m\n\\x1b]0;title\\x07\x1b[0m\n"


def test_a_picture_has_two_panels_for_each_joint(tracking, tmp_path):
    file = tmp_path / "arm.svg"
    panels = tracking.panels(["shoulder"])
    assert [[curve.name for curve in curves] for curves in panels.values()] == [
        ["reference", "feedback"],
        ["error"],
    ]
    save_panels(panels, file, "arm: positions", columns=2)
    texts = {"".join(element.itertext()).strip() for element in ET.parse(file).iter()}
    assert {"arm: positions", "shoulder", "shoulder: error", "reference", "feedback"} <= texts
