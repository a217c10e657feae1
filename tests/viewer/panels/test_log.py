"""The log: lines of /rosout, the newest first, those that the filters want."""

import re
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, strategies

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.viewer.panels.log import LINES_OF_A_BLOCK, MOST_LINES, LogPanel, stamp_of
from teleopctl.viewer.panels.plots.collected import CollectedSamples

LOG = get_message("rcl_interfaces/msg/Log")


@pytest.fixture
def panel(page):
    panel = LogPanel(page)
    panel.build()
    panel.began()
    yield panel
    panel.ended()


def say(page, text, *, node="arm", level=20, sec=1_700_000_000):
    log = LOG(name=node, msg=text, level=level)
    log.stamp.sec = sec
    page.publish("/rosout", log)


def blocks(panel):
    """The HTML of the blocks in the order of the page."""
    handles = sorted(panel._place._children.values(), key=lambda handle: handle.order)
    return [handle.content for handle in handles]


def texts(panel):
    """The messages on the page, from its top."""
    return re.findall(r"pre-wrap\">(.*?)</span>", "".join(blocks(panel)), re.DOTALL)


def drawn(panel):
    for _ in range(MOST_LINES // LINES_OF_A_BLOCK + 2):
        panel.tick()


def test_the_newest_line_stands_first(page, panel):
    for number in range(3):
        say(page, f"line {number}")
    panel.tick()
    say(page, "line 3")
    panel.tick()
    assert texts(panel) == ["line 3", "line 2", "line 1", "line 0"]


def test_what_nodes_said_before_is_shown_in_the_order_in_which_it_was_said(page, panel):
    say(page, "third", node="a", sec=3)
    say(page, "first", node="b", sec=1)
    say(page, "second", node="b", sec=2)
    panel.tick()
    assert texts(panel) == ["third", "second", "first"]


def test_a_new_line_changes_one_block_only(page, panel):
    for number in range(3 * LINES_OF_A_BLOCK):
        say(page, f"line {number}")
    drawn(panel)
    before = blocks(panel)
    say(page, "new")
    panel.tick()
    after = blocks(panel)
    assert after[1:] == before
    assert "new" in after[0]


def test_filters_choose_by_level_node_and_text(page, panel):
    say(page, "turns", level=10)
    say(page, "is hot", level=30)
    say(page, "is Hot", level=40, node="leg")
    panel.tick()
    assert texts(panel) == ["is Hot", "is hot"]
    page.choose(panel._level, "Debug")
    assert texts(panel) == ["is Hot", "is hot", "turns"]
    page.choose(panel._node, "arm")
    assert texts(panel) == ["is hot", "turns"]
    page.choose(panel._text, "HOT")
    assert texts(panel) == ["is hot"]


def test_of_a_bag_the_recorded_lines_are_shown_and_on_request_those_of_its_player(page):
    recording: Any = SimpleNamespace(start_s=50.0, end_s=100.0, topics=())
    page.shared(CollectedSamples).recording = recording
    panel = LogPanel(page)
    panel.build()
    panel.began()
    say(page, "recorded", sec=60)
    say(page, "Burst 100 messages.", node="rosbag2_player", sec=5000)
    panel.tick()
    assert texts(panel) == ["recorded"]
    page.choose(panel._newer, True)
    assert texts(panel) == ["Burst 100 messages.", "recorded"]
    panel.ended()


def test_nodes_that_spoke_can_be_chosen_and_the_choice_stays(page, panel):
    say(page, "a", node="arm")
    panel.tick()
    page.choose(panel._node, "arm")
    say(page, "b", node="leg")
    panel.tick()
    assert panel._node.options == ("(all)", "arm", "leg")
    assert panel._node.value == "arm"


def test_what_is_said_during_a_pause_comes_after_it(page, panel):
    page.choose(panel._buttons, "Pause")
    say(page, "meanwhile")
    panel.tick()
    assert texts(panel) == []
    page.choose(panel._buttons, "Resume")
    panel.tick()
    assert texts(panel) == ["meanwhile"]
    page.choose(panel._buttons, "Clear")
    assert texts(panel) == []


def test_what_nodes_repeat_for_who_looks_again_is_shown_once(page, panel):
    say(page, "ready")
    panel.tick()
    panel.ended()
    assert not page.listens_to("/rosout")
    panel.began()
    say(page, "ready")
    panel.tick()
    assert texts(panel) == ["ready"]


def test_a_flood_leaves_the_last_thousand_lines_and_time_to_draw(page, panel):
    for number in range(3 * MOST_LINES):
        say(page, f"line {number}")
    panel.tick()
    say(page, "later")
    panel.tick()
    assert "later" not in texts(panel)
    drawn(panel)
    shown = texts(panel)
    assert shown[0] == "later"
    assert MOST_LINES - LINES_OF_A_BLOCK < len(shown) <= MOST_LINES


def test_what_nodes_say_is_text_and_never_html(page, panel):
    say(page, "<img src=x onerror=alert(1)>", node='"><script>')
    panel.tick()
    (block,) = blocks(panel)
    assert "<img" not in block
    assert "<script" not in block
    assert "&lt;img src=x" in block


@given(
    strategies.text(max_size=50),
    strategies.integers(0, 255),
    strategies.integers(-(2**31), 2**31 - 1),
)
def test_any_line_can_be_shown(page_server, text, level, sec):
    from tests.viewer.conftest import FakePage

    page = FakePage(page_server)
    panel = LogPanel(page)
    panel.build()
    panel.began()
    page.choose(panel._level, "Debug")
    say(page, text, node=text, level=level, sec=sec)
    panel.tick()
    assert len(texts(panel)) == (1 if level >= 10 else 0)
    page_server.gui.reset()


def test_it_jumps_to_a_time_and_the_other_panels_with_it(page, panel):
    gone_to: list[float] = []
    page.workspace = SimpleNamespace(go_to=lambda _client, stamp_s: gone_to.append(stamp_s))
    for sec in (10, 20, 30):
        say(page, f"at {sec}", sec=sec)
    panel.tick()
    panel._time.value = "20"
    panel._jump(1)
    assert texts(panel) == ["at 20", "at 10"]
    assert "until 20.000 s" in panel._note.content
    panel._time.value = ""
    panel._jump(1)
    assert texts(panel) == ["at 30", "at 20", "at 10"]
    assert 'data-teleopctl-click="log 10.000000000"' in "".join(blocks(panel))
    panel.clicked(page.client, "10.000000000")
    assert gone_to == [20.0, 10.0]


def test_a_time_of_day_is_the_last_one_before_the_newest_message():
    noon_s = stamp_of("12:00", 1_700_000_000.0)
    assert 0 <= 1_700_000_000.0 - noon_s < 86_400
    assert stamp_of("12:00:30.5", noon_s) == noon_s + 30.5 - 86_400
    assert stamp_of("12:00:30.5", noon_s + 60) == noon_s + 30.5
    with pytest.raises(UsageError, match="is no time"):
        stamp_of("soon", noon_s)


def test_the_messages_of_one_node_are_shown(page, panel):
    say(page, "mine", node="lab.arm", level=10)
    say(page, "of a part", node="lab.arm.grip")
    say(page, "of another", node="lab.arms")
    panel.tick()
    panel.show_of("/lab/arm")
    assert texts(panel) == ["of a part", "mine"]
