"""The graph in the page: a picture, drawn when something has changed."""

from types import SimpleNamespace

import pytest

from teleopctl.diagram import ros_graph
from teleopctl.viewer.panels.graph import GraphPanel
from teleopctl.wire import Graph
from tests.diagram.test_nodes_and_topics import TALK, graph_of


class Node:
    """A node that knows a graph."""

    def __init__(self):
        self.known = graph_of(*TALK)

    def graph(self):
        return self.known


@pytest.fixture
def panel(page):
    page.node = Node()
    panel = GraphPanel(page)
    panel.build()
    panel.tick()
    return panel


def second(panel):
    for _ in range(10):
        panel.tick()


def test_the_picture_follows_the_graph(page, panel):
    assert ">/chatter</text>" in panel._picture.content
    page.node.known = graph_of(*TALK, "/listener > /reply", "/talker < /reply")
    panel.graph_changed()
    second(panel)
    assert ">/reply</text>" in panel._picture.content


def test_nothing_is_drawn_while_nothing_changes(page, panel, monkeypatch):
    asked = []

    def graph():
        asked.append(1)
        return Graph()

    monkeypatch.setattr(page.node, "graph", graph)
    second(panel)
    assert asked == []
    for _ in range(5):
        panel.graph_changed()
        second(panel)
    assert len(asked) <= 6


def test_what_is_shown_is_chosen(page, panel):
    page.node.known = graph_of(*TALK, "/talker > /unheard", "/talker > /rosout", "/l < /rosout")
    page.choose(panel._shown, "All topics")
    panel.tick()
    assert "/unheard" in panel._picture.content
    assert "/rosout" not in panel._picture.content
    page.choose(panel._hidden, True)
    panel.tick()
    assert "/rosout" in panel._picture.content


def test_names_are_text(page, panel):
    page.node.known = graph_of("/<img> > /<b>", "/b < /<b>")
    panel.graph_changed()
    second(panel)
    assert "&lt;img&gt;" in panel._picture.content
    assert "<img" not in panel._picture.content


def test_a_graph_that_is_too_large_is_said_to_be(page, panel):
    ends = [end for n in range(300) for end in (f"/a{n} > /t{n}", f"/b{n} < /t{n}")]
    page.node.known = graph_of(*ends)
    panel.graph_changed()
    second(panel)
    assert "too many" in panel._picture.content
    assert not panel._save.visible
    assert len(ros_graph(page.node.known).boxes) == 900


def test_the_picture_can_be_saved(page, panel):
    page.click(panel._save)
    assert page.client.files["graph.svg"].startswith(b"<svg ")


def test_a_search_keeps_what_the_found_are_connected_with(page, panel):
    page.node.known = graph_of(*TALK, "/lab/arm > /states", "/lab/page < /states")
    page.choose(panel._search, "LISTEN")
    panel.tick()
    for name in ("/talker", "/chatter", "/listener"):
        assert f">{name}</text>" in panel._picture.content
    assert "/states" not in panel._picture.content
    page.choose(panel._search, "")
    page.choose(panel._space, "/lab")
    panel.tick()
    assert ">/states</text>" in panel._picture.content
    assert "/chatter" not in panel._picture.content
    page.choose(panel._search, "no such name")
    panel.tick()
    assert "No node or topic" in panel._picture.content


def test_topics_have_types_and_rates_that_change_without_a_new_picture(page, panel, monkeypatch):
    class Meter:
        def __init__(self):
            self.followed: list[str] = []

        def follow(self, _panel, topics):
            self.followed = list(topics)

        def sample(self):
            return {"/chatter": SimpleNamespace(rate_hz=12.34)}

    meter = Meter()
    monkeypatch.setattr(panel, "_meter", meter)
    panel.began()
    page.choose(panel._arrows, "Types and rates")
    panel.tick()
    drawn = panel._picture.content
    assert "std_msgs/String" in drawn
    second(panel)
    assert panel._picture.content is drawn
    (found,) = page.filled.items()
    assert found[1] == "12.3"
    assert f'id="{found[0]}"' in drawn
    panel.ended()
    assert meter.followed == []


def test_a_click_on_a_node_leads_to_its_parameters_and_log(page, panel):
    assert 'data-teleopctl-click="graph node /talker"' in panel._picture.content
    brought: list[str] = []

    def bring(_client, name):
        brought.append(name)
        return SimpleNamespace(show_of=brought.append)

    page.workspace = SimpleNamespace(bring=bring)
    client = SimpleNamespace(gui=page.gui, client_id=1)
    panel.clicked(client, "node /talker")
    closed = SimpleNamespace(close=lambda: None)
    for choice in ("Parameters", "Log", "Messages"):
        event = SimpleNamespace(client=client, target=SimpleNamespace(value=choice))
        panel._go(closed, "/talker", event)
    assert brought == ["parameters", "/talker", "log", "/talker", "topics", "/talker"]
