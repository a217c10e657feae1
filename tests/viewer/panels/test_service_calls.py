"""Calls of the page's panels to services of other nodes."""

import pytest

from teleopctl.interfaces import get_service
from teleopctl.viewer import service_calls
from teleopctl.viewer.service_calls import ServiceCalls

Trigger = get_service("std_srvs/srv/Trigger")


def test_a_server_that_appears_a_moment_later_is_called_once(live, ros):
    calls = ServiceCalls(live)
    asked: list[object] = []
    ended: list[str] = []

    def answer(request, response):
        asked.append(request)
        response.message = "done"
        return response

    calls.call(
        "/job",
        "std_srvs/srv/Trigger",
        lambda response: ended.append(response.message),
        ended.append,
    )
    assert calls.is_waiting
    ros.node.create_service(Trigger, "/job", answer)
    live.until(lambda: ended)
    assert (ended, len(asked), calls.is_waiting) == (["done"], 1, False)


def test_a_service_without_a_server_is_named(live, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(service_calls, "_FOUND_S", 0.1)
    calls = ServiceCalls(live)
    ended: list[str] = []
    calls.call("/job", "std_srvs/srv/Trigger", lambda _: ended.append("answered"), ended.append)
    live.until(lambda: ended)
    assert (ended, calls.is_waiting) == (["/job has no server"], False)
