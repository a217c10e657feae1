"""The trace of a frame: where it was in the last seconds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from teleopctl.tf import Transform
from teleopctl.viewer import OK, WARN
from teleopctl.viewer.displays import frames
from teleopctl.viewer.panels.scene import _Row
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import SECOND, Draw, Picture, look, put_frame


def go(page: FakePage, *places: float, step_s: float = 0.1) -> None:
    """Move the frame ``tool`` along x, with three pictures at each place."""
    for place in places:
        page.node.now_ns += round(step_s * SECOND)
        stamp = page.node.now_ns + SECOND
        put_frame(page, "base", "map", Transform(), stamp)
        put_frame(page, "tool", "map", Transform((place, 0.0, 0.0)), stamp)
        for _ in range(3):
            look(page)


def line(picture: Picture, root: str = "/display1") -> list[float]:
    """The places on the line along x, each once."""
    nodes = picture.nodes(root)
    if not nodes:
        return []
    (node,) = nodes.values()
    assert (node.points[1:, 0] == node.points[:-1, 1]).all()
    xs = [float(node.points[0, 0, 0]), *node.points[:, 1, 0].tolist()]
    return [round(xs[0], 4), *(round(b, 4) for a, b in itertools.pairwise(xs) if a != b)]


def test_a_line_goes_through_where_the_frame_was(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Trace", Frame="tool")
    go(page, 0.0, 1.0, 3.0)
    assert line(picture) == [0.0, 1.0, 3.0]
    assert display.status == (OK, "")


def test_it_ends_where_the_frame_was_so_many_seconds_ago(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Trace", Frame="tool", Seconds=2.0)
    go(page, 0.0, 1.0, 2.0, 3.0, 4.0, step_s=1.0)
    assert line(picture) == [2.0, 3.0, 4.0]
    display.set("Seconds", 1.0)
    go(page, 5.0, step_s=1.0)
    assert line(picture) == [4.0, 5.0]


def test_a_frame_that_stands_still_adds_nothing_and_its_line_ends(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("Trace", Frame="tool", Seconds=2.0)
    go(page, 0.0, 1.0)
    (node,) = picture.nodes("/display1").values()
    before = node.points
    go(page, *[1.0] * 5)
    assert node.points is before
    go(page, *[1.0] * 30)
    assert line(picture) == []


def test_a_long_time_has_no_more_points_than_a_browser_draws(
    page: FakePage, draw: Draw, picture: Picture, monkeypatch: pytest.MonkeyPatch
):
    most = 200
    assert most < frames.MOST_POINTS
    monkeypatch.setattr(frames, "MOST_POINTS", most)
    draw("Trace", Frame="tool", Seconds=100.0)
    go(page, *(np.arange(2 * most) * 0.001), step_s=0.26)
    assert most // 2 < len(line(picture)) <= most


def test_a_growing_line_stays_one_node(page: FakePage, draw: Draw, picture: Picture):
    draw("Trace", Frame="tool", Seconds=100.0)
    go(page, 0.0, 1.0)
    (before,) = picture.nodes("/display1").values()
    go(page, *range(2, 60))
    (after,) = picture.nodes("/display1").values()
    assert after is before
    assert len(line(picture)) == 60


def test_colour_and_width_are_those_of_its_properties(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Trace", Frame="tool", Color="255; 0; 0", **{"Line Width": 0.01})
    go(page, 0.0, 1.0)
    (node,) = picture.nodes("/display1").values()
    assert node.thickness == pytest.approx(0.01)
    assert node.colors.reshape(-1, 3)[0].tolist() == [255, 0, 0]
    display.set("Color", (0, 0, 255))
    go(page, 2.0)
    (node,) = picture.nodes("/display1").values()
    assert node.colors.reshape(-1, 3)[0].tolist() == [0, 0, 255]
    assert line(picture) == [0.0, 1.0, 2.0]


def test_another_fixed_frame_or_another_frame_begins_anew(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Trace", Frame="tool")
    go(page, 0.0, 1.0)
    page.frames.set_fixed_frame("base")
    go(page, 1.0)
    assert line(picture) == []
    go(page, 2.0)
    assert line(picture) == [1.0, 2.0]
    display.set("Frame", "base")
    go(page, 3.0)
    assert line(picture) == []


def test_it_says_what_it_needs(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Trace")
    look(page)
    assert display.status == (OK, "Choose a frame")
    display.set("Frame", "nowhere")
    look(page)
    assert display.status == (WARN, "No transform from [nowhere] to [map]")
    assert line(picture) == []


def test_a_time_that_begins_anew_begins_the_line_anew(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Trace", Frame="tool")
    go(page, 0.0, 1.0)
    page.node.now_ns = 0
    display.update(jumped_back=True)
    assert line(picture) == []


def test_its_frame_is_chosen_from_those_that_there_are(page: FakePage, draw: Draw):
    display = draw("Trace")
    row = _Row(page, display)
    row.set_frame_options(["base", "map"])
    ((frame, _),) = row._frames
    assert frame.options == ("", "base", "map")
    page.choose(frame, "base")
    assert display.values.text("Frame") == "base"
    row.set_frame_options(["base", "map", "tool"])
    assert frame.options == ("", "base", "map", "tool")
    assert frame.value == "base"
