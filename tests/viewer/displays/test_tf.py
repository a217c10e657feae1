"""TF: of which frames axes and names are shown."""

from __future__ import annotations

from typing import Any

import pytest

from teleopctl.tf import Transform, transform_stamped
from teleopctl.viewer import OK, WARN
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import Draw, look, put_frame


@pytest.fixture
def frames(page: FakePage, draw: Draw) -> FakePage:
    """A page with three more frames."""
    del draw
    for name in ("arm", "hand", "7"):
        put_frame(page, name, "map", Transform())
    page.frames.update()
    return page


def dressed(page: FakePage) -> set[str]:
    """The frames with axes and a name; each has both or neither."""
    found = {name for name, one in page.frames.by_name.items() if one.node.show_axes}
    assert found == {name for name, one in page.frames.by_name.items() if one.label is not None}
    return found


ALL = {"map", "base", "arm", "hand", "7"}


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, ALL),
        ({"Frames": {"arm": {"Value": False}, 7: {"Value": False}}}, ALL - {"arm", "7"}),
        ({"Frames": {"All Enabled": False, "arm": {"Value": True}}}, {"arm"}),
        ({"Frames": ["nonsense"]}, ALL),
        ({"Filter (whitelist)": "a[rn]"}, {"arm", "hand"}),
        ({"Filter (blacklist)": "^a|7"}, ALL - {"arm", "7"}),
        ({"Filter (whitelist)": "a", "Filter (blacklist)": "^h"}, {"map", "base", "arm"}),
    ],
)
def test_a_file_chooses_frames(frames: FakePage, draw: Draw, given: Any, expected: set[str]):
    display = draw("TF", **{"Show Names": True, **given})
    look(frames)
    assert dressed(frames) == expected
    assert display.status == (OK, "")


def test_a_frame_is_switched_off_and_on_and_the_file_keeps_it(frames: FakePage, draw: Draw):
    said = {"All Enabled": True, 7: {"Value": True}}
    display = draw("TF", **{"Show Names": True, "Frames": said})
    look(frames)
    assert display.parts() == dict.fromkeys(sorted(ALL), True)
    display.show_part("7", shown=False)
    assert dressed(frames) == ALL - {"7"}
    assert said == {"All Enabled": True, 7: {"Value": False}}
    # one that comes later is shown as well
    put_frame(frames, "late", "map", Transform())
    look(frames)
    assert dressed(frames) == ALL - {"7"} | {"late"}
    display.show_part("7", shown=True)
    assert dressed(frames) == ALL | {"late"}


def test_an_expression_that_is_none_is_told_and_hides_nothing(frames: FakePage, draw: Draw):
    display = draw("TF", **{"Show Names": True, "Filter (whitelist)": "("})
    look(frames)
    assert dressed(frames) == ALL
    assert display.status[0] == WARN
    assert display.status[1].startswith("Filter (whitelist) is not a regular expression")


def test_parent_and_age_of_each_frame_can_be_read(frames: FakePage, draw: Draw):
    display = draw("TF")
    assert "| hand | map | now |" in display.parts_text().splitlines()
    bolt = transform_stamped("hand", "bolt", 0, Transform())
    frames.frames.buffer.set_transform_static(bolt)
    assert "| bolt | hand | static |" in display.parts_text().splitlines()
