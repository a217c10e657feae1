"""The graph in the page: a picture, drawn when something has changed."""

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
