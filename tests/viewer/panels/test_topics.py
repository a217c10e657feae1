"""The topics in the page: a table, what was measured, and an echo."""

import re
from types import SimpleNamespace

import pytest

from teleopctl.interfaces import get_message
from teleopctl.viewer import topic_rates
from teleopctl.viewer.panels import topics
from teleopctl.viewer.panels.topics import MOST_ROWS, TopicsPanel
from tests.diagram.test_nodes_and_topics import graph_of

String = get_message("std_msgs/msg/String")


@pytest.fixture
def node(page, shared_ros):
    """A node that publishes and hears /chatter."""
    page.node = node = shared_ros.node
    publisher = node.create_publisher(String, "/chatter", 10)
    assert node.context.wait_for_graph(lambda graph: graph.publishers("/chatter"), 10)
    node.talk = lambda text: publisher.publish(String(data=text))
    yield node
    node.destroy_publisher(publisher)


@pytest.fixture
def panel(page, node):
    panel = TopicsPanel(page)
    panel.build()
    page.choose(panel._measure, False)
    panel.began()
    yield panel
    panel.ended()


def table(panel):
    """Names, and the numbers of ends beside them."""
    content = panel._table.content.replace("<wbr>", "")
    return dict(re.findall(r"<b [^>]*><span[^>]*>(.*?)</span></b><span[^>]*>(.*?)<", content))


def second(panel):
    for _ in range(10):
        panel.tick()


def echo(panel):
    for _ in range(2):
        panel.tick()
    return panel._text.content


def test_every_topic_has_its_type_and_the_numbers_of_its_ends(panel):
    assert table(panel)["/chatter"] == "1 → 0"
    assert "std_msgs/msg/String" in panel._table.content


def test_a_search_finds_parts_of_names_and_types(page, panel):
    page.choose(panel._search, "CHAT")
    assert list(table(panel)) == ["/chatter"]
    page.choose(panel._search, "interfaces/msg/log")
    assert list(table(panel)) == ["/rosout"]
    page.choose(panel._search, "nothing of the kind")
    assert table(panel) == {}


def test_rates_are_measured_only_when_asked_for(page, node, panel, monkeypatch):
    monkeypatch.setattr(topic_rates, "_PERIOD_S", 0.0)  # a second of ticks takes no time here
    page.choose(panel._search, "chatter")
    assert node.count_subscribers("/chatter") == 0
    page.choose(panel._measure, True)
    assert node.wait_for_subscribers("/chatter", 1, 10)
    second(panel)
    assert "nothing yet" in panel._table.content
    (count,) = panel._rates._meter._counts.values()
    count._take(4)
    before = panel._table.content
    second(panel)
    # In place: the row is not made again.
    assert panel._table.content is before
    assert re.fullmatch(r"\d+\.\d Hz · .*B/s", page.filled["teleopctl-topic-0"])
    panel.ended()
    assert node.context.wait_for_graph(lambda graph: not graph.subscriptions("/chatter"), 10)


def test_the_newest_message_of_one_topic_is_shown_as_a_tree(page, panel):
    page.choose(panel._echo, "/chatter")
    assert "Waiting" in echo(panel)
    page.publish("/chatter", String(data="first"))
    page.publish("/chatter", String(data="<b>second</b>"))
    shown = echo(panel)
    assert "data</span> &lt;b&gt;second&lt;/b&gt;" in shown
    assert "first" not in shown
    page.choose(panel._echo, "(none)")
    assert echo(panel) == ""
    assert not page.listens_to("/chatter")


def test_it_is_said_how_old_a_message_is(page, panel, monkeypatch):
    steady_s = [1000.0]
    monkeypatch.setattr(topics, "time", SimpleNamespace(monotonic=lambda: steady_s[0]))
    page.choose(panel._echo, "/chatter")
    page.publish("/chatter", String(data="last words"))
    for _ in range(10):
        panel.tick()
    assert panel._age.content == ""
    steady_s[0] += 12.0
    for _ in range(10):
        panel.tick()
    assert "Last message: 12 s ago" in panel._age.content


def test_nothing_is_sent_while_nothing_comes(page, panel):
    page.choose(panel._echo, "/chatter")
    page.publish("/chatter", String(data="once"))
    before = echo(panel)
    panel._message = None
    assert echo(panel) is before


def test_long_messages_are_cut(page, panel):
    page.choose(panel._echo, "/chatter")
    image = get_message("sensor_msgs/msg/Image")(data=bytes(1_000_000))
    page.publish("/chatter", image)
    panel.clicked(page.client, "flip data")
    assert "… 999980 more" in echo(panel)
    assert len(panel._text.content) < 10_000


def test_fields_fold_and_a_click_on_a_number_plots_it(page, panel):
    plotted: list[str] = []
    page.workspace = SimpleNamespace(
        plot=lambda _client, text: plotted.append(text), bring=lambda *_: panel
    )
    panel.clicked(page.client, "echo /chatter")
    transforms = get_message("tf2_msgs/msg/TFMessage")()
    transforms.transforms = [get_message("geometry_msgs/msg/TransformStamped")()]
    page.publish("/chatter", transforms)
    assert "stamp" not in echo(panel)
    panel.clicked(page.client, "flip transforms[0].header")
    assert "stamp" in panel._text.content
    panel.clicked(page.client, "flip transforms[0].transform")
    panel.clicked(page.client, "flip transforms[0].transform.translation")
    assert 'click="topics plot transforms[0].transform.translation.x"' in panel._text.content
    panel.clicked(page.client, "plot transforms[0].transform.translation.x")
    assert plotted == ["/chatter/transforms[0]/transform/translation/x"]
    panel.clicked(page.client, "flip transforms")
    assert "translation" not in panel._text.content


def test_nobody_looks_and_nothing_is_listened_to(page, panel):
    page.choose(panel._echo, "/chatter")
    panel.ended()
    assert not page.listens_to("/chatter")
    panel.began()
    assert page.listens_to("/chatter")


def test_a_topic_that_has_gone_stays_chosen(page, panel):
    page.choose(panel._echo, "/chatter")

    class Empty:
        def graph(self):
            return graph_of()

    page.node = Empty()
    panel.graph_changed()
    second(panel)
    assert panel._echo.value == "/chatter"
    assert "/chatter" in panel._echo.options


def test_a_very_large_graph_is_cut(page, panel):
    class Large:
        def graph(self):
            return graph_of(*(f"/a > /topic{n}" for n in range(MOST_ROWS + 50)))

    page.node = Large()
    panel.graph_changed()
    second(panel)
    assert len(table(panel)) == MOST_ROWS
    assert f"{MOST_ROWS + 50} topics, {MOST_ROWS} shown" in panel._table.content
