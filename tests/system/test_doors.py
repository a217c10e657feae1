"""Every door that listens, as strangers find it: foreign origins, names and machines."""

from __future__ import annotations

import asyncio
import contextlib
import http.server
import re
import shutil
import socket
import ssl
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any, Literal, NamedTuple

import psutil
import pytest
import viser
from websockets import Subprotocol
from websockets.asyncio.client import connect as async_connect
from websockets.exceptions import InvalidHandshake, InvalidMessage
from websockets.http11 import Response
from websockets.sync.client import connect
from websockets.typing import Origin

from teleopctl.base.access import with_token
from teleopctl.interfaces import get_message
from teleopctl.testing import RosGraph, eventually
from tests.bag.bags import write_bag
from tests.samples import sample
from tests.system.browser import browser
from tests.system.foxglove_client import SUBPROTOCOL, FoxgloveClient

STRING = get_message("std_msgs/msg/String")
FOREIGN = Origin("http://evil.example")
PAGE = Subprotocol(f"viser-v{viser.__version__}")
FOXGLOVE = "https://app.foxglove.dev"
# All of 127.0.0.0/8 is this machine on Linux; elsewhere only its first address.
OTHER = "127.0.0.2" if sys.platform == "linux" else "127.0.0.1"


class Door(NamedTuple):
    """One of the programs that listen.

    Attributes:
        command: Starts it on a free port, at an address of its own choice.
        anywhere: What makes it listen on all addresses.
        found: Its port, in what it says.
        stream: Where it says so.
        protocol: What its websockets speak.
    """

    command: str
    anywhere: str
    found: str
    stream: Literal["stdout", "stderr"]
    protocol: Subprotocol


BRIDGE = "run foxglove_bridge foxglove_bridge --ros-args -p port:=0"
DOORS = {
    "page": Door(
        "run rviz2 rviz2 --port 0",
        " --host 0.0.0.0",
        r"The robot is at http://[^/]*:(\d+)/$",
        "stderr",
        PAGE,
    ),
    "bag": Door(
        "bag view bag --port 0",
        " --host 0.0.0.0",
        r"^The bag in your browser: http://[^/]*:(\d+)/",
        "stdout",
        PAGE,
    ),
    "sliders": Door(
        "run joint_state_publisher_gui joint_state_publisher_gui --port 0",
        " --host 0.0.0.0",
        r"The sliders are at http://[^/]*:(\d+)/$",
        "stderr",
        PAGE,
    ),
    "bridge": Door(
        BRIDGE, " -p address:=0.0.0.0", r"listening on ws://[\d.]+:(\d+)$", "stderr", SUBPROTOCOL
    ),
}


@pytest.fixture(params=DOORS)
def door(request) -> Door:
    return DOORS[request.param]


def opened(ros: RosGraph, door: Door, options: str = "") -> tuple[int, int]:
    """Start a door; returns its process and port."""
    if not (ros.folder / "bag").exists():
        write_bag(ros.folder / "bag", count=5)
    process = ros.spawn(door.command + options)
    return process.pid, int(process.wait_for_line(door.found, stream=door.stream)[1])


def status(address: str, port: int, protocol: Subprotocol, path: str = "/", **headers: str) -> int:
    """Answer to a websocket, as its HTTP status; 0 where no answer of HTTP comes."""
    origin = headers.pop("origin", None)
    named = {name.title(): value for name, value in headers.items()}
    try:
        with socket.create_connection((address, port), 10) as plain:
            if "Host" in named:
                return answer_to_host(plain, path, protocol, named["Host"])
            with connect(
                f"ws://{address}:{port}{path}",
                sock=plain,
                origin=None if origin is None else Origin(origin),
                subprotocols=[protocol],
                additional_headers=named,
            ) as client:
                assert client.recv(timeout=10)
                return 101
    except InvalidHandshake as error:
        response: Response | None = getattr(error, "response", None)
        assert response is not None or isinstance(error, InvalidMessage)
        return 0 if response is None else response.status_code
    except OSError:
        return 0


def answer_to_host(plain: socket.socket, path: str, protocol: Subprotocol, host: str) -> int:
    # The library writes this header itself.
    plain.sendall(
        f"GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Protocol: {protocol}\r\n\r\n".encode()
    )
    return int(plain.recv(100).split()[1])


def own_address() -> str | None:
    """Address of this machine in its network; None where it is in none."""
    with (
        contextlib.suppress(OSError),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe,
    ):
        probe.connect(("192.0.2.1", 9))  # sends nothing
        return str(probe.getsockname()[0])
    return None


def test_on_loopback_a_door_is_for_programs_and_its_own_page(ros, door):
    pid, port = opened(ros, door)
    assert status("127.0.0.1", port, door.protocol) == 101
    for origin in (FOREIGN, "null", "file://", "http://localhost:1", f"{FOXGLOVE}.evil.example"):
        assert status("127.0.0.1", port, door.protocol, origin=origin) == 403
    for host in ("evil.example", f"evil.example:{port}", f"{OTHER[:-1]}9.evil.example"):
        assert status("127.0.0.1", port, door.protocol, host=host) == 403
    for host in ("localhost.", "LOCALHOST:80", f"[::1]:{port}"):
        assert status("127.0.0.1", port, door.protocol, host=host) == 101
    for address in {own_address(), OTHER} - {None, "127.0.0.1"}:
        assert status(str(address), port, door.protocol) == 0
    assert_no_other_way_in(pid, port, door, "/")


def listeners(pid: int) -> list[tuple[str, int]]:
    return [
        (each.laddr.ip, each.laddr.port)
        for each in psutil.Process(pid).net_connections("tcp")
        if each.status == psutil.CONN_LISTEN
    ]


def assert_no_other_way_in(pid: int, port: int, door: Door, path: str) -> None:
    """What else the program listens on answers no websocket; a door does so at once.

    Zenoh closes a connection that does not speak its protocol after 10 s only.
    """
    for host, other in listeners(pid):
        if other != port:
            address = f"ws://{host}:{other}{path}"
            with pytest.raises((InvalidHandshake, OSError)):
                connect(address, proxy=None, subprotocols=[door.protocol], open_timeout=1)


def test_beyond_loopback_a_door_opens_with_the_token_alone(ros, door):
    token = ros.folder / "my token"
    token.touch(0o600)
    token.write_text("grün \"and\" 'blue'\n", encoding="utf-8")
    named = (
        f' -p "token_file:={token}"' if door.protocol == SUBPROTOCOL else f" --token-file '{token}'"
    )
    pid, port = opened(ros, door, door.anywhere + named)
    path = with_token("/", "grün \"and\" 'blue'")
    for address in {own_address() or OTHER, OTHER, "127.0.0.1"}:
        assert status(address, port, door.protocol) == 403
        assert status(address, port, door.protocol, "/?token=gr%C3%BCn") == 403
        assert status(address, port, door.protocol, path, origin=FOREIGN) == 403
        assert status(address, port, door.protocol, path) == 101
    assert_no_other_way_in(pid, port, door, path)
    shown = " ".join(psutil.Process(pid).cmdline())
    assert "grün" not in shown


def test_foxgloves_apps_are_admitted_and_others_by_the_user(ros):
    bridge = DOORS["bridge"]
    _, port = opened(ros, bridge, f" -p \"allowed_origins:=['{FOXGLOVE}', 'http://robot:3000']\"")
    assert status("127.0.0.1", port, SUBPROTOCOL, origin=FOXGLOVE) == 101
    assert status("127.0.0.1", port, SUBPROTOCOL, origin="http://robot:3000") == 101
    assert status("127.0.0.1", port, SUBPROTOCOL, origin="http://robot") == 403
    _, port = opened(ros, bridge)
    assert status("127.0.0.1", port, SUBPROTOCOL, origin=FOXGLOVE) == 101
    agent = {"user-agent": "Mozilla/5.0 foxglove-studio/2.1 Chrome/140 Electron/38.0 Safari/537"}
    assert status("127.0.0.1", port, SUBPROTOCOL, origin="file://", **agent) == 101
    assert status("127.0.0.1", port, SUBPROTOCOL, origin="http://robot:3000") == 403


@pytest.mark.skipif(shutil.which("openssl") is None, reason="It makes the certificate")
def test_with_tls_the_door_asks_the_same(ros):
    made = "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 1 -subj /CN=x"
    files = ["-keyout", "key.pem", "-out", "cert.pem"]
    subprocess.run(["openssl", *made.split(), *files], cwd=ros.folder, check=True, timeout=60)
    tls = " -p tls:=true -p certfile:=cert.pem -p keyfile:=key.pem"
    process = ros.spawn(BRIDGE + tls)
    port = process.wait_for_line(r"listening on wss://127\.0\.0\.1:(\d+)$", stream="stderr")[1]
    context = ssl.create_default_context(cafile=str(ros.folder / "cert.pem"))
    context.check_hostname = False
    address = f"wss://127.0.0.1:{port}/"

    # The client with threads reads and writes at once, which OpenSSL does not stand everywhere.
    async def first_message(**options: Any) -> str:
        async with async_connect(
            address, ssl=context, subprotocols=[SUBPROTOCOL], server_hostname="x", **options
        ) as client:
            return str(await client.recv())

    assert "serverInfo" in asyncio.run(first_message())
    with pytest.raises(InvalidHandshake, match="403"):
        asyncio.run(first_message(origin=FOREIGN))
    assert status("127.0.0.1", int(port), SUBPROTOCOL) == 0


def test_what_is_no_origin_is_refused(ros):
    done = ros.run(f"{BRIDGE} -p \"allowed_origins:=['*']\"")
    assert done.returncode == 1
    assert "'*' is not an origin" in done.stderr


def test_who_is_refused_is_logged_once_and_then_counted(ros):
    process = ros.spawn(BRIDGE)
    port = int(process.wait_for_line(DOORS["bridge"].found, stream="stderr")[1])
    for _ in range(12):
        assert status("127.0.0.1", port, SUBPROTOCOL, origin=FOREIGN) == 403
    process.wait_for_line(r"evil\.example .*allowed_origins.*\(10 times", stream="stderr")
    assert process.stderr.count("evil.example") == 2


def test_a_client_that_says_nothing_or_too_much_is_let_go(ros):
    _, port = opened(ros, DOORS["bridge"])
    with socket.create_connection(("127.0.0.1", port), 10) as plain:
        plain.sendall(b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 10_000)
        assert plain.recv(100).startswith(b"HTTP/1.1 400 ")
    for request in (b"\x16\x03\x01\x02\x00" + b"\r\n\r\n", b"GET / HTTP/1.1\r\nHost\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", port), 10) as plain:
            plain.sendall(request)
            assert plain.recv(100).startswith(b"HTTP/1.1 400 ")
    assert status("127.0.0.1", port, SUBPROTOCOL, "/" + "a" * 5000) == 414
    with FoxgloveClient(port) as client:
        client.until(lambda: client.info)


# --- in a real browser ----------------------------------------------------------------------------

# What a page may try: a websocket, what it would send, and reading over HTTP.
ATTACK = """
async ({address, protocol, document, binary}) => {
  const received = await new Promise((done) => {
    const socket = new WebSocket(address.replace("http", "ws"), [protocol]);
    socket.binaryType = "arraybuffer";
    socket.onerror = () => done("refused");
    socket.onmessage = () => {
      if (document) socket.send(JSON.stringify(document));
      if (binary) setInterval(() => socket.send(new Uint8Array(binary)), 100);
      socket.onmessage = null;
      done("connected");
    };
  });
  let read = "nothing";
  try {
    read = await (await fetch(address)).text();
  } catch (error) {}
  return [received, read];
}
"""


@contextlib.contextmanager
def foreign_page() -> Iterator[tuple[str, Callable[[str], None]]]:
    """Serve a page of another origin; what is called sets its text."""
    text = ["<p>a page of a stranger</p>"]

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(text[0].encode())

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}", lambda new: text.__setitem__(0, new)
        finally:
            server.shutdown()
            thread.join()


@pytest.mark.nightly
@pytest.mark.timeout(300)  # a browser and six programs
def test_a_foreign_page_in_a_browser_neither_reads_nor_moves(ros):
    commands: list[str] = []
    ros.node.create_subscription(STRING, "/commands", lambda m: commands.append(m.data), 10)
    # The sliders first: where a page is open they are shown on that one.
    ports = {name: opened(ros, DOORS[name])[1] for name in ("sliders", "bag", "page")}
    page_port = ports["page"]
    channel = {
        "id": 1,
        "topic": "/commands",
        "encoding": "cdr",
        "schemaName": "std_msgs/msg/String",
    }
    push = {"op": "advertise", "channels": [channel]}
    message = [1, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 0, 0, *b"push\0"]
    with foreign_page() as (stranger, write), browser() as chromium:
        _, port = opened(ros, DOORS["bridge"])
        _, port_for_friends = opened(
            ros, DOORS["bridge"], f" -p \"allowed_origins:=['{stranger}']\""
        )

        def attack(origin: str, port: int, protocol: str) -> Any:
            tab = chromium.new_page()
            tab.goto(origin)
            return tab.evaluate(
                ATTACK,
                {
                    "address": f"http://127.0.0.1:{port}/",
                    "protocol": protocol,
                    "document": push if protocol == SUBPROTOCOL else None,
                    "binary": message if protocol == SUBPROTOCOL else None,
                },
            )

        assert attack(stranger, port, SUBPROTOCOL) == ["refused", "nothing"]
        for page in ports.values():
            assert attack(stranger, page, PAGE) == ["refused", "nothing"]
        assert attack("data:text/html,<p>", port, SUBPROTOCOL) == ["refused", "nothing"]
        assert attack((ros.folder / "bag").as_uri(), port, SUBPROTOCOL) == ["refused", "nothing"]
        # Nor may it show the page below buttons of its own.
        write(f"<iframe id=frame src='http://127.0.0.1:{page_port}/'></iframe>")
        tab = chromium.new_page()
        with tab.expect_response(lambda answer: str(page_port) in answer.url) as answer:
            tab.goto(stranger)
        assert answer.value.headers["x-frame-options"] == "SAMEORIGIN"
        eventually(lambda: all(re.match("chrome-error|about", f.url) for f in tab.frames[1:]))
        tab.close()
        assert commands == []
        # The attack is one: from an origin that the user has admitted it works.
        assert attack(stranger, port_for_friends, SUBPROTOCOL)[0] == "connected"
        eventually(lambda: "push" in commands)
        own = f"http://127.0.0.1:{page_port}/"
        assert attack(own, page_port, PAGE)[0] == "connected"


@pytest.mark.nightly
def test_a_page_beyond_loopback_opens_in_a_browser_with_any_token(ros):
    token = ros.folder / "token"
    token.touch(0o600)
    token.write_text('a "b" ü&c;\n', encoding="utf-8")
    _, port = opened(ros, DOORS["page"], f" --host 0.0.0.0 --token-file {token}")
    with browser() as chromium:
        tab = chromium.new_page()
        assert (answer := tab.goto(f"http://127.0.0.1:{port}/")) is not None
        assert answer.status == 403
        with tab.expect_websocket(timeout=60_000) as opened_socket:
            tab.goto(with_token(f"http://127.0.0.1:{port}/", 'a "b" ü&c;'))
        assert tab.url == f"http://127.0.0.1:{port}/"
        opened_socket.value.wait_for_event("framereceived", timeout=60_000)


PAGE_LAUNCH = """
launch:
- node:
    pkg: rviz2
    exec: rviz2
    name: rviz
    args: --host 0.0.0.0 --port 0
"""


def holders(ros: RosGraph, token: str) -> list[str]:
    """Names of the files in which a token stands, whatever mode they have."""
    return [
        path.name
        for path in ros.folder.rglob("*")
        if path.is_file() and token in path.read_text(errors="replace")
    ]


@pytest.fixture
def own_token(ros):
    """The token of the user's own file, which is not there yet."""
    ros.env["XDG_STATE_HOME"] = str(ros.folder / "state")
    ros.env["HOME"] = str(ros.folder)
    (ros.folder / "page.launch.yaml").write_text(PAGE_LAUNCH)


@pytest.mark.parametrize(
    "words",
    [
        *("run -d rviz2 rviz2 --host 0.0.0.0 --port 0", "launch -d page.launch.yaml"),
        "run -d foxglove_bridge foxglove_bridge --ros-args -p port:=0 -p address:=0.0.0.0",
    ],
)
@pytest.mark.usefixtures("own_token")
def test_the_token_is_shown_once_and_stands_in_no_file_but_its_own(ros, words):
    done = ros.run(words, 60)
    assert done.returncode == 0, done.stderr
    (token,) = re.findall(r"\?token=(\S+)$", done.stdout, re.MULTILINE)
    assert holders(ros, token) == ["token"]
    assert token not in ros.run("ps").stdout
    for process in psutil.process_iter(["cmdline"]):
        assert token not in " ".join(process.info["cmdline"] or [])


@pytest.mark.skipif(sys.platform == "win32", reason="There are no pseudo-terminals")
@pytest.mark.parametrize(
    "words", sample(["run rviz2 rviz2 --host 0.0.0.0 --port 0", "launch page.launch.yaml"], 2)
)
@pytest.mark.usefixtures("own_token")
def test_on_a_terminal_it_is_shown_too(ros, words):
    from tests.system.terminal import Terminal

    argv = [sys.executable, "-m", "teleopctl", *words.split()]
    terminal = Terminal(argv, ros.env, ros.folder)
    try:
        token = terminal.until(r"\?token=([\w-]+)[^\n]*\n", 60)[1]
        assert terminal.text.count("token=") == 1
        assert holders(ros, token) == ["token"]
    finally:
        terminal.close()


def test_a_token_among_the_arguments_is_refused(ros):
    for program in ("rviz2 rviz2", "joint_state_publisher_gui joint_state_publisher_gui"):
        done = ros.run(f"run {program} --host 0.0.0.0 --token s3cret")
        assert done.returncode == 2
        assert "--token-file" in done.stderr
        assert "s3cret" not in done.stderr
