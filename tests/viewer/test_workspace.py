"""The workspace: each browser has its own arrangement, which it finds again, of the same panels."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from teleopctl.node import SingleThreadedExecutor, init
from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.viewer import PageLayout, Viewer, layout_of, load_layout, open_server
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
        begun = session.workspace._begun
        session.until(lambda: "log" in begun)
        one.show("joints")
        session.until(lambda: "joints" in begun)
        two.show("topics", "unknown", "<b>")
        session.until(lambda: "topics" in begun)
        one.show()
        session.until(lambda: begun == {"log", "topics", "tools"})
        one.show(visibility="hidden")
        two.show(visibility="hidden")
        session.viewer._end_showing()
        assert not begun


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
        json.dumps({**kept, "title": "Bag"}),
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
