"""The plot panel: any number of any topic over time."""

import csv
import io
import itertools
import re
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import from_seconds, get_message, set_stamp
from teleopctl.viewer.panels.plots import plot, series as topic
from teleopctl.viewer.panels.plots.chart import MOST_LINES, PlotCurve, plot_csv, plot_png
from teleopctl.viewer.panels.plots.collected import CollectedSamples
from teleopctl.viewer.panels.plots.plot import PlotPanel

JointState = get_message("sensor_msgs/msg/JointState")
Number = get_message("std_msgs/msg/Float64")


@pytest.fixture
def panel(page, shared_ros):
    page.node = shared_ros.node
    publishers = [
        page.node.create_publisher(JointState, "/joint_states", 10),
        page.node.create_publisher(Number, "/number", 10),
    ]
    assert page.node.context.wait_for_graph(
        lambda graph: graph.publishers("/joint_states") and graph.publishers("/number"), 10
    )
    panel = PlotPanel(page)
    panel.build()
    panel.began()
    yield panel
    panel.ended()
    for publisher in publishers:
        page.node.destroy_publisher(publisher)


def now_s(page):
    return page.node.get_clock().now().nanoseconds * 1e-9


def state(stamp_s, *positions):
    message = JointState(name=["hip", "knee"][: len(positions)], position=list(positions))
    set_stamp(message.header.stamp, from_seconds(stamp_s))
    return message


def add(page, panel, *choices, where="New plot"):
    page.choose(panel._where, where)
    for choice in choices:
        panel.clicked(page.client, f"choose {choice}")


def choose_joints(page, panel):
    panel.tick()
    page.publish("/joint_states", state(now_s(page), 0.0, 0.0))
    panel.tick()


HIP, KNEE = "position[0] hip  /joint_states", "position[1] knee  /joint_states"
BOTH = "position (all 2)  /joint_states"


def draw(panel):
    for _ in range(2):
        panel.tick()


def shown(chart):
    """What the page has of a chart: its labels and its data."""
    handle = chart._handle
    return [one["label"] for one in handle.series[1:]], [some.tolist() for some in handle.data]


def test_fields_are_offered_by_the_types_and_those_of_lists_after_one_message(page, panel):
    panel.tick()
    assert "data  /number" in panel._offered
    assert page.listens_to("/joint_states")
    choose_joints(page, panel)
    assert {HIP, KNEE, BOTH} <= set(panel._offered)
    assert not page.listens_to("/joint_states")
    assert not page.listens_to("/number")


def test_a_field_is_found_by_words_in_any_order_and_by_its_full_name(page, panel):
    choose_joints(page, panel)

    def found(text):
        page.choose(panel._field.text, text)
        return re.findall("<b>(.*?)</b><br><span[^>]*>(.*?)<", panel._field.list.content)

    assert found("knee pos") == [("position[1] knee", "/joint_states")]
    assert found("/joint_states/position[1]")[0] == ("position[1] knee", "/joint_states")
    fields = [title for title, _ in found("joint_states")]
    assert not any(title.startswith("header") for title in fields)
    assert found("stamp joint")[0] == ("header.stamp.sec", "/joint_states")
    assert found("kneee") == []
    assert "No field contains kneee" in panel._field.list.content
    page.choose(panel._field.text, "joint_states hip position")
    panel._field._take_first()
    assert [line.text for line in panel._charts[0].lines] == ["/joint_states/position[0]"]
    assert panel._field.text.value == ""


def test_a_number_is_drawn_by_the_stamps_of_its_messages(page, panel):
    choose_joints(page, panel)
    add(page, panel, KNEE)
    start_s = now_s(page)
    for step in range(3):
        page.publish("/joint_states", state(start_s + step, 0.0, float(step)))
    draw(panel)
    labels, (times, values) = shown(panel._charts[0])
    assert labels == ["knee position"]
    assert times == pytest.approx([-2, -1, 0], abs=1e-5)
    assert values == [0, 1, 2]


def test_a_whole_array_is_a_line_for_each_element(page, panel):
    choose_joints(page, panel)
    add(page, panel, BOTH)
    start_s = now_s(page)
    for step in range(2):
        page.publish("/joint_states", state(start_s + step, 1.0, 2.0))
    draw(panel)
    labels, (_, hip, knee) = shown(panel._charts[0])
    assert labels == ["hip position", "knee position"]
    assert (hip, knee) == ([1, 1], [2, 2])


def test_fields_of_several_topics_share_a_plot(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    add(page, panel, "data  /number", where="Plot 1")
    assert page.listens_to("/joint_states")
    for _ in range(3):
        page.publish("/number", Number(data=3.0))
        page.publish("/joint_states", state(now_s(page), 1.0))
    draw(panel)
    labels, (_, hip, number) = shown(panel._charts[0])
    assert labels == ["hip position", "/number/data"]
    assert 1.0 in hip
    assert 3.0 in number


def test_stamps_of_another_clock_give_way_to_the_time_of_receipt(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    before_s = now_s(page)
    page.publish("/joint_states", state(5.0, 1.0))
    last_s = panel._charts[0].lines[0].samples.last_s
    assert before_s <= last_s <= now_s(page)


def test_a_time_that_begins_anew_begins_the_plot_anew(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    start_s = now_s(page)
    for stamp_s in (start_s, start_s + 1, start_s - 5, start_s - 4):
        page.publish("/joint_states", state(stamp_s, 1.0))
    draw(panel)
    _, (times, _) = shown(panel._charts[0])
    assert times == pytest.approx([-1, 0], abs=1e-5)


def test_a_jump_of_time_begins_the_plot_anew(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    start_s = now_s(page)
    for stamp_s in (start_s - 9, start_s - 8):
        page.publish("/joint_states", state(stamp_s, 1.0))
    panel.time_jumped()
    for stamp_s in (start_s, start_s + 1):
        page.publish("/joint_states", state(stamp_s, 2.0))
    draw(panel)
    assert shown(panel._charts[0])[1][1] == [2, 2]


class Recorded:
    """A recording of 20 s."""

    start_s, end_s = 1000.0, 1020.0
    topics = ("/joint_states", "/over/joint_states")

    def messages(self, _topic):
        for step in range(21):
            yield self.start_s + step, state(self.start_s + step, float(step))


def test_a_recording_is_drawn_whole_whatever_is_played(page, shared_ros):
    page.node = shared_ros.node
    page.shared(CollectedSamples).recording = Recorded()
    panel = PlotPanel(page)
    panel.build()
    panel.began()
    panel._add(["/joint_states/position[0]"])
    draw(panel)
    assert not page.listens_to("/joint_states")
    labels, (times, values) = shown(panel._charts[0])
    assert labels == ["hip position"]
    assert times == values == list(range(21))
    page.choose(panel._window, 4.0)
    # The node's clock, that of the system, is past the end of the recording.
    draw(panel)
    assert shown(panel._charts[0])[1][0] == [16, 17, 18, 19, 20]
    panel._add(["/over/joint_states/position[0]"])
    draw(panel)
    labels, _ = shown(panel._charts[0])
    assert labels == ["hip position /joint_states", "hip position /over/joint_states"]
    panel.ended()


def test_an_element_that_is_missing_is_passed_over(page, panel):
    choose_joints(page, panel)
    add(page, panel, KNEE)
    start_s = now_s(page)
    page.publish("/joint_states", state(start_s, 0.0, 1.0))
    page.publish("/joint_states", state(start_s + 1, 0.0))
    page.publish("/joint_states", state(start_s + 2, 0.0, 3.0))
    draw(panel)
    assert shown(panel._charts[0])[1][1] == [1, 3]


def y_axis(chart):
    """The range of the page's vertical axis and its labels; None where uPlot chooses them."""
    handle = chart._handle
    return handle.axes and (handle.scales["y"]["range"], handle.axes[1]["values"])


def test_what_is_held_is_drawn_flat_and_what_moves_by_little_has_labels(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    (chart,) = panel._charts
    times = itertools.count(now_s(page))

    def publish(*positions):
        page.choose(panel._buttons, "Clear")
        for position in positions:
            page.publish("/joint_states", state(next(times), position))
        draw(panel)

    publish(1.2, 1.2 + 2e-16, 1.2)
    (low, high), labels = y_axis(chart)
    assert (low, high) == pytest.approx((1.0, 1.4))
    assert labels == ("1.0", "1.1", "1.2", "1.3", "1.4")
    publish(-1e-15, 3e-13, 1e-15)
    assert y_axis(chart) == ((-1.0, 1.0), ("-1.0", "-0.5", "0.0", "0.5", "1.0"))
    publish(0.0, 4e-6, 2e-6)
    assert y_axis(chart) == ((0.0, 4e-6), ("0", "1", "2", "3", "4"))
    assert chart._handle.axes[1]["label"] == "x1e-6"
    publish(0.0, 0.5, 1.0)
    assert y_axis(chart) is None


def note(chart):
    return chart._note.content if chart._note.visible else ""


def test_a_topic_that_has_ended_is_not_shown_as_if_it_went_on(page, panel, monkeypatch):
    steady_s = [1000.0]
    clock = SimpleNamespace(monotonic=lambda: steady_s[0])
    monkeypatch.setattr(plot, "time", clock)
    monkeypatch.setattr(topic, "time", clock)
    choose_joints(page, panel)
    add(page, panel, HIP)
    (chart,) = panel._charts
    assert note(chart) == "Waiting for messages…"
    start_s = now_s(page)
    for step in range(3):
        page.publish("/joint_states", state(start_s + step, 0.0))
    for _ in range(20):
        panel.tick()
    assert note(chart) == ""
    steady_s[0] += 12.0
    for _ in range(10):
        panel.tick()
    assert note(chart).endswith(": 12 s ago")
    page.publish("/joint_states", state(start_s + 15, 0.0))
    for _ in range(10):
        panel.tick()
    assert note(chart) == ""


def test_messages_without_a_number_are_not_waited_for(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    for step in range(3):
        page.publish("/joint_states", state(now_s(page) + step, float("nan")))
    for _ in range(10):
        panel.tick()
    assert "NaN" in note(panel._charts[0])


def test_nothing_is_sent_while_nothing_is_new(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    start_s = now_s(page)
    for step in range(3):
        page.publish("/joint_states", state(start_s + step, 1.0))
    draw(panel)
    before = panel._charts[0]._handle.data
    draw(panel)
    assert panel._charts[0]._handle.data is before


def test_a_paused_plot_stands_still_and_catches_up(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    start_s = now_s(page)
    for step in range(3):
        page.publish("/joint_states", state(start_s + step, float(step)))
    page.choose(panel._buttons, "Pause")
    page.publish("/joint_states", state(start_s + 3, 3.0))
    draw(panel)
    assert shown(panel._charts[0])[1][1] == [0, 1, 2]
    page.choose(panel._buttons, "Resume")
    draw(panel)
    assert shown(panel._charts[0])[1][1] == [0, 1, 2, 3]
    page.choose(panel._buttons, "Clear")
    for step in (4, 5):
        page.publish("/joint_states", state(start_s + step, float(step)))
    draw(panel)
    assert shown(panel._charts[0])[1][1] == [4, 5]


def test_the_window_is_as_long_as_chosen(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    start_s = now_s(page)
    for step in range(30):
        page.publish("/joint_states", state(start_s + step, float(step)))
    draw(panel)
    assert shown(panel._charts[0])[1][0][0] == pytest.approx(-10, abs=1e-5)
    page.choose(panel._window, 3.0)
    draw(panel)
    assert shown(panel._charts[0])[1][0][0] == pytest.approx(-3, abs=1e-5)


def test_nobody_looks_and_nothing_is_listened_to(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    panel.ended()
    assert not page.listens_to("/joint_states")
    panel.began()
    assert page.listens_to("/joint_states")


def buttons_of(chart):
    return next(one for one in chart._folder._children.values() if hasattr(one, "options"))


def test_a_removed_plot_is_no_longer_listened_for(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    assert page.listens_to("/joint_states")
    page.choose(buttons_of(panel._charts[0]), "Remove")
    assert panel._where.options == ("New plot",)
    assert not page.listens_to("/joint_states")
    assert panel.state() is None


def test_a_full_plot_says_so(page, panel):
    panel.tick()
    page.publish("/joint_states", JointState(position=[0.0] * 30))
    add(page, panel, "position (all 30)  /joint_states")
    assert len(panel._charts[0].lines) == MOST_LINES
    assert page.told == [("Plot 1 is full", f"It has {MOST_LINES} lines.")]


def enter(page, panel, text):
    panel._expression.value = text
    panel._take_expression()


def test_an_expression_of_fields_of_two_topics_is_a_line(page, panel):
    choose_joints(page, panel)
    enter(page, panel, "2 * /joint_states/position[0] - /number/data")
    start_s = now_s(page)
    for step in range(3):
        page.publish("/number", Number(data=1.0))
        page.publish("/joint_states", state(start_s + step * 1e-3, float(step)))
    page.publish("/number", Number(data=1.0))
    draw(panel)
    labels, (_, values) = shown(panel._charts[0])
    assert labels == ["2 * /joint_states/position[0] - /number/data"]
    assert values[0] == pytest.approx(-1, abs=0.1)
    for text, words in (("/nothing/data", "no topic"), ("sine(/number/data)", "did you mean sin?")):
        with pytest.raises(TeleopctlError, match=words):
            enter(page, panel, text)
    assert len(panel._charts) == 1


def test_what_was_plotted_is_plotted_again_when_its_topics_are_there(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    enter(page, panel, "d(/number/data)")
    page.choose(panel._window, 3.0)
    kept = panel.state()
    later = {"line": "/later/x/data", "topics": ["/later/x"]}
    again = PlotPanel(page)
    again.build()
    again.began()
    again.restore({**kept, "plots": [*kept["plots"], [later, 7, {"line": 1, "topics": []}]]})
    again.tick()
    texts = [[line.text for line in chart.lines] for chart in again._charts]
    assert texts == [["/joint_states/position[0]", "d(/number/data)"], ["/later/x/data"]]
    assert again._window.value == 3.0
    assert again.state()["plots"][:1] == kept["plots"]
    again.ended()
    states: list[object] = [None, [], {"plots": 3}, {"plots": [3, [None]], "seconds": -1}]
    for wrong in states:
        again.restore(wrong)


def test_a_paused_plot_is_looked_back_on(page, panel):
    choose_joints(page, panel)
    add(page, panel, HIP)
    page.choose(panel._window, 2.0)
    start_s = now_s(page)
    for step in range(9):
        page.publish("/joint_states", state(start_s + step, float(step)))
    page.choose(panel._buttons, "Pause")
    assert panel._back.visible
    assert panel._back.max == pytest.approx(8.0, abs=0.1)
    page.choose(panel._back, 4.0)
    draw(panel)
    assert shown(panel._charts[0])[1][1] == pytest.approx([2, 3, 4], abs=1e-3)
    page.choose(panel._buttons, "Resume")
    assert not panel._back.visible


def test_a_plot_is_saved_as_its_samples_and_as_a_picture(page, panel):
    choose_joints(page, panel)
    add(page, panel, BOTH)
    start_s = now_s(page)
    for step in range(3):
        page.publish("/joint_states", state(start_s + step, float(step), -1.0))
    buttons = buttons_of(panel._charts[0])
    page.choose(buttons, "CSV")
    page.choose(buttons, "PNG")
    rows = list(csv.reader(io.StringIO(page.client.files["plot_1.csv"].decode())))
    assert rows[0] == ["time", "/joint_states/position[0]", "/joint_states/position[1]"]
    assert [row[1:] for row in rows[1:]] == [["0.0", "-1.0"], ["1.0", "-1.0"], ["2.0", "-1.0"]]
    assert float(rows[1][0]) == pytest.approx(start_s, abs=1e-6)
    picture = Image.open(io.BytesIO(page.client.files["plot_1.png"]))
    assert picture.size == (1600, 900)


def test_a_table_has_a_row_for_each_time_and_gaps_where_there_is_none():
    one, two = (np.array([0.0, 1.0]), np.array([5.0, 6.0])), (np.array([1.0]), np.array([7.0]))
    text = plot_csv(["/a", "/b"], [one, two]).decode().splitlines()
    assert text == ["time,/a,/b", "0.000000000,5.0,", "1.000000000,6.0,7.0"]


def test_a_picture_has_the_curves_in_their_colours():
    times = np.linspace(-1.0, 0.0, 50)
    content = plot_png(times, [PlotCurve("/a", "#ff0000", times * 2)])
    colors = {color for _, color in Image.open(io.BytesIO(content)).getcolors(1 << 20) or ()}
    assert (255, 0, 0) in colors


@pytest.mark.parametrize("value", [0.0, 1e-300, 1e300, -1e300, float("nan")])
def test_a_picture_can_be_made_of_any_values(value):
    times = np.array([0.0, 1.0])
    assert plot_png(times, [PlotCurve("x", "#ff0000", np.array([0.0, value]))])
    assert plot_png(np.array([]), [PlotCurve("x", "#ff0000", np.array([]))])
