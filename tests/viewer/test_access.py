"""Who may open the page."""

from http import HTTPStatus

import pytest
from hypothesis import given, strategies

from teleopctl.viewer.page.access import Access, is_loopback

TOKEN = "s3cret"


def status(access, path="/", **headers):
    answer = access.check(path, {"host": "localhost:8080", **headers})
    return None if answer is None else answer.status


@pytest.mark.parametrize("host", ["localhost:8080", "127.0.0.1:8080", "[::1]:8080", "LOCALHOST"])
def test_this_machine_may_open_a_page_on_loopback(host):
    assert status(Access("127.0.0.1"), host=host) is None


@pytest.mark.parametrize("host", ["evil.com", "evil.com:8080", "", "192.168.0.7:8080", "[::1"])
def test_a_foreign_name_that_leads_to_this_machine_is_refused(host):
    assert status(Access("127.0.0.1"), host=host) == HTTPStatus.FORBIDDEN


@pytest.mark.parametrize(
    "origin", ["http://evil.com", "null", "http://localhost:9999", "http://localhost", ""]
)
def test_a_page_from_elsewhere_may_not_talk_to_this_one(origin):
    access = Access("127.0.0.1")
    assert status(access, origin=origin, upgrade="websocket") == HTTPStatus.FORBIDDEN
    assert status(access, origin="http://localhost:8080", upgrade="websocket") is None


def test_beyond_loopback_a_page_has_a_token():
    with pytest.raises(ValueError, match="token"):
        Access("0.0.0.0")


def test_the_token_comes_with_the_address_once_and_as_a_cookie_from_then_on():
    access = Access("0.0.0.0", TOKEN)
    host = {"host": "robot:8080"}
    assert status(access, **host) == HTTPStatus.FORBIDDEN
    first = access.check(f"/?token={TOKEN}", host)
    assert first is not None
    assert first.status == HTTPStatus.FOUND
    said = dict(first.headers)
    assert said["Location"] == "/"
    cookie, *attributes = said["Set-Cookie"].split("; ")
    assert {"HttpOnly", "SameSite=Strict"} <= set(attributes)
    assert status(access, **host, cookie=cookie) is None
    assert status(access, **host, cookie=cookie, origin="http://evil.com") == HTTPStatus.FORBIDDEN


@given(strategies.text())
def test_nothing_but_the_token_opens_the_page(text):
    access = Access("0.0.0.0", TOKEN)
    for answer in (
        access.check(f"/?token={text}", {"host": "robot"}),
        access.check("/", {"host": "robot", "cookie": f"teleopctl={text}"}),
    ):
        assert (answer is None or answer.status != HTTPStatus.FORBIDDEN) == (
            text.strip() in (TOKEN, f'"{TOKEN}"')
        )


@given(strategies.dictionaries(strategies.sampled_from(["host", "origin", "cookie"]),
                               strategies.text()), strategies.text())  # fmt: skip
def test_no_request_is_too_strange_to_be_decided(headers, path):
    for access in (Access("127.0.0.1"), Access("0.0.0.0", TOKEN)):
        access.check(path, headers)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "example.com", "10.0.0.1", "localhost.evil.com"])
def test_only_loopback_is_loopback(host):
    assert not is_loopback(host)
