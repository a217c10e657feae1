"""What is refused is counted, and reported at a pace that people can read."""

import pytest

from teleopctl.wire import invalid_messages
from teleopctl.wire.invalid_messages import InvalidMessageCounter


class _Time:
    """A clock that stands until it is turned."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def monotonic(self) -> float:
        return self.now_s


def test_the_first_is_reported_at_once_and_a_flood_once_a_second(monkeypatch: pytest.MonkeyPatch):
    clock = _Time()
    monkeypatch.setattr(invalid_messages, "time", clock)
    lines: list[str] = []
    source = InvalidMessageCounter("a message on '/clock'", lines.append)
    for _ in range(1000):
        source.refuse("it ends too early")
    assert lines == ["dropped a message on '/clock': it ends too early"]
    clock.now_s += 1.0
    source.refuse("it ends too early")
    assert lines[1:] == [
        "dropped a message on '/clock': it ends too early (and 999 before it)",
    ]
    assert source.count == 1001


def test_sources_do_not_hide_each_other():
    lines: list[str] = []
    for topic in ("/a", "/b"):
        InvalidMessageCounter(f"a message on '{topic}'", lines.append).refuse("x")
    assert lines == ["dropped a message on '/a': x", "dropped a message on '/b': x"]


def test_a_report_may_refuse_again():
    # A report is published on /rosout, to which the same process may listen.
    source: InvalidMessageCounter

    def report(text: str) -> None:
        del text
        source.refuse("again")

    source = InvalidMessageCounter("a message", report)
    source.refuse("once")
    assert source.count == 2
