"""Requests that a door admits, and those that it refuses."""

from http import HTTPStatus

import pytest
from hypothesis import given, strategies

from teleopctl.base.access import Access, is_loopback, parse_origin, with_token

TOKEN = "s3cret"
FOXGLOVE = "https://app.foxglove.dev"
ELECTRON = "Mozilla/5.0 (X11) AppleWebKit/537.36 foxglove-studio/2.1 Chrome/1 Electron/40.1"
CHROME = "Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 Chrome/156.0.0.0 Safari/537.36"


def status(access, path="/", **headers):
    named = {"host": "localhost:8080", **{n.replace("_", "-"): v for n, v in headers.items()}}
    answer = access.check(path, named.items())
    return None if answer is None else answer.status


@pytest.mark.parametrize(
    "host",
    ["localhost:8080", "127.0.0.1:8080", "[::1]:8080", "LOCALHOST", "localhost.:80", "[0::1]"],
)
def test_this_machine_may_open_a_page_on_loopback(host):
    assert status(Access("127.0.0.1"), host=host) is None


@pytest.mark.parametrize(
    "host",
    ["evil.com", "evil.com:8080", "192.168.0.7:8080", "localhost.evil.com", "0.0.0.0:8080"],
)
def test_a_foreign_name_that_leads_to_this_machine_is_refused(host):
    assert status(Access("127.0.0.1"), host=host) == HTTPStatus.FORBIDDEN


@pytest.mark.parametrize(
    "host",
    [
        *("", "[::1", "localhost:", "localhost:80:80", "localhost@evil.com", "localhost:99999"),
        *("localhost/", "localhost#", "[::1%lo]", "local host", "localhost..", "a" * 9000 + "-"),
    ],
)
def test_a_host_that_is_none_is_refused(host):
    assert status(Access("127.0.0.1"), host=host) == HTTPStatus.BAD_REQUEST


@pytest.mark.parametrize("name", ["Host", "Origin"])
def test_a_header_that_comes_twice_is_refused(name):
    headers = [("Host", "localhost"), ("Origin", "http://localhost"), (name, "http://evil.com")]
    answer = Access("127.0.0.1").check("/", headers)
    assert answer is not None
    assert answer.status == HTTPStatus.BAD_REQUEST
    assert Access("127.0.0.1").check("/", [])


@pytest.mark.parametrize(
    "origin",
    [
        *("http://evil.com", "null", "http://localhost:9999", "http://localhost", "", "file://"),
        *("http://localhost:8080@evil.com", "http://localhost:8080.evil.com", "localhost:8080"),
        *("http://localhost:8080/", "app://localhost:8080", "http://127.0.0.1:8080", "//", ":"),
    ],
)
def test_a_page_from_elsewhere_may_not_talk_to_this_one(origin):
    access = Access("127.0.0.1")
    assert status(access, origin=origin, upgrade="websocket") == HTTPStatus.FORBIDDEN


def test_the_page_itself_may_whatever_its_letters_and_ports():
    access = Access("127.0.0.1")
    assert status(access, origin="http://localhost:8080", upgrade="websocket") is None
    assert status(access, origin="http://LocalHost:8080", upgrade="websocket") is None
    assert status(access, host="localhost:80", origin="http://localhost") is None
    assert status(access, host="[::1]:443", origin="https://[0::1]") is None
    assert status(access, host="[::1]:443", origin="http://[::1]") == HTTPStatus.FORBIDDEN


def test_origins_that_the_user_admits_may():
    access = Access("127.0.0.1", origins=[FOXGLOVE, "http://localhost:3000"])
    assert status(access, origin=FOXGLOVE) is None
    assert status(access, origin="http://localhost:3000") is None
    for origin in (
        "http://app.foxglove.dev",
        f"{FOXGLOVE}:444",
        "https://app-foxglove.dev",
        "null",
    ):
        assert status(access, origin=origin) == HTTPStatus.FORBIDDEN
    assert status(access, host="evil.com", origin=FOXGLOVE) == HTTPStatus.FORBIDDEN


def test_files_are_admitted_of_electron_apps_and_not_of_browsers():
    access = Access("127.0.0.1", origins=["file://"])
    assert status(access, origin="file://", user_agent=ELECTRON) is None
    assert status(access, origin="file://", user_agent=CHROME) == HTTPStatus.FORBIDDEN
    assert status(access, origin="null", user_agent=ELECTRON) == HTTPStatus.FORBIDDEN
    assert status(Access("127.0.0.1"), origin="file://", user_agent=ELECTRON)


@pytest.mark.parametrize(
    ("text", "origin"),
    [
        ("https://App.Foxglove.dev:443", FOXGLOVE),
        ("http://localhost:3000", "http://localhost:3000"),
        ("http://[0::1]:80", "http://[::1]"),
        ("app://index.html", "app://index.html"),
        ("file://", "file://"),
    ],
)
def test_origins_are_read_as_browsers_send_them(text, origin):
    assert parse_origin(text) == origin


@pytest.mark.parametrize(
    "text", ["null", "*", "", "https://", "https://a.b/", "https://*.b", "a.b"]
)
def test_what_is_no_origin_cannot_be_admitted(text):
    with pytest.raises(ValueError, match="not an origin"):
        parse_origin(text)


def test_beyond_loopback_a_door_has_a_token():
    with pytest.raises(ValueError, match="token"):
        Access("0.0.0.0")


@pytest.mark.parametrize("token", [TOKEN, 'a "b" c; d=%41+&#?', "grün ☃", " ", "\\", "'"])
def test_the_token_comes_with_the_address_once_and_as_a_cookie_from_then_on(token):
    access = Access("0.0.0.0", token)
    host = {"host": "robot:8080"}
    assert status(access, **host) == HTTPStatus.FORBIDDEN
    path = with_token("/", token)
    first = access.check(path, host.items())
    assert first is not None
    assert first.status == HTTPStatus.FOUND
    said = dict(first.headers)
    assert said["Location"] == "/"
    cookie, *attributes = said["Set-Cookie"].split("; ")
    assert attributes == ["HttpOnly", "SameSite=Lax", "Path=/"]
    assert cookie.isascii()
    assert token == " " or token not in cookie
    # Other programs on the host have cookies too, and odd ones.
    cookie = f'other={{"a": [1, "b"]}}; {cookie}; more'
    assert status(access, **host, cookie=cookie) is None
    assert status(access, **host, cookie=cookie, origin="http://evil.com") == HTTPStatus.FORBIDDEN
    # Clients that keep no cookies show it with each websocket.
    assert status(access, path, **host, upgrade="websocket") is None


@pytest.mark.parametrize(
    ("path", "page"),
    [("/drive", "/drive"), ("//evil.com/", "/evil.com/"), ("/\\evil.com", "/evil.com")],
)
def test_the_answer_to_a_token_leads_to_a_page_of_the_same_server(path, page):
    answer = Access("0.0.0.0", TOKEN).check(with_token(path, TOKEN), [("host", "robot")])
    assert answer is not None
    assert dict(answer.headers)["Location"] == page


def test_bytes_of_a_request_are_those_of_a_token():
    access = Access("0.0.0.0", "grün")
    raw = "/?token=grün".encode().decode("ascii", "surrogateescape")
    assert status(access, raw) == HTTPStatus.FOUND
    assert status(access, b"/?token=gr\xfcn".decode("ascii", "surrogateescape")) == 403
    assert status(access, "/?token=gr\ud800n") == HTTPStatus.FORBIDDEN


def test_a_token_that_is_given_twice_is_none():
    access = Access("0.0.0.0", TOKEN)
    assert status(access, f"/?token={TOKEN}&token={TOKEN}") == HTTPStatus.FORBIDDEN


@given(strategies.text())
def test_nothing_but_the_token_opens_the_page(text):
    access = Access("0.0.0.0", TOKEN)
    answer = access.check(with_token("/", text), [("host", "robot")])
    assert (answer is not None and answer.status == HTTPStatus.FOUND) == (text == TOKEN)
    for cookie in (text, f"teleopctl={text}", f"teleopctl-00000000={text}", TOKEN):
        assert status(access, cookie=cookie) == HTTPStatus.FORBIDDEN


@given(
    strategies.lists(
        strategies.tuples(
            strategies.sampled_from(["host", "origin", "cookie", "upgrade"]),
            strategies.text() | strategies.sampled_from(["localhost", "http://localhost", "["]),
        )
    ),
    strategies.text(),
)
def test_no_request_is_too_strange_to_be_decided(headers, path):
    for access in (Access("127.0.0.1"), Access("0.0.0.0", TOKEN)):
        access.check(path, headers)


def test_an_address_that_no_file_has_is_too_long():
    assert status(Access("127.0.0.1"), "/" + "a" * 5000) == HTTPStatus.REQUEST_URI_TOO_LONG


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "example.com", "10.0.0.1", "localhost.evil.com"])
def test_only_loopback_is_loopback(host):
    assert not is_loopback(host)
