"""The page's server, asked over real sockets."""

import asyncio
import contextlib
import gc
import http.client
import re
import socket
import threading
import weakref
from typing import Any

import numpy as np
import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from teleopctl.testing import LONGEST_WAIT_S, eventually
from teleopctl.viewer import (
    PageError,
    PageRoutes,
    open_server,
    page_address,
    page_server as page_server,
)
from tests.benchmarks.page_client import PageClient
from tests.system.page_garbage import send_garbage

# In bytes: half of what the kernel takes by itself.
MUCH = 1_500_000
PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")


@pytest.fixture(scope="module")
def page():
    server = open_server(port=0)
    yield server
    server.stop()


def get(port, path="/", **headers):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("GET", path, headers=headers)
    response = connection.getresponse()
    response.read()
    connection.close()
    return response


def test_the_page_is_there_and_asks_for_nothing_else(page):
    assert get(page.get_port()).status == 200
    assert page.get_host() == "127.0.0.1"


def test_foreign_hosts_and_pages_get_nothing(page):
    assert get(page.get_port(), Host="evil.com").status == 403
    assert get(page.get_port(), Origin="http://evil.com").status == 403


def test_a_websocket_of_a_foreign_page_is_refused(page):
    address = f"ws://127.0.0.1:{page.get_port()}/"
    with pytest.raises(InvalidStatus, match="403"):
        connect(address, origin=Origin("http://evil.com"), subprotocols=[PROTOCOL])
    own = f"http://127.0.0.1:{page.get_port()}"
    with connect(address, origin=Origin(own), subprotocols=[PROTOCOL]) as socket_to_page:
        assert socket_to_page.recv(timeout=10)


def test_further_paths_are_behind_the_same_rules():
    async def echo(connection):
        async for text in connection:
            await connection.send(text)

    routes = PageRoutes()
    routes.add_file("/more", b"<p>More</p>", "text/html")
    routes.add_socket("/more/socket", echo)
    server = open_server("0.0.0.0", 0, token="s3cret", routes=routes)
    try:
        port = server.get_port()
        assert get(port, "/more").status == 403
        found = get(port, "/more?token=s3cret")
        assert (found.status, found.headers["Location"]) == (302, "/more")
        cookie = {"Cookie": found.headers["Set-Cookie"].partition(";")[0]}
        page = get(port, "/more", **cookie)
        assert (page.status, page.headers["Content-Type"]) == (200, "text/html")
        assert page.headers["X-Frame-Options"] == "SAMEORIGIN"
        assert get(port, "/more/socket", **cookie).status == 426
        assert get(port, "/", **cookie).status == 200
        with pytest.raises(InvalidStatus, match="403"):
            connect(f"ws://127.0.0.1:{port}/more/socket")
        address = f"ws://127.0.0.1:{port}/more/socket"
        with connect(address, additional_headers=cookie) as socket_to_page:
            socket_to_page.send("hello")
            assert socket_to_page.recv(timeout=10) == "hello"
    finally:
        server.stop()


def test_with_a_token_nobody_gets_in_without():
    server = open_server("0.0.0.0", 0, token="s3cret")
    try:
        port = server.get_port()
        assert get(port).status == 403
        with pytest.raises(InvalidStatus, match="403"):
            connect(f"ws://127.0.0.1:{port}/", subprotocols=[PROTOCOL])
        found = get(port, "/?token=s3cret")
        assert (found.status, found.headers["Location"]) == (302, "/")
        cookie = found.headers["Set-Cookie"].partition(";")[0]
        assert get(port, Cookie=cookie).status == 200
        with connect(
            f"ws://127.0.0.1:{port}/",
            subprotocols=[PROTOCOL],
            additional_headers={"Cookie": cookie},
        ) as socket_to_page:
            assert socket_to_page.recv(timeout=10)
    finally:
        server.stop()


def tell_visibility(port, browser, visibility, **headers):
    told = {"Teleopctl-Browser": str(browser), "Teleopctl-Visibility": visibility}
    return get(port, "/visibility", **told, **headers)


def test_a_browser_tells_whether_it_shows_the_page_and_no_foreign_page_does(page):
    changes: list[bool] = []
    client = PageClient(page.get_port())
    eventually(page.get_clients)
    (browser,) = page.get_clients()
    page.clients.on_change(lambda: changes.append(page.clients.is_visible(browser)))
    assert page.clients.is_visible(browser)
    assert tell_visibility(page.get_port(), browser, "hidden").status == 200
    assert tell_visibility(page.get_port(), browser + 1, "visible").status == 200
    assert tell_visibility(page.get_port(), browser, "visible").status == 200
    assert changes == [False, False, True]
    assert tell_visibility(page.get_port(), browser, "hidden", Origin="http://evil").status == 403
    # No headers: what a foreign page can send without being asked first.
    assert get(page.get_port(), "/visibility").status == 404
    # So browsers ask whether a foreign page may send them.
    with pytest.raises((http.client.HTTPException, ConnectionError)):
        preflight(page.get_port())
    assert page.clients.is_visible(browser)
    client.close()


def preflight(port):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("OPTIONS", "/visibility", headers={"Origin": "http://evil.com"})
    connection.getresponse()


@pytest.mark.parametrize(
    ("path", "status"),
    [("/" + "a" * 300, 404), ("/" + "a/" * 900, 404), ("/" + "a" * 5000, 414), ("/%00", 404)],
)
def test_a_file_that_there_cannot_be_is_none(page, path, status):
    assert get(page.get_port(), path).status == status


def test_a_page_of_another_version_is_refused_in_the_handshake(page, capfd):
    for protocols in ([], [Subprotocol("viser-v0.0.1")], [Subprotocol("foxglove.sdk.v1")]):
        with pytest.raises(InvalidStatus, match="400"):
            connect(f"ws://127.0.0.1:{page.get_port()}/", subprotocols=protocols)
    assert capfd.readouterr() == ("", "")


def test_garbage_is_logged_once_for_each_kind_and_then_counted(capfd):
    server = open_server(port=0)
    lines: list[str] = []
    server.client_errors.log = lines.append
    try:
        send_garbage(server.get_port(), 100)
        below = server._websock_server
        eventually(lambda: not below._live_connections)
        eventually(lambda: len(lines) >= 5)
        # It serves those who make sense.
        client = PageClient(server.get_port())
        eventually(server.get_clients)
        client.close()
    finally:
        server.stop()
    assert all(
        re.fullmatch(r"Invalid message from a browser.* \(\w+\)( \(1\d* times .*)?", x)
        for x in lines
    )
    assert len(lines) < 20
    assert "Traceback" not in "".join(capfd.readouterr())


def test_no_page_of_others_may_show_it_in_a_frame(page):
    for path in ("/", "/nothing"):
        found = get(page.get_port(), path)
        assert found.headers["X-Frame-Options"] == "SAMEORIGIN"
        assert found.headers["Content-Security-Policy"] == "frame-ancestors 'self'"


def test_a_default_port_that_is_taken_gives_way_to_the_next(monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        monkeypatch.setattr(page_server, "DEFAULT_PORT", port)
        server = open_server()
        try:
            assert port < server.get_port() <= port + 20
        finally:
            server.stop()


def test_a_given_port_that_is_taken_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(PageError, match=f"127.0.0.1:{port}: another program listens there"):
            open_server(port=port)


@pytest.mark.parametrize(("host", "port"), [("0.0.0.0", 0), ("no.such.host.invalid", 0)])
def test_what_cannot_be_opened_is_refused_at_once(host, port):
    with pytest.raises(PageError):
        open_server(host, port)


@pytest.mark.parametrize("port", [-1, 70_000])
def test_an_impossible_port_is_refused_at_once(port):
    with pytest.raises(PageError):
        open_server(port=port)


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.0.0.1", "http://localhost:80/"),
        ("::1", "http://localhost:80/"),
        ("192.168.0.7", "http://192.168.0.7:80/"),
        ("fe80::1", "http://[fe80::1]:80/"),
        ("0.0.0.0", f"http://{socket.gethostname()}:80/"),
    ],
)
def test_the_address_is_one_that_a_browser_opens(host, address):
    assert page_address(host, 80).url == address


@contextlib.contextmanager
def browser_that_stopped(server):
    """A connection of which nothing is read, as viser has it."""
    come: list[Any] = []
    server._websock_server.on_client_connect(come.append)
    with socket.socket() as silent:
        silent.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        silent.connect(("127.0.0.1", server.get_port()))
        silent.sendall(
            f"GET / HTTP/1.1\r\nHost: localhost:{server.get_port()}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            "Sec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n".encode()
        )
        eventually(lambda: come)
        yield come[0]


@pytest.mark.skipif(not hasattr(socket, "TCP_USER_TIMEOUT"), reason="Linux has it")
def test_a_browser_that_takes_nothing_is_let_go(monkeypatch):
    monkeypatch.setattr(page_server, "_SILENT_MS", 1_000)
    server = open_server(port=0)
    below = server._websock_server
    gone = threading.Event()
    below.on_client_disconnect(lambda _client: gone.set())
    try:
        with browser_that_stopped(server) as client:
            connection = weakref.ref(below._live_connections[client.client_id])
            # more than any buffer between the two holds
            server.scene.add_point_cloud("/many", np.zeros((3_000_000, 3)), (0, 0, 0))
            assert gone.wait(LONGEST_WAIT_S)
        del client
        assert not below._broadcast_buffer.generator_cursors

        def nothing_waits_for_it():
            gc.collect()
            left = connection()
            return left is None or left.transport.get_write_buffer_size() == 0

        eventually(nothing_waits_for_it)
    finally:
        server.stop()


def test_what_a_browser_has_not_taken_is_replaced_by_what_is_newer():
    server = open_server(port=0)
    queue = server._websock_server._broadcast_buffer
    try:
        with browser_that_stopped(server) as client:
            points = np.zeros((20_000, 3), np.float32)
            cloud = server.scene.add_point_cloud("/many", points, (0, 0, 0), precision="float32")

            def is_sent():
                newest = queue.message_counter - 1
                return queue.generator_cursors.get(client.client_id, -1) == newest

            sent = 0
            with contextlib.suppress(AssertionError):
                while sent < MUCH:
                    eventually(is_sent, 1.0)
                    sent += points.nbytes
                    cloud.points = points + sent
            # What waits for a browser is old when it is read.
            assert sent < MUCH
            kept = len(queue.message_from_id)
            for number in range(1000):
                cloud.points = points + number
            # The one that is being sent stays until it has been.
            assert len(queue.message_from_id) <= kept + 1
    finally:
        server.stop()


def test_what_is_drawn_wakes_nobody_outside_of_the_servers_thread(monkeypatch):
    threads = set()
    wake = asyncio.Event.set

    def note(event):
        threads.add(threading.current_thread())
        wake(event)

    server = open_server(port=0)
    try:
        with browser_that_stopped(server) as client:
            monkeypatch.setattr(asyncio.Event, "set", note)
            server.scene.add_frame("/frame")
            client.queue_message(viser._messages.RemoveSceneNodeMessage("/frame"))
            eventually(lambda: threads)
    finally:
        monkeypatch.undo()
        server.stop()
    assert threads == {server._websock_server._server_thread}


def test_a_browser_that_comes_before_the_page_is_ready_has_to_try_again(page):
    page.clients.is_attached = False
    address = f"ws://127.0.0.1:{page.get_port()}/"
    with pytest.raises(InvalidStatus, match="503"):
        connect(address, subprotocols=[PROTOCOL])
    page.clients.is_attached = True
    connect(address, subprotocols=[PROTOCOL]).close()
