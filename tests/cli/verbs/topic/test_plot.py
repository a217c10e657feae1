"""What ``topic echo --plot`` and ``top`` draw."""

import math

import pytest

from teleopctl.cli.verbs.topic.plot import MOST_TRACES, Traces
from teleopctl.errors import InvalidMessageError, UsageError
from teleopctl.interfaces import get_message

JOINTS = get_message("sensor_msgs/msg/JointState")


def joints(*positions, names=None):
    return JOINTS(position=list(positions), name=list(names or []))


def filled(fields, values, window_s=10.0):
    traces = Traces(fields, window_s)
    for index, value in enumerate(values):
        traces.add(index * 0.1, joints(value))
    return traces


def test_axes_say_what_is_drawn():
    text = filled(["position[0]"], [0.0, 1.0] * 50).plot_text(10.0, 80, 20, colour=False)
    assert "-10 s" in text
    assert " 0" in text
    assert " 1" in text
    assert "position[0]" in text
    assert "\x1b" not in text


def test_a_drawing_fits_its_place():
    traces = filled(["position[0]"], [math.sin(i) * 1e-13 for i in range(100)])
    for width, height in ((80, 24), (120, 40), (45, 14)):
        lines = traces.plot_text(10.0, width, height, colour=False).splitlines()
        assert max(map(len, lines)) <= width
        assert len(lines) <= height


def test_an_array_is_a_line_for_each_element_with_its_name():
    traces = Traces(["position"], 10.0)
    traces.add(1.0, joints(0.1, 0.2, names=["shoulder", "elbow"]))
    traces.add(2.0, joints(0.3, 0.4, names=["shoulder", "elbow"]))
    text = traces.plot_text(3.0, 80, 20, colour=False)
    assert "position[0] shoulder" in text
    assert "position[1] elbow" in text


def test_a_peak_of_one_message_among_thousands_is_seen():
    values = [0.0] * 5000
    values[2500] = 7.0
    traces = Traces(["position[0]"], 10.0)
    for index, value in enumerate(values):
        traces.add(index * 0.002, joints(value))
    assert any(
        f"│ {number}" in traces.plot_text(10.0, 60, 20, colour=False) for number in (5, 6, 7)
    )


def test_what_is_no_number_leaves_a_gap_and_what_is_old_is_gone():
    traces = filled(["position[0]"], [math.nan, math.inf, 1.0, -math.inf])
    assert "position[0]" in traces.plot_text(1.0, 60, 20, colour=False)
    assert traces.plot_text(100.0, 60, 20, colour=False) == "No message in the last 10 s"


def test_a_field_without_numbers_is_named():
    traces = Traces(["position"], 10.0)
    traces.add(1.0, joints(0.1, math.nan))
    assert traces.plot_text(2.0, 60, 20, colour=False).endswith("No numbers: position[1]")


@pytest.mark.parametrize("values", [[0.0] * 5, [1e300] * 5, [-1e300, 1e300], [5e-324] * 3])
def test_absurd_numbers_are_drawn(values):
    assert "position[0]" in filled(["position[0]"], values).plot_text(1.0, 60, 20, colour=False)


def test_a_field_that_is_no_number_is_named():
    for path in ("name", "header", "position[5]", "nothing"):
        with pytest.raises(InvalidMessageError, match=path.partition("[")[0]):
            Traces([path], 10.0).add(0.0, joints(1.0, names=["a"]))


def test_more_lines_than_can_be_told_apart_are_refused():
    with pytest.raises(UsageError, match=str(MOST_TRACES)):
        Traces(["position"], 10.0).add(0.0, joints(*range(MOST_TRACES + 1)))
