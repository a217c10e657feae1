"""Lines that strangers cause."""

from teleopctl.node import LogOnce


def test_a_mistake_is_logged_once_and_then_at_each_power_of_ten():
    lines: list[str] = []
    log = LogOnce(lines.append)
    for _ in range(1234):
        log.note("odd")
    assert lines == ["odd", *(f"odd ({count} times by now)" for count in (10, 100, 1000))]


def test_whoever_makes_up_kinds_does_not_fill_the_log():
    lines: list[str] = []
    log = LogOnce(lines.append)
    for number in range(10_000):
        log.note(f"odd {number}")
    assert len(lines) < 40
