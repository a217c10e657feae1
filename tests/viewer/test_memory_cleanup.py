"""What nobody needs any more is freed, also when the page is left alone for days."""

import asyncio
import gc
import weakref
from typing import Any

import pytest
import viser
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from teleopctl.node import SingleThreadedExecutor, init
from teleopctl.testing import LONGEST_WAIT_S, eventually
from teleopctl.viewer import PageLayout, Viewer, open_server, viewer as viewer_module
from teleopctl.viewer.page_server import MemoryCleanup

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")


@pytest.fixture
def page():
    server = open_server(port=0)
    yield server
    server.stop()


@pytest.fixture
def rings_stay():
    """Python looks for no rings of objects by itself."""
    gc.disable()
    yield
    gc.enable()


def browser(server):
    # It takes all that comes, or the end of the connection would wait behind it until a deadline.
    address = f"ws://127.0.0.1:{server.get_port()}/"
    return connect(address, subprotocols=[PROTOCOL], max_queue=None)


@pytest.mark.usefixtures("rings_stay")
def test_what_a_browser_leaves_behind_is_freed(page):
    cleanup = MemoryCleanup(page)
    below = page._websock_server
    come: list[weakref.ref[Any]] = []
    below.on_client_connect(lambda connection: come.append(weakref.ref(connection)))
    tasks = len(asyncio.all_tasks(below._background_event_loop))
    with browser(page) as opened:
        assert opened.recv(timeout=LONGEST_WAIT_S)
    eventually(lambda: len(asyncio.all_tasks(below._background_event_loop)) == tasks)
    cleanup.run()
    assert come[0]() is None


def test_what_is_drawn_under_ever_new_names_leaves_nothing_when_it_is_gone(ros, page, monkeypatch):
    del ros  # this process is in it
    monkeypatch.setattr(viewer_module, "CLEANUP_PERIOD_S", 0.01)
    kept = page._websock_server._broadcast_buffer.message_from_id
    with init(args=[]), Viewer(page, layout=PageLayout.with_panels(["log"])) as node, browser(page):
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        before = len(kept)
        for number in range(1000):
            page.scene.add_frame(f"/object_{number}").remove()

        def is_tidy():
            executor.spin_once(0.1)
            return len(kept) <= before + 100

        eventually(is_tidy)
        executor.shutdown()
