"""The panel of a bag that is played, against a real player."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from teleopctl.bag import Player, PlayOptions
from teleopctl.bag.player.player import MARKS_PARAMETER
from teleopctl.node import Node, Parameter
from teleopctl.viewer.panels.bag import BagPanel
from tests.bag.bags import write_bag
from tests.viewer.panels.live import spinning

LONG_S = 4.0


@pytest.fixture
def panel(live):
    panel = BagPanel(live)
    live.show(panel)
    return panel


@pytest.fixture
def player(tmp_path) -> Iterator[Player]:
    write_bag(tmp_path / "bag", count=int(LONG_S * 1000) + 1)

    def make(context, executor):
        node = Node("player", context=context)
        executor.add_node(node)
        return node

    with (
        spinning(make) as (node,),
        Player(node, tmp_path / "bag", PlayOptions(loop=True, clock_hz=40.0)) as player,
    ):
        player.play()
        yield player


def test_time_is_shown_dragged_paused_and_paced(live, panel, player):
    live.until(lambda: panel._line.visible)
    assert panel._line.max == LONG_S
    live.until(lambda: panel._line.value > 0.2)
    live.until(lambda: re.fullmatch(r"\d\.\d\d of 4\.00 s · 1x", panel._row.label))

    live.choose(panel._row, "Pause")
    live.until(lambda: player.is_paused)
    live.choose(panel._line, 3.0)
    # What is shown of that moment are the messages behind it.
    live.until(lambda: 3.0 <= (player.position_ns - player.start_ns) * 1e-9 < 3.2)
    live.until(lambda: panel._row.label.startswith("3.0") and panel._row.options[0] == "Play")
    assert player.is_paused

    before_ns = player.position_ns
    live.choose(panel._row, "Next")
    live.until(lambda: player.position_ns > before_ns)

    live.choose(panel._row, "0.5x")
    live.until(lambda: player.rate == 0.5)
    live.choose(panel._line, 0.5)
    live.until(lambda: (player.position_ns - player.start_ns) * 1e-9 < 0.7)
    live.choose(panel._row, "Play")
    live.until(lambda: not player.is_paused)
    live.until(lambda: panel._line.value > 0.8)
    assert live.told == []


def test_marks_of_the_bag_are_shown_and_lead_to_their_moment(live, panel, player):
    live.until(lambda: panel._line.visible)
    assert not panel._strip.visible
    marks = [f"{player.start_ns + 1_000_000_000} warning <b> is hot", "no time at all"]
    player._node.set_parameters([Parameter(MARKS_PARAMETER, value=marks)])
    live.until(lambda: panel._strip.visible)
    assert panel._strip.content.count("title=") == 1
    assert 'title="1.00 s · warning · &lt;b&gt; is hot"' in panel._strip.content
    assert "left:calc(25.00%" in panel._strip.content
    live.choose(panel._row, "Pause")
    live.until(lambda: player.is_paused)
    panel.clicked(live.client, "1.000000000")
    live.until(lambda: 1.0 <= (player.position_ns - player.start_ns) * 1e-9 < 1.2)


def test_without_loop_it_pauses_at_the_end_and_starts_again(live, panel, player):
    live.until(lambda: panel._row.options[2] == "Once")
    live.choose(panel._row, "Once")
    live.until(lambda: not player.loops)
    live.choose(panel._line, LONG_S - 0.1)
    live.until(lambda: player.is_paused)
    assert player.is_playing
    assert player.position_ns == player.end_ns
    player.resume()
    live.until(lambda: player.position_ns < player.end_ns)
    assert not player.is_paused


def test_many_places_in_one_go_end_at_the_last_one(live, panel, player):
    live.until(lambda: panel._line.visible)
    live.choose(panel._row, "Pause")
    live.until(lambda: player.is_paused)
    for place in (1.0, 3.5, 0.2, 2.0):
        live.choose(panel._line, place)
    live.until(lambda: 2.0 <= (player.position_ns - player.start_ns) * 1e-9 < 2.2)


def test_a_player_that_has_gone_is_not_followed_any_more(live, panel, player):
    live.until(lambda: panel._line.visible)
    player.close()
    live.until(lambda: not panel._line.visible)
    assert not BagPanel.is_needed(live.node)
