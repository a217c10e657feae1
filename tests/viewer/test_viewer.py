"""The viewer's node: what strangers' panels do wrong does not end it."""

from teleopctl import plugins
from teleopctl.interfaces import get_message
from teleopctl.node import Node, QoSProfile, SingleThreadedExecutor, init
from teleopctl.testing import LONGEST_WAIT_S, eventually
from teleopctl.viewer import (
    PageLayout,
    Panel,
    Viewer,
    open_server,
    subscriptions,
    viewer as viewer_module,
)
from teleopctl.viewer.subscriptions import SharedSubscriptions
from tests.benchmarks.page_client import PageClient

String = get_message("std_msgs/msg/String")


class Careless(Panel):
    """Raises wherever it can."""

    title = "Careless"
    received: list[str] = []  # noqa: RUF012 -- looked at by the test

    def build(self):
        def hear(message):
            self.received.append(message.data)
            raise ValueError("received")

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
    Careless.received.clear()
    del ros  # this process is in it
    with (
        init(args=[]),
        Viewer(open_server(port=0), layout=PageLayout.with_panels(["careless"])) as node,
    ):
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        publisher = node.create_publisher(String, "/words", 10)
        publisher.publish(String(data="one"))
        publisher.publish(String(data="two"))
        while Careless.received != ["one", "two"]:
            executor.spin_once(LONGEST_WAIT_S)
        executor.shutdown()


def test_a_picture_that_cannot_be_drawn_does_not_end_the_page(ros, monkeypatch):
    del ros  # this process is in it
    drawn = []

    def fail():
        drawn.append(True)
        raise RuntimeError("drawn")

    with init(args=[]), Viewer(open_server(port=0), layout=PageLayout.with_panels(["log"])) as node:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        assert isinstance(node, Viewer)
        monkeypatch.setattr(node.frames, "update", fail)
        node._timer.reset()
        while len(drawn) < 2:
            executor.spin_once(LONGEST_WAIT_S)
        executor.shutdown()


class Attentive(Panel):
    """Notes when somebody begins to look, and when nobody does any more."""

    title = "Attentive"
    noted: list[str] = []  # noqa: RUF012 -- looked at by the test

    def build(self):
        pass

    def began(self):
        self.noted.append("began")

    def ended(self):
        self.noted.append("ended")


def test_a_browser_that_is_back_at_once_has_not_been_away(ros, monkeypatch):
    del ros  # this process is in it
    monkeypatch.setattr(viewer_module, "_HIDDEN_AFTER_S", 3600.0)
    load = plugins.load
    monkeypatch.setattr(
        plugins,
        "load",
        lambda kind, name: Attentive if kind is plugins.PANELS else load(kind, name),
    )
    Attentive.noted.clear()
    server = open_server(port=0)
    with init(args=[]), Viewer(server, layout=PageLayout.with_panels(["attentive"])) as node:
        assert isinstance(node, Viewer)
        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def spin_until(check):
            def spun():
                executor.spin_once(0.1)
                return check()

            eventually(spun)

        for _ in range(2):
            client = PageClient(server.get_port())
            client.show("attentive")
            spin_until(lambda: node._hide_timer.is_canceled() and Attentive.noted)
            client.close()
            spin_until(lambda: not node._hide_timer.is_canceled())
        assert Attentive.noted == ["began"]
        executor.shutdown()


def test_a_browser_that_hides_the_page_does_not_look(ros, monkeypatch):
    del ros  # this process is in it
    monkeypatch.setattr(viewer_module, "_HIDDEN_AFTER_S", 0.1)
    load = plugins.load
    monkeypatch.setattr(
        plugins,
        "load",
        lambda kind, name: Attentive if kind is plugins.PANELS else load(kind, name),
    )
    Attentive.noted.clear()
    server = open_server(port=0)
    with init(args=[]), Viewer(server, layout=PageLayout.with_panels(["attentive"])) as node:
        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def spin_until_noted(*words):
            def noted():
                executor.spin_once(0.1)
                return Attentive.noted == list(words)

            eventually(noted)

        first, second = PageClient(server.get_port()), PageClient(server.get_port())
        eventually(lambda: len(server.get_clients()) == 2)
        first.show("attentive")
        second.show("attentive")
        spin_until_noted("began")
        first.show(visibility="hidden")
        second.show(visibility="hidden")
        spin_until_noted("began", "ended")
        first.show("attentive")
        spin_until_noted("began", "ended", "began")
        first.close()
        spin_until_noted("began", "ended", "began", "ended")
        second.close()
        executor.shutdown()


def test_panels_that_show_the_same_topic_share_a_subscription(ros, monkeypatch):
    del ros  # this process is in it
    with init(args=[]), Node("page") as node:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        said: list[str] = []
        shared = SharedSubscriptions(
            node, lambda call, message: call(message), lambda title, _text: said.append(title)
        )
        first: list[object] = []
        second: list[object] = []
        end_first = shared.subscribe(
            "/words", "std_msgs/msg/String", first.append, QoSProfile(depth=1)
        )
        end_second = shared.subscribe(
            "/words", "std_msgs/msg/String", second.append, QoSProfile(depth=5)
        )
        (subscription,) = node.subscriptions
        assert subscription.qos_profile.depth == 5
        publisher = node.create_publisher(String, "/words", 10)
        publisher.publish(String(data="one"))
        while not second:
            executor.spin_once(LONGEST_WAIT_S)
        assert first[0] is second[0]  # it was decoded once
        end_first()
        publisher.publish(String(data="two"))
        while len(second) < 2:
            executor.spin_once(LONGEST_WAIT_S)
        assert len(first) == 1
        # Of messages that take long to copy one is shown in 30 s, which is said once.
        monkeypatch.setattr(subscriptions, "_LARGEST_AT_ANY_RATE", 100)
        for text in ("a" * 200, "b" * 200, "c" * 200, "three"):
            publisher.publish(String(data=text))
        while second[-1] != String(data="three"):
            executor.spin_once(LONGEST_WAIT_S)
        assert second[2:] == [String(data="a" * 200), String(data="three")]
        assert said == ["/words is left out in part"]
        end_second()
        assert not list(node.subscriptions)
        executor.shutdown()
