"""The viewer's node: what strangers' panels do wrong does not end it."""

from teleopctl import plugins
from teleopctl.interfaces import get_message
from teleopctl.node import QoSProfile, SingleThreadedExecutor, init
from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.viewer import Panel, Viewer, open_server

String = get_message("std_msgs/msg/String")


class Careless(Panel):
    """Raises wherever it can."""

    title = "Careless"
    heard: list[str] = []  # noqa: RUF012 -- looked at by the test

    def build(self):
        def hear(message):
            self.heard.append(message.data)
            raise ValueError("heard")

        self.end = self.page.stage.subscribe(
            "/words", "std_msgs/msg/String", hear, QoSProfile(depth=10)
        )

    def graph_changed(self):
        raise ValueError("graph")


def test_a_panel_that_raises_does_not_end_the_page(ros, monkeypatch):
    load = plugins.load
    monkeypatch.setattr(
        plugins,
        "load",
        lambda kind, name: Careless if kind is plugins.PANELS else load(kind, name),
    )
    Careless.heard.clear()
    del ros  # this process is in it
    with init(args=[]), Viewer(open_server(port=0), panels=["careless"]) as node:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        publisher = node.create_publisher(String, "/words", 10)
        publisher.publish(String(data="one"))
        publisher.publish(String(data="two"))
        while Careless.heard != ["one", "two"]:
            executor.spin_once(LONGEST_WAIT_S)
        executor.shutdown()


def test_a_picture_that_cannot_be_drawn_does_not_end_the_page(ros, monkeypatch):
    del ros  # this process is in it
    drawn = []

    def fail():
        drawn.append(True)
        raise RuntimeError("drawn")

    with init(args=[]), Viewer(open_server(port=0), panels=["log"]) as node:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        assert isinstance(node, Viewer)
        monkeypatch.setattr(node.frames, "update", fail)
        node._timer.reset()
        while len(drawn) < 2:
            executor.spin_once(LONGEST_WAIT_S)
        executor.shutdown()
