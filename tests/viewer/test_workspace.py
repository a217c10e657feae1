"""The workspace: each browser has its own arrangement, which it finds again, of the same panels."""

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from teleopctl.node import SingleThreadedExecutor, init
from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.viewer import PageLayout, Viewer, layout_of, load_layout, open_server
from teleopctl.viewer.panels.log import LogHistory
from teleopctl.viewer.panels.plots.collected import CollectedSamples
from tests.benchmarks.page_client import PageClient

LAYOUT = {
    "version": 1,
    "title": "Mine",
    "bar": ["tools"],
    "left": {"width": 200, "panels": [["scene"]]},
    "right": {"panels": [["joints", "log"], ["camera"], ["topics"]]},
}


class Session:
    """A viewer in this process, and browsers of which each is a client without a picture."""

    def __init__(self, viewer: Viewer, executor: SingleThreadedExecutor) -> None:
        self.viewer, self.workspace, self._executor = viewer, viewer.workspace, executor

    def until(self, holds):
        for _ in range(int(LONGEST_WAIT_S / 0.05)):
            if holds():
                return
            self._executor.spin_once(0.05)
        raise AssertionError("waited in vain")

    @contextmanager
    def browser(self, *, storage=None, tabs=("Joints", "Log")) -> Iterator[PageClient]:
        client = PageClient(self.viewer.server.get_port(), storage)
        self.until(lambda: tabs in client.tabs())
        yield client
        client.close()


@pytest.fixture
def session(ros) -> Iterator[Session]:
    del ros  # this process is in it
    layout = layout_of(LAYOUT, "here")
    with init(args=[]), Viewer(open_server(port=0), layout=layout) as viewer:
        executor = SingleThreadedExecutor()
        executor.add_node(viewer)
        yield Session(viewer, executor)
        executor.shutdown()


def test_two_browsers_have_two_arrangements_of_the_same_panels(session):
    with session.browser() as one, session.browser() as two:
        # No node publishes images: the stack of the camera is left out.
        assert one.tabs() == [("Scene",), ("Joints", "Log"), ("Topics",)]
        session.workspace.set_open(one.number, "camera", is_open=True)
        session.workspace.set_open(one.number, "topics", is_open=False)
        session.workspace.set_open(one.number, "plot", is_open=True)
        session.until(lambda: one.tabs() == [("Scene",), ("Joints", "Log"), ("Camera",), ("Plot",)])
        assert two.tabs() == [("Scene",), ("Joints", "Log"), ("Topics",)]
        client = session.viewer.server.get_clients()[two.number]
        session.workspace.arrange(client, load_layout("sliders"))
        session.until(lambda: two.tabs() == [("Joints",)])
        assert ("Scene",) in one.tabs()
        # Both show the content that was built once.
        containers = {
            container
            for client in (one, two)
            for part in client.parts.values()
            if "Joints" in part.get("_tab_labels", ())
            for container in part["_tab_container_ids"][:1]
        }
        assert len(containers) == 1


def test_a_panel_works_while_it_is_seen_and_one_that_collects_while_the_page_is(session):
    with session.browser() as one, session.browser() as two:
        shared = session.workspace._shared
        of_one, of_two = (session.workspace._desks[client.number].own for client in (one, two))
        session.until(lambda: "log" in of_one.begun & of_two.begun)
        one.show("joints")
        session.until(lambda: "joints" in shared.begun)
        two.show("topics", "unknown", "<b>")
        session.until(lambda: "topics" in of_two.begun)
        one.show()
        session.until(lambda: shared.begun == {"tools"})
        assert (of_one.begun, of_two.begun) == ({"log"}, {"log", "topics"})
        one.show(visibility="hidden")
        two.show(visibility="hidden")
        session.viewer._end_showing()
        assert not shared.begun | of_one.begun | of_two.begun


def test_two_browsers_have_choices_of_their_own_and_what_one_leaves_is_released(session):
    workspace = session.workspace

    def panel_of(browser, name):
        return workspace._panel(browser.number, name)

    with session.browser() as one:
        with session.browser() as two:
            assert panel_of(one, "joints") is panel_of(two, "joints")
            level = panel_of(two, "log")._level
            two.put(two.parts[level._impl.uuid], "Error")
            session.until(lambda: level.value == "Error")
            assert panel_of(one, "log")._level.value == "Info"
            for browser in (one, two):
                workspace.set_open(browser.number, "plot", is_open=True)
            workspace.plot(one.number, "/rosout/stamp/sec")
            workspace.plot(two.number, "/rosout/stamp/sec + 1")
            samples = session.viewer.shared(CollectedSamples)
            drawn = {
                browser: [
                    line.text for chart in panel_of(browser, "plot")._charts for line in chart.lines
                ]
                for browser in (one, two)
            }
            assert drawn == {one: ["/rosout/stamp/sec"], two: ["/rosout/stamp/sec + 1"]}
            workspace.store()
            two.wait_for(lambda: two.storage)
            assert "sec + 1" in "".join(two.storage.values())
            own, number = workspace._desks[two.number].own, two.number
        session.until(lambda: number not in workspace._desks)
        # A page that is loaded again within some seconds finds its plots as they were.
        with session.browser(storage=two.storage) as again:
            session.until(lambda: panel_of(again, "plot") is not None)
            assert panel_of(again, "log")._level.value == "Error"
            assert own.begun
            workspace._close_left(math.inf)
            assert not own.begun
            assert samples.topics
            gone = again.number
        session.until(lambda: gone not in workspace._desks)
        workspace._close_left(math.inf)
        workspace.forget(one.number)
        assert not samples.topics
        assert session.viewer.shared(LogHistory)._shown == {panel_of(one, "log")}


def test_a_browser_finds_its_arrangement_again_unless_it_is_of_something_else(session):
    with session.browser() as one:
        session.workspace.set_open(one.number, "topics", is_open=False)
        session.workspace.store()
        one.wait_for(lambda: one.storage)
        ((key, text),) = one.storage.items()
    assert "topics" not in text
    with session.browser(storage={key: text}) as same:
        session.until(lambda: same.tabs() == [("Scene",), ("Joints", "Log")])
    kept = json.loads(text)
    for other in (
        "{",
        "[" * 5000,
        json.dumps({**kept, "version": 0}),
        json.dumps({**kept, "usual": "Bag"}),
    ):
        with session.browser(storage={key: other}) as wrong:
            assert wrong.tabs() == [("Scene",), ("Joints", "Log"), ("Topics",)]


def test_a_stack_keeps_its_place_when_another_comes_between(session):
    with session.browser() as one:
        session.workspace.set_open(one.number, "camera", is_open=True)
        session.until(lambda: ("Camera",) in one.tabs())
        uuids = {
            tuple(part["_tab_labels"]): name
            for name, part in one.parts.items()
            if part.get("_tab_labels")
        }

        def placed():
            return [
                m["position"] for m in one.messages if m.get("uuid") == camera and "position" in m
            ]

        camera = next(name for labels, name in uuids.items() if "Camera" in labels)
        joints = next(name for labels, name in uuids.items() if "Joints" in labels)
        one.wait_for(placed)
        assert placed() == [{"kind": "split", "anchor_uuid": joints, "side": "below"}]


def test_without_a_layout_what_is_there_decides(session, monkeypatch):
    workspace = session.workspace
    workspace._layout = None
    there: set[str] = set()
    monkeypatch.setattr(workspace, "is_needed", there.__contains__)
    for panel, title in (("camera", "Perception"), ("controllers", "Control"), ("bag", "Bag")):
        assert workspace.usual_layout().title != title
        there.add(panel)
        assert workspace.usual_layout().title == title
    assert PageLayout.with_panels(["log"]).names() == ["log"]


def test_a_page_that_shows_the_view_alone_has_no_panels(session):
    with session.browser() as whole:
        storage: dict[str, str] = {}
        client = PageClient(session.viewer.server.get_port(), storage)
        client.show(embedded=True)
        session.until(lambda: session.viewer.server.clients.is_embedded(client.number))
        session.until(lambda: client.number in session.workspace._desks and not client.tabs())
        assert ("Joints", "Log") in whole.tabs()
        session.workspace.store()
        assert not storage
        client.close()
